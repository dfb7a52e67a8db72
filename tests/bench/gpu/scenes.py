# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The objects whose lookups are timed, each in a scene of its own, and where they are seen from."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np

from ..fidelity.scenes.meshes import lathe, mesh_object
from ..gallery.looking import SUBJECT, Place, added, empty_scene, lamp, principled, studio, tiles

_AROUND = 64  # faces of what is turned
_BOWL = [
    *(
        (0.5, -0.8),
        (0.8, -0.74),
        (1.2, -0.5),
        (1.45, -0.15),
        (1.5, 0.2),
        (1.42, 0.5),
        (1.2, 0.7),
        (1.1, 0.74),
    ),
    *((1.0, 0.72), (1.1, 0.55), (1.2, 0.2), (1.1, -0.2), (0.8, -0.5), (0.3, -0.6)),
]


@dataclass(frozen=True)
class Staged:
    """A scene: `build` makes it the open one; `objects` are baked, into one atlas if they are several.

    The camera at `place` looks at `target`; `half` is the tangent of half its vertical angle of view. `box`:
    two corners of the room around the object, as an artist would give it to a probe.
    """

    build: Callable[[], object]
    place: Place
    target: Place
    half: float
    box: tuple[Place, Place]
    objects: tuple[str, ...] = (SUBJECT,)


def convex() -> None:
    """A pebble of glazed tiles on a table: nothing of it meets itself, the glaze is a coat."""
    _table(40)
    glaze: Any = tiles(3.0, 0.45)
    shader = next(node for node in glaze.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    shader.inputs["Coat Weight"].default_value, shader.inputs["Coat Roughness"].default_value = 1.0, 0.05
    pebble = added("uv_sphere", SUBJECT, glaze, segments=64, ring_count=32)
    pebble.scale = (1.5, 0.9, 0.8)


def rough() -> None:
    """A head of dull copper: it meets itself in eyes and ears, and mirrors nothing sharply."""
    _table(200)
    copper = principled("Copper", (0.85, 0.45, 0.3), Metallic=1.0, Roughness=0.5)
    head = added("monkey", SUBJECT, copper, size=1.8, rotation=(-0.3, 0.0, 0.2))
    rounder = head.modifiers.new("Rounder", "SUBSURF")
    rounder.levels = rounder.render_levels = 1


def film() -> None:
    """A bowl of steel under a thin film, between a studio's light and two lamps that are near."""
    _table(120, "interior.exr")
    lamp((-2.2, -1.4, 1.0), 25, size=0.4)
    lamp((1.6, -2.0, 1.4), 25, size=0.4)
    layer = {"Thin_Film_Thickness": 520.0, "Thin_Film_IOR": 1.8}
    steel = principled("Steel", (0.55, 0.55, 0.57), Metallic=1.0, Roughness=0.15, **layer)
    bowl: Any = mesh_object(SUBJECT, *lathe(np.array(_BOWL), _AROUND, 0.0), smooth=True)
    bowl.data.materials.append(steel)
    smooth = bowl.modifiers.new("Smooth", "SUBSURF")
    smooth.levels = smooth.render_levels = 1


def lights() -> None:
    """A block of lacquer with round edges between four lamps that are near."""
    empty_scene((0.05, 0.06, 0.08))
    added("plane", "Table", tiles(1.5, 0.4), size=6, location=(0, 0, -0.85))
    near = {(-1.9, -1.2, 1.3): 15, (1.9, -1.6, 0.6): 10, (0.2, -1.2, 2.0): 20, (0.3, 2.2, 1.2): 40}
    for place, watts in near.items():
        lamp(place, watts, size=0.4)
    _block(SUBJECT, principled("Lacquer", (0.1, 0.25, 0.6), Roughness=0.2), (2.4, 1.4, 1.3))


def shared() -> None:
    """Three blocks in a row, of brass, clay and glazed plaster, which share an atlas."""
    _table(300)
    brass = principled("Brass", (0.8, 0.55, 0.2), Metallic=1.0, Roughness=0.2)
    clay = principled("Clay", (0.65, 0.22, 0.12), Roughness=0.6)
    plaster = principled("Plaster", (0.75, 0.78, 0.8), Roughness=0.5, Coat_Weight=1.0, Coat_Roughness=0.05)
    for name, material, across in (("Left", brass, -0.95), ("Middle", clay, 0.0), ("Right", plaster, 0.95)):
        _block(name, material, (0.9, 0.9, 1.6)).location = (across, 0.3 * (name == "Middle"), 0.0)


def _block(name: str, material: bpy.types.Material, size: Place) -> Any:
    """A block with round edges."""
    block = added("cube", name, material, size=1.0)
    block.scale = size
    bpy.ops.object.transform_apply(location=False, rotation=False, scale=True)
    edges = block.modifiers.new("Edges", "BEVEL")
    edges.width, edges.segments = 0.3, 6
    bpy.ops.object.shade_smooth()
    return block


def _table(turn: float, light: str = "studio.exr") -> None:
    """A table with a tiled top and a box on it, in a studio."""
    empty_scene()
    studio(turn, name=light)
    added("plane", "Table", tiles(1.5, 0.4), size=6, location=(0, 0, -0.85))
    side = principled("Box", (0.1, 0.25, 0.6), Roughness=0.5)
    added("cube", "Box", side, size=0.8, location=(1.8, 1.2, -0.45))


_ROOM = ((-3.0, -3.0, -0.85), (3.0, 3.0, 3.0))
SCENES = {
    "convex": Staged(convex, (-0.6, -3.0, 0.9), (0, 0, 0), 0.2, _ROOM),
    "rough": Staged(rough, (0.1, -2.5, 0.7), (0.0, 0.0, 0.3), 0.15, _ROOM),
    "film": Staged(film, (-0.8, -3.6, 0.9), (0, 0, -0.05), 0.19, _ROOM),
    "lights": Staged(lights, (-1.2, -3.0, 1.3), (0, 0, -0.05), 0.19, _ROOM),
    "shared": Staged(shared, (-0.8, -3.4, 0.9), (0, 0, 0), 0.19, _ROOM, ("Left", "Middle", "Right")),
}
