# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Steel under a thin film, whose colour turns with the view: python -m tests.bench.gallery iridescence"""

from __future__ import annotations

from collections.abc import Iterator

from radtex_addon.settings.spec import BakeSpec, Layout

from .looking import SUBJECT, Camera, added, empty_scene, lamp, opaque_rows, principled
from .row import Row

SPEC = BakeSpec(layout=Layout.LAYERED)
BUCKETS = BakeSpec(texels=128, bucket=16, samples=3, denoise=True)
CAMERAS = {
    "left": Camera((-2.5, -3.2, 2.4)),
    "steep": Camera((0.5, -1.9, 4.3)),
}


def scene() -> None:
    """A ring under an even sky, so that the film alone colours it, and a lamp."""
    empty_scene((0.75, 0.75, 0.75))
    lamp((-2.0, -3.0, 4.0), watts=250, size=2)
    film = {"Thin_Film_Thickness": 520.0, "Thin_Film_IOR": 1.8}
    steel = principled("Steel", (0.5, 0.5, 0.52), Metallic=1.0, Roughness=0.4, **film)
    sides = {"major_segments": 96, "minor_segments": 48, "major_radius": 0.85, "minor_radius": 0.4}
    added("torus", SUBJECT, steel, rotation=(0.2, 0.1, 0), **sides)


def rows(spec: BakeSpec = SPEC, stills: bool = True) -> Iterator[Row]:
    """The gallery's rows: the ring from two sides."""
    return opaque_rows("Iridescence", spec, CAMERAS, scene, beside=BUCKETS, swing=50, stills=stills)
