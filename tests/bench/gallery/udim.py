# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A ring whose UV layer lies in two UDIM tiles, an atlas for each: python -m tests.bench.gallery udim"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path
from time import perf_counter
from typing import Any, cast

import bpy
import numpy as np

from radtex_addon.core.sampler import Filter
from radtex_addon.job import bake_object, part_specs
from radtex_addon.report.finished_bake import read_bake
from radtex_addon.report.gbuffer import Array, eroded
from radtex_addon.report.metrics import Mask
from radtex_addon.settings.spec import BakeSpec, Layout, Split

from .looking import PIXELS, SUBJECT, Camera, added, empty_scene, principled, rendered, studio
from .row import Row, Use
from .together import surface_of_bake

SPEC = BakeSpec(layout=Layout.LAYERED, split=Split.UDIM, uv_layer="UVMap")
BUCKETS = BakeSpec(denoise=True, texels=128, bucket=8, samples=16, split=Split.UDIM, uv_layer="UVMap")
CAMERAS = {
    "left": Camera((-2.9, -4.2, 3.0), lens=55),
    "right": Camera((3.4, -3.4, 3.2), lens=55),
}
_SPOKES = 12.0


def scene() -> None:
    """A glazed ring, painted in rays; half of it lies in tile 1002."""
    empty_scene()
    studio(turn=200, strength=0.4, name="city.exr")
    options = {"major_segments": 96, "minor_segments": 32, "major_radius": 1.0, "minor_radius": 0.45}
    ring = added("torus", SUBJECT, _glaze(), **options)
    layer = ring.data.uv_layers["UVMap"]
    for corner in layer.uv:
        corner.vector.x *= 2


def _glaze() -> bpy.types.Material:
    glaze: Any = principled("Glaze", (0.8, 0.8, 0.8), Roughness=0.55)
    tree = glaze.node_tree
    wave = tree.nodes.new("ShaderNodeTexGradient")
    wave.gradient_type = "RADIAL"
    tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["Object"], wave.inputs["Vector"])
    turns = tree.nodes.new("ShaderNodeMath")
    turns.operation, turns.inputs[1].default_value = "MULTIPLY", _SPOKES
    tree.links.new(wave.outputs["Fac"], turns.inputs[0])
    spokes = tree.nodes.new("ShaderNodeMath")
    spokes.operation, spokes.inputs[1].default_value = "PINGPONG", 0.5
    tree.links.new(turns.outputs[0], spokes.inputs[0])
    paint = tree.nodes.new("ShaderNodeValToRGB")
    paint.color_ramp.elements[0].position, paint.color_ramp.elements[1].position = 0.2, 0.3
    paint.color_ramp.elements[0].color = (0.05, 0.25, 0.45, 1)
    paint.color_ramp.elements[1].color = (0.85, 0.78, 0.6, 1)
    tree.links.new(spokes.outputs[0], paint.inputs["Fac"])
    shader = next(node for node in tree.nodes if node.type == "BSDF_PRINCIPLED")
    tree.links.new(paint.outputs["Color"], shader.inputs["Base Color"])
    return cast(bpy.types.Material, glaze)


def drawn(sidecars: list[Path], camera: Camera) -> tuple[Array, Mask]:
    """The tiles as a camera sees them together: light (PIXELS, PIXELS, 3), and which pixels they fill."""
    rays = camera.rays()
    light, nearest = np.zeros_like(rays.away), np.full(len(rays.away), np.inf)
    for sidecar in sidecars:
        bake = read_bake(sidecar)
        seen = surface_of_bake(sidecar, bake.sidecar).gbuffer(rays, nearest)
        light[seen.hit] = bake.radiance(seen)[seen.hit]
        nearest[seen.hit] = np.linalg.norm(seen.position - rays.origin, axis=1)[seen.hit]
    filled: Mask = np.isfinite(nearest).reshape(PIXELS, PIXELS, -1).all(axis=2)
    return light.reshape(PIXELS, PIXELS, -1, 3).mean(axis=2), eroded(filled)


def rows(spec: BakeSpec = SPEC) -> Iterator[Row]:
    """The gallery's rows: two new views of both tiles, and the same of buckets."""
    for which, (each, use) in enumerate(((spec, Use.PICTURE), (BUCKETS, Use.TABLE))):
        scene()
        with tempfile.TemporaryDirectory() as folder:
            began = perf_counter()
            current: Any = bpy.context.scene
            made = [
                bake_object(current, SUBJECT, part, Path(folder), preview=Filter.NEAREST)
                for part in part_specs(current, SUBJECT, each)
            ]
            size = sum(path.stat().st_size for path in Path(folder).glob("*.exr"))
            words = (
                f"{len(made)} tiles of {each.texels} texels, {each.bucket} cells, {each.samples} spp, "
                f"{each.layout}; {sum(tile.paths for tile in made) / 1e6:.1f} M paths, "
                f"{perf_counter() - began:.0f} s, {size / 1e6:.1f} MB of EXR"
            )
            for name, camera in CAMERAS.items():
                ours, mask = drawn([tile.files.sidecar for tile in made], camera)
                title = f"UDIM tiles, {name}" + ", buckets" * which
                yield Row(title, rendered(camera)[..., :3], ours, mask, words, use=use)
