# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Polished metal and glazed clay under a studio's hard lamps: python -m tests.bench.gallery studio

The default bake: what an artist gets who chooses nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import pi
from typing import Any, cast

import bpy
import numpy as np

from radtex_addon.settings.spec import BakeSpec, Layout

from ..fidelity.scenes.meshes import lathe, mesh_object
from .looking import SUBJECT, Camera, added, empty_scene, opaque_rows, principled, studio, tiles
from .row import Row

SPEC = BakeSpec(layout=Layout.LAYERED)
CAMERAS = {
    "left": Camera((-3.4, -3.8, 1.6), (0, 0, 0.1), lens=55),
    "above": Camera((1.2, -3.0, 3.6), (0, 0, 0.1), lens=55),
}
_AROUND = 96
_Profile = list[tuple[float, float]]  # radii and heights, from the bottom's middle to the top's
_KETTLE: _Profile = [
    *((0.0, -0.8), (0.72, -0.8), (0.86, -0.7), (0.9, -0.45), (0.86, -0.1), (0.72, 0.2), (0.5, 0.42)),
    *((0.47, 0.45), (0.5, 0.48), (0.44, 0.55), (0.2, 0.62), (0.06, 0.64), (0.1, 0.74), (0.0, 0.78)),
]
_JUG: _Profile = [
    *((0.0, -0.8), (0.5, -0.8), (0.55, -0.74), (0.78, -0.3), (0.8, 0.0), (0.6, 0.4), (0.42, 0.62)),
    *((0.5, 0.9), (0.46, 0.9), (0.37, 0.62), (0.5, 0.35), (0.6, 0.0), (0.4, -0.6), (0.0, -0.65)),
]


def kettle() -> None:
    """A kettle of polished steel with a black handle."""
    _room(40)
    steel = principled("Steel", (0.66, 0.67, 0.69), Metallic=1.0, Roughness=0.12)
    body = _turned(_KETTLE, steel)
    handle = added(
        "torus",
        "Handle",
        principled("Plastic", (0.02, 0.02, 0.025), Roughness=0.25),
        major_radius=0.62,
        minor_radius=0.07,
        major_segments=64,
        location=(0, 0, 0.55),
        rotation=(pi / 2, 0, 0),
    )
    _joined(body, handle)


def jug() -> None:
    """A jug of white clay under a red glaze, whose foot is bare."""
    _room(200)
    glaze = principled("Glaze", (0.45, 0.04, 0.03), Roughness=0.35, Coat_Weight=1.0, Coat_Roughness=0.05)
    body = _turned(_JUG, glaze)
    clay = principled("Clay", (0.7, 0.6, 0.5), Roughness=0.9)
    foot = added(
        "torus", "Foot", clay, major_radius=0.5, minor_radius=0.06, major_segments=64, location=(0, 0, -0.78)
    )
    _joined(body, foot)


def _room(turn: float) -> None:
    """A table with a tiled top under a studio's lamps."""
    empty_scene()
    studio(turn)
    added("plane", "Table", tiles(1.5, 0.4), size=6, location=(0, 0, -0.85))
    added(
        "cube",
        "Box",
        principled("Box", (0.1, 0.25, 0.6), Roughness=0.5),
        size=0.8,
        location=(1.8, 1.2, -0.45),
    )


def _turned(profile: _Profile, material: bpy.types.Material) -> Any:
    """A profile turned about the vertical, smoothed by subdivision."""
    inner, tip = np.array(profile[1:-1]), profile[-1][1] - profile[-2][1]
    item: Any = mesh_object("Body", *lathe(inner, _AROUND, tip), smooth=True)
    item.data.materials.append(material)
    smooth = item.modifiers.new("Smooth", "SUBSURF")
    smooth.levels = smooth.render_levels = 1
    return item


def _joined(body: Any, part: Any) -> None:
    """One object of both, the subject."""
    bpy.ops.object.select_all(action="DESELECT")
    for item in (body, part):
        item.select_set(True)
    cast(Any, bpy.context.view_layer).objects.active = body
    bpy.ops.object.join()
    body.name = SUBJECT


def rows(spec: BakeSpec = SPEC) -> Iterator[Row]:
    """The gallery's rows: a kettle and a jug, each from two sides."""
    scenes: dict[str, Callable[[], None]] = {"kettle": kettle, "jug": jug}
    for name, scene in scenes.items():
        yield from opaque_rows(f"Studio, {name}", spec, CAMERAS, scene)
