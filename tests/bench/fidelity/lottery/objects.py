# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects drawn by chance, their modifiers among them."""

from __future__ import annotations

from collections.abc import Callable
from math import cos, pi, radians, sin
from typing import Any, cast

import bpy
import numpy as np

from ..scenes.meshes import (
    Faces,
    Points,
    Vertices,
    extruded,
    gear,
    joined,
    lathe,
    made,
    mesh_object,
    smooth_curve,
)
from ..scenes.stage import world_corners

Shape = tuple[Vertices, Faces]

_WIDTH = 2.0  # of the finished object, along its longest side
_MOST_FACES = 30_000  # after subdivision
_SHARP = radians(38)  # edges between faces that turn more are sharp


def draw_object(rng: np.random.Generator) -> bpy.types.Object:
    """An object with modifiers, about the origin and at most 2 wide, turned, without materials."""
    kind = _KINDS[rng.integers(len(_KINDS))]
    item = kind(rng)
    item.name = kind.__name__.strip("_")
    mesh = cast(Any, item.data)
    mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
    mesh.set_sharp_from_angle(angle=_SHARP)
    _modify(item, rng)
    tilt = rng.normal(0, 0.5, 2) * (rng.random() < 0.5)
    item.rotation_euler = (float(tilt[0]), float(tilt[1]), float(rng.uniform(0, 2 * pi)))
    corners = world_corners(item)
    low, high = corners.min(axis=0), corners.max(axis=0)
    scale = _WIDTH / float((high - low).max())
    item.scale = (scale, scale, scale)
    item.location = (-scale * (low + high) / 2).tolist()
    return item


def _modify(item: bpy.types.Object, rng: np.random.Generator) -> None:
    """Bevel, twist, repeat and subdivide, each now and then."""
    chances = rng.random(4)
    mesh = cast(bpy.types.Mesh, item.data)
    faces = len(mesh.polygons)
    bevelled = chances[0] < 0.5 and faces < 600
    if bevelled:
        bevel: Any = item.modifiers.new("Bevel", "BEVEL")
        bevel.width, bevel.segments = float(rng.uniform(0.01, 0.06)), int(rng.integers(1, 4))
        bevel.limit_method, bevel.harden_normals = "ANGLE", bool(rng.integers(2))
        faces *= 3
    if chances[1] < 0.3 and faces * 4 < _MOST_FACES:
        subdivision: Any = item.modifiers.new("Subdivision", "SUBSURF")
        level = 2 if faces * 16 < _MOST_FACES and rng.random() < 0.6 else 1
        subdivision.levels = subdivision.render_levels = level
        faces *= 4**level
    if chances[2] < 0.2 and faces >= 200:
        twist: Any = item.modifiers.new("Twist", "SIMPLE_DEFORM")
        twist.deform_method, twist.deform_axis = "TWIST", "Z"
        twist.angle = float(rng.uniform(-1.5, 1.5))
    if chances[3] < 0.15 and faces * 3 < _MOST_FACES:
        array: Any = item.modifiers.new("Array", "ARRAY")
        array.count = int(rng.integers(2, 4))
        offset = np.zeros(3)
        offset[rng.integers(3)] = rng.uniform(0.7, 1.25)
        array.relative_offset_displace = offset.tolist()


def sphere_profile(rings: int) -> Points:
    """Radius and height of a half circle from pole to pole, (rings - 1, 2), the poles left out."""
    angle = np.pi * np.arange(1, rings) / rings
    return np.stack([np.sin(angle), -np.cos(angle)], axis=1)


def _monkey(rng: np.random.Generator) -> bpy.types.Object:
    bpy.ops.mesh.primitive_monkey_add()
    item = made()
    subdivision: Any = item.modifiers.new("Subdivision", "SUBSURF")
    subdivision.levels = subdivision.render_levels = int(rng.integers(1, 3))
    return item


