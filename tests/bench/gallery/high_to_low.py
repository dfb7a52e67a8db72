# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A carved head's light on a head of few faces: python -m tests.bench.gallery high_to_low

The path-traced pictures are of the detailed head, ours of the simple one; measured where both are seen.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import bpy

from radtex_addon.report.finished_bake import read_bake
from radtex_addon.settings.spec import BakeSpec, Layout

from .looking import SUBJECT, Camera, added, baked, empty_scene, lamp, principled, rendered
from .row import Row, Use

DETAILED = "Detailed"
SPEC = BakeSpec(layout=Layout.LAYERED, source=DETAILED, extrusion=0.06)
BUCKETS = BakeSpec(denoise=True, texels=128, bucket=8, samples=16, source=DETAILED, extrusion=0.06)
CAMERAS = {
    "left": Camera((-2.2, -4.4, 0.9)),
    "right": Camera((2.6, -4.1, -0.2)),
    "above": Camera((0.6, -3.6, 3.1)),
}
_DEPTH = 0.035  # of the carving
_COVERED = 0.99  # of alpha


def scene() -> None:
    """Two heads in one place: a carved one of 250 thousand triangles, and one of four thousand."""
    made = empty_scene((0.35, 0.4, 0.5))
    made.render.film_transparent = True
    lamp((-3.0, -3.5, 4.0), watts=450, size=2)
    bronze = principled("Bronze", (0.62, 0.36, 0.16), Metallic=0.6, Roughness=0.5)
    carved = _head(DETAILED, bronze, levels=4)
    pattern: Any = bpy.data.textures.new("Carving", "VORONOI")
    pattern.noise_scale = 0.16
    carving = carved.modifiers.new("Carving", "DISPLACE")
    carving.texture, carving.strength, carving.mid_level = pattern, _DEPTH, 0.4
    carving.texture_coords = "LOCAL"
    _head(SUBJECT, principled("Plain", (0.5, 0.5, 0.5)), levels=1)


def _head(name: str, material: bpy.types.Material, levels: int) -> Any:
    head = added("monkey", name, material)
    subdivision = head.modifiers.new("Subdivision", "SUBSURF")
    subdivision.levels = subdivision.render_levels = levels
    return head


def rows(spec: BakeSpec = SPEC) -> Iterator[Row]:
    """The gallery's rows: three new views of one bake, and the same of buckets."""
    for which, (each, use) in enumerate(((spec, Use.PICTURE), (BUCKETS, Use.TABLE))):
        scene()
        with tempfile.TemporaryDirectory() as folder:
            bake = baked(each, Path(folder))
            finished = read_bake(bake.sidecar)
            source, look = finished.sidecar.source, finished.radiance
            bpy.data.objects[SUBJECT].hide_render = True
            for name, camera in CAMERAS.items():
                seen, truth = bake.seen(camera), rendered(camera)
                mask = seen.eroded & (truth[..., 3] > _COVERED)
                note = f"{source.missed if source else 'all'} texels found nothing; {bake.words}"
                title = f"High to low, {name}" + ", buckets" * which
                yield Row(title, truth[..., :3], seen.resolve(look(seen)), mask, note, use=use)
