# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Layers of one bake against Cycles's own passes: python -m tests.bench.gallery layers"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from radtex_addon.bake.layers import Layer
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.sampler import Filter, sample
from radtex_addon.cycles.building_blocks import render_layers
from radtex_addon.cycles.capture_settings import keep_passes
from radtex_addon.cycles.passes import Passes, attributes_of, light_of
from radtex_addon.formats.bucket_files import read_layer
from radtex_addon.formats.sidecar import read_sidecar
from radtex_addon.report.gbuffer import Array, GBuffer
from radtex_addon.settings.spec import BakeSpec

from .looking import PIXELS, SUBJECT, Baked, Camera, added, baked, empty_scene, lamp, principled
from .row import Row

PASSES = (Layer.DIFFUSE, Layer.GLOSSY)
SPEC = BakeSpec(denoise=True, texels=128, bucket=8, samples=12, layers=(*PASSES, Layer.BASE, Layer.REST))
SAMPLES = 128  # of a reference's pixel: passes are not denoised
CAMERAS = {
    "left": Camera((-2.2, -4.2, 0.7)),
    "above": Camera((0.6, -3.4, 3.0)),
}


def scene() -> None:
    """A head of blue clay with a satin gloss, between a warm lamp and a red wall."""
    empty_scene((0.2, 0.22, 0.26))
    lamp((-3.0, -3.5, 3.5), watts=260, size=2.5)
    clay = principled("Clay", (0.12, 0.3, 0.6), Roughness=0.45, Specular_IOR_Level=0.9)
    head = added("monkey", SUBJECT, clay)
    subdivision = head.modifiers.new("Subdivision", "SUBSURF")
    subdivision.levels = subdivision.render_levels = 2
    bpy.ops.object.shade_smooth()
    added(
        "plane",
        "Wall",
        principled("Wall", (0.7, 0.1, 0.06)),
        size=6,
        location=(0, 2.2, 0),
        rotation=(1.57, 0, 0),
    )


def rows(spec: BakeSpec = SPEC) -> Iterator[Row]:
    """The gallery's rows: diffuse, glossy, and base plus rest, from two sides."""
    scene()
    with tempfile.TemporaryDirectory() as folder:
        bake = baked(spec, Path(folder))
        for name, camera in CAMERAS.items():
            seen, truth = bake.seen(camera), _passes(camera)
            ours = {str(layer): _looked(bake, layer, seen) for layer in spec.layers}
            ours["base plus rest"] = ours.pop("base") + ours.pop("rest")
            theirs = {str(layer): light_of(truth, layer) for layer in PASSES}
            theirs["base plus rest"] = truth.whole[..., :3]
            for layer, light in ours.items():
                reference = theirs[layer][::-1].astype(np.float64)
                yield Row(f"Layers, {layer}, {name}", reference, seen.resolve(light), seen.eroded, bake.words)


def _looked(bake: Baked, layer: Layer, seen: GBuffer) -> Array:
    """A layer along all rays, (N, 3), zero beside the object; the base has buckets of one cell."""
    facts = read_sidecar(bake.sidecar)
    layout = AtlasLayout(facts.width, facts.height, 1 if layer is Layer.BASE else facts.bucket)
    pixels = read_layer(bake.sidecar, layer).astype(np.float32)
    uv, incidence = seen.uv[seen.hit], seen.incidence[seen.hit]
    return seen.spread(sample(pixels, layout, uv, incidence, Filter.QUADRILINEAR))


def _passes(camera: Camera) -> Passes:
    """The passes that Cycles makes of the open scene, (PIXELS, PIXELS, C) from the bottom row on."""
    scene: Any = bpy.context.scene
    data: Any = bpy.data.cameras.new("Camera")
    data.lens, data.clip_start = camera.lens, 0.01
    item: Any = bpy.data.objects.new("Camera", data)
    item.location, item.rotation_mode, item.rotation_quaternion = camera.place, "QUATERNION", camera.turn
    scene.collection.objects.link(item)
    scene.camera, scene.render.engine = item, "CYCLES"
    scene.render.resolution_x = scene.render.resolution_y = PIXELS
    scene.cycles.samples, scene.cycles.use_adaptive_sampling = SAMPLES, False
    scene.cycles.use_denoising = False
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BOX", 1.0
    keep_passes(scene, tuple(name for layer in PASSES for name in attributes_of(layer)))
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "view.exr")
        scene.render.filepath = str(file)
        found = render_layers(scene, file)
    bpy.data.objects.remove(item)
    return found