def _box(rng: np.random.Generator) -> bpy.types.Object:
    """A box, a plate or a pillar of several faces a side."""
    half = rng.uniform(0.4, 1, 3)
    outline = np.array([(-1, -1), (0, -1), (1, -1), (1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0)]) * half[[0, 2]]
    return mesh_object("Box", *extruded(outline, 2 * float(half[1])), smooth=False)


def _frustum(rng: np.random.Generator) -> bpy.types.Object:
    """A cylinder, prism or cone."""
    low, high = rng.uniform(0.4, 1), rng.choice([0.02, rng.uniform(0.3, 1)])
    height = rng.uniform(0.35, 1.1)
    steps = np.linspace(0, 1, 9)[:, None]
    profile = (1 - steps) * np.array((low, -height)) + steps * np.array((high, height))
    return mesh_object("Frustum", *lathe(profile, int(rng.choice([3, 5, 6, 8, 64])), tip=0.0), smooth=False)


def _ellipsoid(rng: np.random.Generator) -> bpy.types.Object:
    profile = sphere_profile(24) * (1, float(rng.uniform(0.5, 1.4)))
    return mesh_object("Ellipsoid", *lathe(profile, 64, tip=0.0), smooth=True)


def _blob(rng: np.random.Generator) -> bpy.types.Object:
    """A ball bulged by waves."""
    vertices, faces = lathe(sphere_profile(48), 96, tip=0.0)
    place = np.array(vertices)
    place /= np.linalg.norm(place, axis=1, keepdims=True)
    bulge = np.ones(len(place))
    for _ in range(6):
        rate = rng.normal(0, 1, 3) * rng.uniform(1.5, 5)
        bulge += 0.16 / (1 + np.linalg.norm(rate) / 2) * np.sin(place @ rate + rng.uniform(0, 2 * pi)) * 2
    moved: Vertices = [(x, y, z) for x, y, z in (place * bulge[:, None]).tolist()]
    return mesh_object("Blob", moved, faces, smooth=True)


def _vase(rng: np.random.Generator) -> bpy.types.Object:
    """A turned thing of a smooth random profile, closed, or open above and solid by a modifier."""
    count = int(rng.integers(4, 9))
    radius = rng.uniform(0.2, 1, count)
    height = np.linspace(-1, 1, count) * rng.uniform(0.7, 1.2)
    keys = np.stack([np.concatenate([[0.03], radius]), np.concatenate([height[:1], height])], axis=1)
    profile = smooth_curve(keys)
    profile[:, 0] = np.maximum(profile[:, 0], 0.02)
    segments = 72
    vertices, faces = lathe(profile, segments, tip=0.0)
    if rng.random() < 0.5:
        return mesh_object("Vase", vertices, faces, smooth=True)
    walls = faces[: (len(profile) - 1) * segments]
    feet = [face for face in faces[len(walls) :] if len(vertices) - 2 in face]
    item = mesh_object("Vase", vertices[:-1], [*walls, *feet], smooth=True)
    solidify: Any = item.modifiers.new("Solidify", "SOLIDIFY")
    solidify.thickness = float(rng.uniform(0.03, 0.1))
    return item


def _wheel(rng: np.random.Generator) -> bpy.types.Object:
    """A gear, standing."""
    item = mesh_object("Gear", *gear(int(rng.integers(6, 22))), smooth=False)
    mesh = cast(Any, item.data)
    mesh.transform(((1, 0, 0, 0), (0, 0, -1, 0), (0, 1, 0, 0), (0, 0, 0, 1)))
    return item


def _knot(rng: np.random.Generator) -> bpy.types.Object:
    """A ring, or a torus knot, as a tube."""
    turns, windings = ((1, 0), (2, 3), (3, 2), (2, 5), (3, 4))[rng.integers(5)]
    thickness = float(rng.uniform(0.14, 0.24) if windings else rng.uniform(0.2, 0.45))
    return mesh_object("Knot", *_tube(turns, windings, thickness, 56 * (turns + windings), 20), smooth=True)


