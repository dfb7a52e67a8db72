# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A glass egg with a bubble, whose rim mirrors all light: python -m tests.bench.gallery refraction"""

from __future__ import annotations

from collections.abc import Iterator

import bpy

from radtex_addon.settings.spec import BakeSpec, Layout

from .looking import SUBJECT, Camera, added, empty_scene, opaque_rows, principled
from .row import Row

SPEC = BakeSpec(layout=Layout.LAYERED)
BUCKETS = BakeSpec(texels=128, bucket=16, samples=3, denoise=True)
CAMERAS = {
    "left": Camera((-2.7, -3.6, 0.9)),
    "above": Camera((0.7, -3.2, 3.0)),
}


def scene() -> None:
    """The egg under an even sky, an orange ball behind it; the bubble mirrors what comes at a slant."""
    empty_scene((0.5, 0.55, 0.65))
    glass = principled("Glass", (0.95, 1.0, 0.97), Transmission_Weight=1.0, IOR=1.45, Roughness=0.2)
    egg = added("uv_sphere", SUBJECT, glass, segments=96, ring_count=48)
    egg.scale = (0.9, 0.9, 1.15)
    bubble = added(
        "uv_sphere", "Bubble", glass, radius=0.42, segments=64, ring_count=32, location=(0, 0, 0.15)
    )
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.flip_normals()
    bpy.ops.object.mode_set(mode="OBJECT")
    bubble.visible_shadow = False
    added("uv_sphere", "Ball", principled("Ball", (0.85, 0.22, 0.06)), radius=0.45, location=(1.2, 2.2, -0.4))


def rows(spec: BakeSpec = SPEC, stills: bool = True) -> Iterator[Row]:
    """The gallery's rows: the egg from two sides."""
    return opaque_rows("Refraction", spec, CAMERAS, scene, beside=BUCKETS, swing=30, stills=stills)
