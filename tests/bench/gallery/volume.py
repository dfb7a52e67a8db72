# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A block of fog with a lit thing in it: python -m tests.bench.gallery volume"""

from __future__ import annotations

from collections.abc import Iterator

from radtex_addon.scene.nodes import open_material
from radtex_addon.settings.spec import BakeSpec

from .looking import SUBJECT, Camera, added, empty_scene, lamp, opaque_rows, principled
from .row import Row

SPEC = BakeSpec(texels=128, bucket=16, samples=4, denoise=True)
CAMERAS = {
    "left": Camera((-2.8, -3.8, 1.4)),
    "above": Camera((0.8, -3.2, 3.4)),
}


def scene() -> None:
    """A ball of fog without a surface of its own, a glowing ring in its middle."""
    made = empty_scene((0.15, 0.18, 0.25))
    made.cycles.volume_bounces = 2
    lamp((-3.0, -2.0, 4.0), watts=300, size=1)
    fog, build = open_material("Fog")
    scatter = build.node("ShaderNodeVolumeScatter", (0.9, 0.9, 0.95, 1.0), 2.5)
    output = build.node("ShaderNodeOutputMaterial")
    build.feed(output.inputs["Volume"], scatter.outputs[0])
    added("uv_sphere", SUBJECT, fog, segments=96, ring_count=48)
    glow = principled("Glow", (0, 0, 0), Emission_Color=(1.0, 0.45, 0.12, 1.0), Emission_Strength=3.0)
    added("torus", "Ring", glow, rotation=(1.0, 0.4, 0), major_radius=0.45, minor_radius=0.12)


def rows(spec: BakeSpec = SPEC) -> Iterator[Row]:
    """The gallery's rows: the fog from two sides."""
    return opaque_rows("Volume", spec, CAMERAS, scene)