def _tube(turns: int, windings: int, thickness: float, rings: int, sides: int) -> Shape:
    """A tube along the torus knot (turns, windings)."""
    t = 2 * pi * np.arange(rings) / rings
    radius = 1 + 0.45 * np.cos(windings * t) * (windings > 0)
    bend = 0.5 * np.sin(windings * t)
    middle = np.stack([radius * np.cos(turns * t), radius * np.sin(turns * t), bend], axis=1)
    ahead = np.roll(middle, -1, axis=0) - np.roll(middle, 1, axis=0)
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    outward = middle * (1, 1, 0)
    side = np.cross(ahead, outward)
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    up = np.cross(side, ahead)
    vertices: Vertices = []
    for k in range(sides):
        angle = 2 * pi * k / sides
        vertices += [
            (x, y, z) for x, y, z in (middle + thickness * (cos(angle) * up + sin(angle) * side)).tolist()
        ]
    faces: Faces = []
    for k in range(sides):
        above = (k + 1) % sides
        for ring in range(rings):
            after = (ring + 1) % rings
            faces.append((k * rings + ring, k * rings + after, above * rings + after, above * rings + ring))
    return vertices, faces


def _star(rng: np.random.Generator) -> bpy.types.Object:
    """A prism of a star or of an uneven polygon."""
    count = int(rng.integers(4, 9))
    radius = np.where(np.arange(2 * count) % 2, rng.uniform(0.4, 0.9), 1.0) * rng.uniform(0.85, 1, 2 * count)
    angle = np.pi * np.arange(2 * count) / count
    outline = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)
    return mesh_object("Star", *extruded(outline, float(rng.uniform(0.4, 1.4))), smooth=False)


def _bracket(rng: np.random.Generator) -> bpy.types.Object:
    """An angle of large flat faces."""
    wide, high = rng.uniform(0.25, 0.7, 2).tolist()
    outline = np.array([(-1, -1), (1, -1), (1, high - 1), (wide - 1, high - 1), (wide - 1, 1), (-1, 1)])
    return mesh_object("Bracket", *extruded(outline, float(rng.uniform(0.7, 1.8))), smooth=False)


def _heap(rng: np.random.Generator) -> bpy.types.Object:
    """Three to six balls and cylinders that lie in one another."""
    shapes = []
    for _ in range(int(rng.integers(3, 7))):
        profile = sphere_profile(20) if rng.random() < 0.5 else np.array([(1.0, -1.0), (1.0, 1.0)])
        vertices, faces = lathe(profile * float(rng.uniform(0.25, 0.55)), 48, tip=0.0)
        place = np.array(vertices) + rng.uniform(-0.6, 0.6, 3)
        shapes.append(([(x, y, z) for x, y, z in place.tolist()], faces))
    return mesh_object("Heap", *joined(*shapes), smooth=True)


def _text(rng: np.random.Generator) -> bpy.types.Object:
    """One to three letters, extruded, standing."""
    letters = "".join(rng.choice(list("ABCDEGKRSX2358&"), int(rng.integers(1, 4))))
    bpy.ops.object.text_add(rotation=(pi / 2, 0, 0))
    item = made()
    curve = cast(Any, item.data)
    curve.body, curve.resolution_u = letters, 6
    curve.extrude, curve.bevel_depth = float(rng.uniform(0.15, 0.35)), float(rng.uniform(0, 0.03))
    bpy.ops.object.convert(target="MESH")
    bpy.ops.object.transform_apply(location=False, rotation=True, scale=False)
    return made()


_KINDS: tuple[Callable[[np.random.Generator], bpy.types.Object], ...] = (
    _monkey, _box, _frustum, _ellipsoid, _blob, _vase, _vase, _wheel, _knot, _star, _bracket, _heap, _text,
)  # fmt: skip
