# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What two eyes see in a shiny ball: path traced, by a radiance texture, and by a reflection probe.

    python -m tests.bench.stereo OUT.png [--texels 128] [--samples 8]

Things stand near the ball. A mirror image of a near thing lies behind the surface, at another depth than the
surface or the horizon, and the difference between the eyes' pictures says so. A probe is one panorama from
the ball's middle, looked up by the mirrored direction: what it mirrors is at infinity for both eyes. Each
row of the picture: left eye, right eye, and both as red and cyan. For each the dB to the path-traced picture
of the worse eye, and of the difference between the eyes.
"""

from __future__ import annotations

import argparse
import tempfile
from math import pi
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from PIL import Image
from scipy.ndimage import map_coordinates

from radtex_addon.report.finished_bake import read_bake
from radtex_addon.report.gbuffer import Array, GBuffer
from radtex_addon.report.metrics import Mask, psnr
from radtex_addon.settings.spec import BakeSpec, Layout
from tests.bench.gallery.looking import (
    SUBJECT,
    Camera,
    added,
    baked,
    empty_scene,
    principled,
    render_open_scene,
    rendered,
    studio,
    tiles,
)

_COLOUR = (0.9, 0.88, 0.85)  # of the ball's metal
_EYES = (Camera((-0.2, -4.6, 0.9)), Camera((0.2, -4.6, 0.9)))
_WIDE = 1024  # pixels of the panorama


def main() -> None:
    """Save the picture and print the figures."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("out", type=Path)
    parser.add_argument("--texels", type=int, default=128)
    parser.add_argument("--samples", type=int, default=8)
    asked = parser.parse_args()
    for name, (worse, apart) in both_eyes(asked.texels, asked.samples, 0, asked.out).items():
        print(f"{name}: {worse:.1f} dB, the difference between the eyes {apart:.1f} dB", flush=True)


def both_eyes(
    texels: int, samples: int, seed: int, picture: Path | None = None
) -> dict[str, tuple[float, float]]:
    """Bake and look from both eyes: the worse eye's dB, and those of the difference, by what is looked up."""
    _scene()
    spec = BakeSpec(layout=Layout.LAYERED, texels=texels, samples=samples, seed=seed, denoise=True)
    with tempfile.TemporaryDirectory() as folder:
        bake = baked(spec, Path(folder))
        look = read_bake(bake.sidecar).radiance
        buffers = [bake.seen(eye) for eye in _EYES]
        ours = [seen.resolve(look(seen)) for seen in buffers]
    panorama = _panorama()
    probes = [seen.resolve(_by_probe(seen, panorama)) for seen in buffers]
    truth = [rendered(eye)[..., :3] for eye in _EYES]
    masks = [seen.eroded for seen in buffers]
    rows = {"path traced": truth, "radiance texture": ours, "reflection probe": probes}
    if picture is not None:
        _save(picture, [[_masked(*each) for each in zip(pair, masks, strict=True)] for pair in rows.values()])
    return {name: _told(pictures, truth, masks) for name, pictures in rows.items() if pictures is not truth}


def _scene() -> None:
    """A metal ball between near posts, on tiles, under an HDRI."""
    empty_scene()
    studio(turn=60, name="courtyard.exr")
    added(
        "uv_sphere",
        SUBJECT,
        principled("Metal", _COLOUR, Metallic=1.0, Roughness=0.05),
        segments=96,
        ring_count=48,
    )
    added("plane", "Floor", tiles(2.0, 0.6), size=9, location=(0, 0, -1.02))
    colours = [(0.8, 0.1, 0.08), (0.1, 0.5, 0.15), (0.1, 0.2, 0.8), (0.85, 0.6, 0.1)]
    for number, colour in enumerate(colours):
        place = (-2.4 + 1.6 * number, -2.1 - 0.5 * (number % 2), -0.4)
        added(
            "cylinder",
            f"Post{number}",
            principled(f"Paint{number}", colour),
            radius=0.16,
            depth=1.3,
            location=place,
        )


def _panorama() -> Array:
    """What surrounds the ball's middle, without the ball: (H, 2 H, 3) from the top, its middle along +y."""
    scene: Any = bpy.context.scene
    subject: Any = bpy.data.objects[SUBJECT]
    subject.hide_render = True
    data: Any = bpy.data.cameras.new("Panorama")
    data.type = "PANO"
    setter = data if hasattr(data, "panorama_type") else data.cycles  # Blender 4.5
    setter.panorama_type = "EQUIRECTANGULAR"
    item: Any = bpy.data.objects.new("Panorama", data)
    item.rotation_euler = (pi / 2, 0, 0)
    scene.collection.objects.link(item)
    scene.camera = item
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = _WIDE, _WIDE // 2
    scene.cycles.samples, scene.cycles.use_denoising = 64, True
    panorama = render_open_scene()[..., :3]
    bpy.data.objects.remove(item)
    subject.hide_render = False
    return panorama


def _by_probe(seen: GBuffer, panorama: Array) -> Array:
    """The metal's light (N, 3) by the panorama in the mirrored direction, tinted by Schlick's Fresnel."""
    N, V = seen.normal, seen.incoming
    facing = np.sum(N * V, axis=1, keepdims=True)
    R = 2 * facing * N - V
    across = (np.arctan2(R[:, 0], R[:, 1]) / (2 * pi) + 0.5) * _WIDE - 0.5
    down = (0.5 - np.arcsin(np.clip(R[:, 2], -1, 1)) / pi) * (_WIDE // 2) - 0.5
    light = np.column_stack(
        [map_coordinates(panorama[..., k], [down, across], order=1, mode="grid-wrap") for k in range(3)]
    )
    colour = np.array(_COLOUR)
    tint = colour + (1 - colour) * np.clip(1 - facing, 0, 1) ** 5
    return np.where(seen.hit[:, None], light * tint, 0.0)


def _told(pictures: list[Array], truth: list[Array], masks: list[Mask]) -> tuple[float, float]:
    each = [psnr(picture, wanted, mask) for picture, wanted, mask in zip(pictures, truth, masks, strict=True)]
    both = masks[0] & masks[1]
    shown, wanted = (
        np.diff([_display(each) for each in pair], axis=0)[0][both] for pair in (pictures, truth)
    )
    return min(each), float(10 * np.log10(1 / np.mean((shown - wanted) ** 2)))


def _display(light: Array) -> Array:
    shown: Array = np.clip(light, 0, 1) ** (1 / 2.2)
    return shown


def _masked(light: Array, mask: Mask) -> Array:
    return _display(light) * mask[..., None]


def _save(path: Path, rows: list[list[Array]]) -> None:
    """Rows of left, right, and both as red and cyan."""
    lines = []
    for left, right in rows:
        grey = [each @ [0.3, 0.59, 0.11] for each in (left, right)]
        lines.append(np.hstack([left, right, np.stack([grey[0], grey[1], grey[1]], axis=-1)]))
    Image.fromarray(np.round(np.vstack(lines) * 255).astype(np.uint8)).save(path)


if __name__ == "__main__":
    main()
