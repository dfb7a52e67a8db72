# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Three objects in one atlas: python -m tests.bench.gallery together"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path
from time import perf_counter
from typing import Any, cast

import bpy
import numpy as np

from radtex_addon.core.sampler import Filter
from radtex_addon.formats.sidecar import Sidecar, preview_path
from radtex_addon.job import bake_object
from radtex_addon.report.finished_bake import read_bake
from radtex_addon.report.gbuffer import BakedSurface, GBuffer
from radtex_addon.scene.preview_file import baked_copy
from radtex_addon.settings.spec import BakeSpec, Layout

from .looking import Camera, added, empty_scene, principled, rendered, studio
from .row import Row, Use

OBJECTS = ("Ring", "Head", "Column")
SPEC = BakeSpec(layout=Layout.LAYERED, objects=OBJECTS)
BUCKETS = BakeSpec(denoise=True, texels=128, bucket=8, samples=16, objects=OBJECTS)
CAMERAS = {
    "left": Camera((-3.4, -4.6, 2.6), (0.0, 0.0, 0.1), lens=55),
    "right": Camera((3.9, -4.2, 1.6), (0.0, 0.0, 0.1), lens=55),
}


def scene() -> None:
    """A ring of brass, a head of terracotta and a column of plaster, which light one another."""
    empty_scene()
    studio(turn=40, strength=0.4, name="city.exr")
    brass = principled("Brass", (0.8, 0.55, 0.2), Metallic=1.0, Roughness=0.55)
    clay = principled("Terracotta", (0.65, 0.22, 0.12), Roughness=0.6)
    plaster = principled("Plaster", (0.75, 0.78, 0.8), Roughness=0.7)
    added("torus", "Ring", brass, major_radius=0.6, location=(-0.95, 0.1, 0.1), rotation=(1.1, 0.3, 0.2))
    head = added("monkey", "Head", clay, size=1.3, location=(0.55, -0.6, 0.0), rotation=(-0.3, 0.0, 0.2))
    rounder = head.modifiers.new("Rounder", "SUBSURF")
    rounder.levels = rounder.render_levels = 2
    added("cylinder", "Column", plaster, radius=0.35, depth=2.2, location=(0.55, 0.9, 0.2))


def seen_of(sidecar: Path, camera: Camera) -> GBuffer:
    """What a camera sees of the bake's surface, as the saved preview has it."""
    rays = camera.rays()
    return surface_of_bake(sidecar, read_bake(sidecar).sidecar).gbuffer(rays, np.full(len(rays.away), np.inf))


def surface_of_bake(sidecar: Path, facts: Sidecar) -> BakedSurface:
    """The surface of an atlas: of all its objects, or of the part that it is of."""
    part = None if facts.part is None else facts.part.index
    preview = preview_path(sidecar, facts.kind, facts.part)
    with baked_copy(preview, facts.surfaces, facts.uv_map, part) as (_, copy):
        place = np.array(copy.matrix_world)
        return BakedSurface(cast(bpy.types.Mesh, copy.data), place, facts.uv_map)


def rows(spec: BakeSpec = SPEC) -> Iterator[Row]:
    """The gallery's rows: two new views, and the same of buckets."""
    for which, (each, use) in enumerate(((spec, Use.PICTURE), (BUCKETS, Use.TABLE))):
        scene()
        with tempfile.TemporaryDirectory() as folder:
            began = perf_counter()
            current: Any = bpy.context.scene
            made = bake_object(current, "Still life", each, Path(folder), preview=Filter.NEAREST)
            size = sum(path.stat().st_size for path in Path(folder).glob("*.exr"))
            words = (
                f"three objects, one atlas of {each.texels} texels, {each.bucket} cells, {each.samples} spp, "
                f"{each.layout}; {made.paths / 1e6:.1f} M paths, {perf_counter() - began:.0f} s, "
                f"{size / 1e6:.1f} MB of EXR"
            )
            look = read_bake(made.files.sidecar).radiance
            for name, camera in CAMERAS.items():
                seen = seen_of(made.files.sidecar, camera)
                truth = rendered(camera)[..., :3]
                title = f"Shared atlas, {name}" + ", buckets" * which
                yield Row(title, truth, seen.resolve(look(seen)), seen.eroded, words, use=use)
