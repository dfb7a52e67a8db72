# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The still life from a view that was not baked: path traced on the left of a thin line, baked on its right.

Each of the three pots is baked alone, as by somebody who names nothing, and shown by its preview in
its place; table and fruit are path traced on both sides.
"""

from __future__ import annotations

import inspect
import json
import tempfile
from hashlib import sha256
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np
from PIL import Image, ImageDraw

from radtex_addon.core.sampler import Filter
from radtex_addon.job import bake_object
from radtex_addon.preview.swap import switch_on
from radtex_addon.report.gbuffer import eroded
from radtex_addon.report.metrics import Mask, Picture, psnr
from radtex_addon.scene.nodes import open_material
from radtex_addon.settings.spec import BakeSpec, Layout

from ..gallery.looking import Camera, rendered
from . import still_life
from .encode import as_image, captioned, graded, save_png
from .still_life import POTS, hero_scene

SIZE = 1920, 1080  # of what is rendered
HERO = 1600, 700  # of hero.png, which is a part of that, smaller
SAMPLES = 20  # of a pixel, before it is denoised
CAMERA = Camera((0.15, -8.6, 2.7), (0.06, 0.0, 1.06), lens=46)
SPEC = BakeSpec(layout=Layout.LAYERED)
_EXPOSURE = 0.8  # times the light, in what is shown
_MOST_BYTES = 700_000
_FILLED = 0.99  # of a pixel
_CACHE = Path(tempfile.gettempdir(), "radtex-hero")


def make(folder: Path) -> None:
    """Bake, render, save hero.png and hero.json in a folder; the pictures are kept for `listing`."""
    hero_scene()
    traced = rendered(CAMERA, SAMPLES, size=SIZE)[..., :3]
    masks = {name: _seen(name) for name in POTS}
    for name, sidecar in {name: _sidecar(name) for name in POTS}.items():
        switch_on(bpy.data.objects[name], sidecar)
    baked = rendered(CAMERA, SAMPLES, size=SIZE)[..., :3]
    np.savez_compressed(
        _CACHE / "pictures.npz", traced=traced.astype(np.float32), baked=baked.astype(np.float32)
    )
    decibels = {name: round(psnr(baked, traced, mask), 1) for name, mask in masks.items()}
    print(decibels, flush=True)
    size = save_png(folder / "hero.png", as_image(split(*pictures())), _MOST_BYTES)
    facts = {
        "blender": bpy.app.version_string,
        "preview": "Cycles",
        "samples of a pixel": SAMPLES,
        "texels": SPEC.texels,
        "decibels": dict(sorted(decibels.items(), key=lambda item: item[1])),
        "bytes": size,
    }
    (folder / "hero.json").write_text(json.dumps(facts, indent=1) + "\n")


def _sidecar(name: str) -> Path:
    """The bake of one pot of the open scene, made unless it lies in the cache."""
    folder = _CACHE / _key(name) / name
    found = folder / f"{name}.radiance.json"
    if found.is_file():
        return found
    made = bake_object(cast(Any, bpy.context.scene), name, SPEC, folder, preview=Filter.QUADRILINEAR)
    print(f"{name}: {made.paths / 1e6:.1f} M paths", flush=True)
    return made.files.sidecar


def _key(name: str) -> str:
    """A hash of what decides a bake of the still life."""
    decided = f"{inspect.getsource(still_life)}\n{SPEC!r}\n{bpy.app.version_string}\n{name}"
    return sha256(decided.encode()).hexdigest()[:16]


def pictures() -> tuple[Picture, Picture]:
    """Path traced and baked, linear (1080, 1920, 3), as bright as they are shown; `make` must have run."""
    with np.load(_CACHE / "pictures.npz") as kept:
        return _EXPOSURE * kept["traced"].astype(np.float64), _EXPOSURE * kept["baked"].astype(np.float64)


def split(traced: Picture, baked: Picture, size: tuple[int, int] = HERO, captions: bool = True) -> Picture:
    """Display values of a part `size` wide and high: left path traced, right baked, a thin line between."""
    width, height = size
    rows = round(SIZE[0] * height / width)
    top = (SIZE[1] - rows) // 2
    middle = SIZE[0] // 2
    joined = np.concatenate([traced[:, :middle], baked[:, middle:]], axis=1)[top : top + rows]
    image = as_image(graded(joined)).resize(size, Image.Resampling.LANCZOS)
    ImageDraw.Draw(image).line([(width // 2, 0), (width // 2, height)], fill=(250, 248, 244), width=2)
    if not captions:
        return np.asarray(image, dtype=np.float64) / 255
    shown = captioned(np.asarray(image, dtype=np.float64) / 255, "Path traced by Cycles", 22)
    return captioned(shown, "Baked by RadTex", 22, right=True)


def _seen(name: str) -> Mask:
    """The pixels that one object alone fills, without the outermost: of a picture in which only it shines."""
    scene: Any = bpy.context.scene
    glow, build = open_material("Mask")
    build.node("ShaderNodeOutputMaterial", build.node("ShaderNodeEmission").outputs[0])
    slot: Any = bpy.data.objects[name].material_slots[0]
    material, world, bounces = slot.material, scene.world, scene.cycles.max_bounces
    lamps = [item for item in scene.objects if item.type == "LIGHT"]
    slot.material, scene.world, scene.cycles.max_bounces = glow, None, 0
    for item in lamps:
        item.hide_render = True
    try:
        alone = rendered(CAMERA, 4, denoised=False, size=SIZE)[..., 0]
    finally:
        slot.material, scene.world, scene.cycles.max_bounces = material, world, bounces
        for item in lamps:
            item.hide_render = False
        bpy.data.materials.remove(glow)
    return eroded(alone > _FILLED)
