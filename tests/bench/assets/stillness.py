# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How still is a picture that moves? Frames a quarter of a pixel apart, held against each other.

    python -m tests.bench.assets --seeds 1,2 --out DIR
    python -m tests.bench.assets.stillness DIR/seed-1 DIR/seed-2

Each folder has scene.blend and a bake in bake, as tests.bench.assets leaves them. The web page in Chromium
(MSAA of its canvas) and three.js's MeshPhysicalMaterial on the same scene (MSAA of 4 samples) are filmed at
1, 3 and 10 times the distance: the mean PSNR of one frame against the next, where both show the asset. At
rest: the first frame's PSNR against path tracing. `--godot` films Godot's renderers, too, whose rims have no
MSAA here. Leaves stillness.json in each folder.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import replace
from pathlib import Path

import bpy
import numpy as np

from radtex_addon.bake.progress import finished
from radtex_addon.export.exporting import export_steps
from radtex_addon.report.finished_bake import find_bakes_of_all, object_of, objects_and_frame
from radtex_addon.report.metrics import Mask, Picture, psnr
from radtex_addon.textures.export_spec import ExportSpec, Target
from tests.real.browser import TO_GLTF, Shown, decoded
from tests.real.exhibit import Camera
from tests.real.godot import RENDERERS, Shot, imported, pictures
from tests.real.root import Root
from tests.real.web import Site

from ..engines.__main__ import programs
from ..engines.programs import blended
from .three_scene import write_page
from .views import Pictures, bounds, scene_cameras

TIMES = (1, 3, 10)
FRAMES, STEP = 5, 0.25  # of each film, and pixels between one and the next
OURS, THREE = "RadTex", "MeshPhysicalMaterial"


def main() -> None:
    """Film each asset, print a table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folders", type=Path, nargs="+")
    parser.add_argument("--pixels", type=int, default=256)
    parser.add_argument("--ours-alone", action="store_true", help="without three.js's own material")
    parser.add_argument("--godot", action="store_true", help="Godot's renderers, too")
    asked = parser.parse_args()
    print("| asset | way | at rest, dB | " + " | ".join(f"{times} x, dB" for times in TIMES) + " |")
    print("|---|---|---|---|---|---|")
    for folder in asked.folders:
        found = _filmed(folder, asked.pixels, alone=asked.ours_alone, godot=asked.godot)
        (folder / "stillness.json").write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
        for way, figures in found.items():
            row = [folder.name, way, *(f"{value:.1f}" for value in figures)]
            print(f"| {' | '.join(row)} |", flush=True)


def _filmed(folder: Path, pixels: int, *, alone: bool, godot: bool) -> dict[str, list[float]]:
    """By way: PSNR at rest, and of one frame against the next at each of TIMES."""
    scene = folder / "scene.blend"
    bpy.ops.wm.open_mainfile(filepath=str(scene))
    camera = scene_cameras(pixels)[0]
    (sidecar,) = find_bakes_of_all(folder / "bake", "shown")
    objects = list(objects_and_frame(sidecar)[0])
    views = Pictures(scene, folder)
    reference = views.traced(camera)
    films = [_film(camera, objects, times) for times in TIMES]
    with programs(folder / "shown") as showing:
        site = showing.site
        finished(export_steps(sidecar.path, ExportSpec(Target.WEB), site.folder / "web", overwrite=True))
        ours, masks = _by_page(site, films, pixels)
        shown = {OURS: ours}
        if not alone:
            write_page(views, objects, site.folder / "three")
            shown[THREE] = _by_three(site, films)
        if godot:
            project = site.folder / "godot"
            finished(export_steps(sidecar.path, ExportSpec(Target.GODOT), project, overwrite=True))
            for renderer in RENDERERS:
                shown[f"Godot, {renderer}"] = _by_godot(showing.root, project, renderer, films)
    print(object_of(sidecar), flush=True)
    found = {}
    for way, frames in shown.items():
        rest = psnr(frames[0][0], reference, masks[0][0])
        found[way] = [rest, *(_still(film, mask) for film, mask in zip(frames, masks, strict=True))]
    return found


def _film(camera: Camera, objects: list[str], times: float) -> list[Camera]:
    """Cameras so many times as far from the objects' middle, each a part of a pixel beside the one before."""
    middle = np.mean(bounds(objects), axis=0)
    matrix = np.array(camera.matrix)
    away = (np.array(camera.place) - middle) * times
    depth = float(away @ matrix[:3, 2])
    pixel = 2 * depth * np.tan(np.radians(camera.fovy) / 2) / camera.pixels
    towards = np.array(camera.target) - np.array(camera.place)
    found = []
    for number in range(FRAMES):
        place = middle + away + matrix[:3, 0] * pixel * STEP * number
        if times > 1:  # at the middle, which may not be where the camera looks
            towards = -away
        found.append(replace(camera, place=tuple(place.tolist()), target=tuple((place + towards).tolist())))
    return found


def _by_page(
    site: Site, films: list[list[Camera]], pixels: int
) -> tuple[list[list[Picture]], list[list[Mask]]]:
    """What the page shows over black, and where that hides what lies behind."""
    black, white = (np.full((pixels, pixels, 3), value, dtype=np.float64) for value in (0.0, 1.0))
    with site.opened("web/", width=pixels, height=pixels, device_scale_factor=1) as shown:
        shown.wait()
        both = [[_over(shown, camera, (black, white)) for camera in film] for film in films]
    frames = [[over_black for over_black, _ in film] for film in both]
    masks = [[np.abs(one - other).max(axis=-1) < 0.02 for one, other in film] for film in both]
    return frames, masks


def _over(shown: Shown, camera: Camera, grounds: tuple[Picture, Picture]) -> tuple[Picture, Picture]:
    shown.set_camera(camera)
    one, other = (blended(shown, ground) for ground in grounds)
    return one, other


def _by_three(site: Site, films: list[list[Camera]]) -> list[list[Picture]]:
    with site.opened("three/") as shown:
        shown.page.wait_for_function("'picture' in window")
        return [[_by_physical(shown, camera) for camera in film] for film in films]


def _by_godot(root: Root, project: Path, renderer: str, films: list[list[Camera]]) -> list[list[Picture]]:
    place = imported(root, project)
    frames = iter(pictures(root, place, renderer, [Shot(camera) for film in films for camera in film]))
    return [[next(frames) for _ in film] for film in films]


def _by_physical(shown: Shown, camera: Camera) -> Picture:
    side = camera.pixels
    matrix = (TO_GLTF @ np.array(camera.matrix)).ravel().tolist()
    text = shown.page.evaluate("asked => picture(...asked)", [matrix, float(np.radians(camera.fovy)), side])
    light: Picture = decoded(text).reshape(side, side, 4)[::-1, :, :3].astype(np.float64)
    return light


def _still(frames: list[Picture], masks: list[Mask]) -> float:
    """The mean PSNR of one frame against the next, where both show the asset."""
    pairs = zip(frames, frames[1:], masks, masks[1:], strict=False)
    return float(np.mean([psnr(one, other, here & there) for one, other, here, there in pairs]))


if __name__ == "__main__":
    main()
