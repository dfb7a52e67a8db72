# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A head of jade, lit from behind: python -m tests.bench.gallery subsurface"""

from __future__ import annotations

from collections.abc import Iterator

import bpy

from radtex_addon.settings.spec import BakeSpec, Layout

from .looking import SUBJECT, Camera, added, empty_scene, lamp, opaque_rows, principled
from .row import Row

SPEC = BakeSpec(layout=Layout.LAYERED)
BUCKETS = BakeSpec(texels=128, bucket=8, samples=10, denoise=True)
CAMERAS = {
    "left": Camera((-2.2, -4.2, 0.7)),
    "above": Camera((0.6, -3.4, 3.0)),
}


def scene() -> None:
    """A head under two lamps, one of them behind its ears."""
    empty_scene((0.12, 0.14, 0.18))
    lamp((2.0, 4.0, 2.5), watts=250, size=1.5)
    lamp((-4.0, -3.0, 3.0), watts=130, size=2)
    skin = {"Subsurface_Weight": 1.0, "Subsurface_Radius": (0.3, 1.0, 0.5), "Subsurface_Scale": 0.25}
    jade = principled("Jade", (0.35, 0.8, 0.5), Roughness=0.5, **skin)
    head = added("monkey", SUBJECT, jade)
    subdivision = head.modifiers.new("Subdivision", "SUBSURF")
    subdivision.levels = subdivision.render_levels = 2
    bpy.ops.object.shade_smooth()


def rows(spec: BakeSpec = SPEC) -> Iterator[Row]:
    """The gallery's rows: the head from two sides."""
    return opaque_rows("Subsurface", spec, CAMERAS, scene, beside=BUCKETS)
