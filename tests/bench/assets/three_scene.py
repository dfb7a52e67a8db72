# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The asset without any bake, by three.js: the artist's own images in MeshPhysicalMaterial, lit by a probe.

Blender exports the whole scene as glTF. The probe is a panorama by Cycles from the asset's middle, without
the asset, which three.js filters by roughness (PMREM). Ambient occlusion is what the images have. Point, spot
and sun lamps are lights with shadows. Pictures are linear, of SUBSAMPLES² times as many pixels with MSAA.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np

from radtex_addon.core.arrays import Floats
from radtex_addon.core.errors import InputError
from radtex_addon.report.metrics import Picture
from tests.real.browser import TO_GLTF, decoded
from tests.real.exhibit import Camera
from tests.real.web import SOURCES, Site, install_packages, node

from .programs import averaged
from .views import SUBSAMPLES, Pictures, bounds

PAGE = Path(__file__).parent / "three_page.js"
HEIGHT, SAMPLES = 1024, 64  # of the probe's picture, and of its pixels
_BRIGHTEST = 65504.0  # of half floats
_HTML = '<!doctype html><meta charset="utf-8"><body></body><script type="module" src="page.js"></script>'


def write_page(pictures: Pictures, objects: list[str], folder: Path) -> None:
    """Write the page of the open scene, which is that of `pictures`, into a new folder.

    Raises InputError for lamps that neither glTF nor three.js has as Blender has them.
    """
    folder.mkdir(parents=True, exist_ok=True)
    scene: Any = bpy.context.scene
    areas = [item.name for item in scene.objects if item.type == "LIGHT" and item.data.type == "AREA"]
    if areas:
        raise InputError(f"area lamp {areas[0]} has no counterpart in glTF: make it a mesh that emits light")
    middle = np.mean(bounds(objects), axis=0)
    write_halves(pictures.panorama(middle, objects, HEIGHT, SAMPLES)[::-1], folder / "probe.bin")
    (folder / "lights.json").write_text("[]", encoding="utf-8")
    export_scene(folder, lamps=True)
    bundle_page(folder)


def write_halves(picture: Picture | Floats, file: Path) -> None:
    """Write a linear picture (H, W, 3) as half floats, RGBA, its rows in their order."""
    values = np.ones((*picture.shape[:2], 4), np.float16)
    values[..., :3] = np.clip(picture, 0, _BRIGHTEST)
    file.write_bytes(values.tobytes())


def export_scene(folder: Path, *, lamps: bool) -> None:
    """Export the open scene as the page's scene.glb, with what renders show, and custom properties."""
    cast(Any, bpy.ops.preferences).addon_enable(module="io_scene_gltf2")
    bpy.ops.export_scene.gltf(
        filepath=str(folder / "scene.glb"),
        export_format="GLB",
        use_renderable=True,
        export_apply=True,
        export_tangents=True,
        export_extras=True,
        export_lights=lamps,
        export_import_convert_lighting_mode="COMPAT",
    )


def bundle_page(folder: Path, page: Path = PAGE) -> None:
    """Write a page's index.html and script, with three.js and radtex-three, beside what they show."""
    (folder / "index.html").write_text(_HTML, encoding="utf-8")
    install_packages()
    node(
        *("npx", "esbuild", str(page), "--bundle", "--format=esm", f"--outfile={folder / 'page.js'}"),
        *("--alias:three=./node_modules/three", "--alias:three/addons=./node_modules/three/examples/jsm"),
        *(f"--alias:radtex-three={SOURCES / 'src/index.ts'}", "--loader:.glsl=text", "--log-level=error"),
    )


def pictures_by_three(site: Site, name: str, cameras: list[Camera]) -> list[Picture]:
    """What the page of that name below the site shows to each camera, rows from the top."""
    found = []
    with site.opened(f"{name}/") as shown:
        shown.page.wait_for_function("'picture' in window")
        for facts in shown.page.evaluate("materials()").items():
            print(*facts)
        for camera in cameras:
            side = SUBSAMPLES * camera.pixels
            matrix = (TO_GLTF @ np.array(camera.matrix)).ravel().tolist()
            asked = [matrix, float(np.radians(camera.fovy)), side]
            text = shown.page.evaluate("asked => picture(...asked)", asked)
            light = decoded(text).reshape(side, side, 4)[::-1, :, :3].astype(np.float64)
            found.append(averaged(light))
    return found
