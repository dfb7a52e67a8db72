# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes made in code, and how they get into the scene."""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, pi, sin
from typing import cast

import bpy
import numpy as np
import numpy.typing as npt

SUBJECT = "Subject"

Points = npt.NDArray[np.float64]
Vertices = list[tuple[float, float, float]]
Faces = list[tuple[int, ...]]


def made() -> bpy.types.Object:
    """What the last operator added."""
    return cast(bpy.types.Object, bpy.context.object)


def as_subject(item: bpy.types.Object) -> bpy.types.Object:
    """Name an object as what is baked."""
    item.name = SUBJECT
    return item


def link(item: bpy.types.Object) -> None:
    """Put an object into the open scene."""
    cast(bpy.types.Scene, bpy.context.scene).collection.objects.link(item)


def places(item: bpy.types.Object) -> Points:
    """A mesh's vertices in its own space, (V, 3)."""
    mesh = cast(bpy.types.Mesh, item.data)
    place = np.empty(3 * len(mesh.vertices))
    mesh.vertices.foreach_get("co", place)
    return place.reshape(-1, 3)


def move_to(item: bpy.types.Object, place: Points) -> None:
    """Set a mesh's vertices, (V, 3)."""
    mesh = cast(bpy.types.Mesh, item.data)
    mesh.vertices.foreach_set("co", place.ravel())
    mesh.update()


def mesh_object(name: str, vertices: Vertices, faces: Faces, smooth: bool) -> bpy.types.Object:
    """A mesh of vertices and of faces' vertex numbers as an object of the open scene."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(vertices, [], faces)
    mesh.polygons.foreach_set("use_smooth", [smooth] * len(faces))
    mesh.update()
    item = bpy.data.objects.new(name, mesh)
    link(item)
    return item


def catmull_rom(keys: Points, t: float) -> Points:
    """The place at t in [0, 1] between the middle two of four keys, (4, D)."""
    before, start, end, after = keys
    linear = (end - before) * t
    square = (2 * before - 5 * start + 4 * end - after) * t**2
    place: Points = (2 * start + linear + square + (3 * start - before - 3 * end + after) * t**3) / 2
    return place


def smooth_curve(keys: Points, steps: Sequence[float] = (0.0, 1 / 3, 2 / 3)) -> Points:
    """A curve through keys (K, D): places at each of `steps` between two keys, and the last key."""
    padded = np.concatenate([keys[:1], keys, keys[-1:]])
    points = [catmull_rom(padded[k : k + 4], t) for k in range(len(keys) - 1) for t in steps]
    return np.array([*points, keys[-1]])


def joined(*shapes: tuple[Vertices, Faces]) -> tuple[Vertices, Faces]:
    """Several meshes as one."""
    vertices: Vertices = []
    faces: Faces = []
    for places_of_one, faces_of_one in shapes:
        start = len(vertices)
        vertices += places_of_one
        faces += [tuple(start + index for index in face) for face in faces_of_one]
    return vertices, faces


def extruded(outline: Points, depth: float) -> tuple[Vertices, Faces]:
    """A prism of an outline (P, 2) in the xz plane, anticlockwise seen from -y, `depth` deep along y."""
    count = len(outline)
    vertices: Vertices = [(x, y, z) for y in (-depth / 2, depth / 2) for x, z in outline.tolist()]
    faces: Faces = [tuple(range(count)), tuple(range(2 * count - 1, count - 1, -1))]
    for k in range(count):
        after = (k + 1) % count
        faces.append((k, k + count, after + count, after))
    return vertices, faces


def lathe(profile: Points, segments: int, tip: float = 0.025) -> tuple[Vertices, Faces]:
    """Turn a profile of (radius, height) about z; both ends are closed by a point on the axis.

    The last point lies `tip` above the profile's end.
    """
    angles = [2 * pi * k / segments for k in range(segments)]
    vertices = [(r * cos(a), r * sin(a), z) for r, z in profile.tolist() for a in angles]
    faces: Faces = []
    for ring in range(len(profile) - 1):
        for k in range(segments):
            a, b = ring * segments + k, ring * segments + (k + 1) % segments
            faces.append((a, b, b + segments, a + segments))
    foot, top = len(vertices), len(vertices) + 1
    vertices += [(0, 0, float(profile[0, 1])), (0, 0, float(profile[-1, 1]) + tip)]
    last = (len(profile) - 1) * segments
    for k in range(segments):
        after = (k + 1) % segments
        faces += [(foot, after, k), (top, last + k, last + after)]
    return vertices, faces


def gear(teeth: int = 14) -> tuple[Vertices, Faces]:
    """A gear with a hole, a raised hub and a sunk web, its axis along z."""
    count = 4 * teeth
    section = (  # radius and height around the gear's cross-section; 0 is the toothed contour
        (0.2, 0.32), (0.4, 0.32), (0.4, 0.1), (0.68, 0.1), (0.68, 0.22), (0, 0.22),
        (0, -0.22), (0.68, -0.22), (0.68, -0.1), (0.4, -0.1), (0.4, -0.32), (0.2, -0.32),
    )  # fmt: skip
    vertices = []
    for radius, z in section:
        for k in range(count):
            angle = 2 * pi * k / count
            r = radius or (1.0 if k % 4 < 2 else 0.82)
            vertices.append((r * cos(angle), r * sin(angle), z))
    faces: Faces = []
    for ring in range(len(section)):
        above = (ring + 1) % len(section)
        for k in range(count):
            after = (k + 1) % count
            faces.append((ring * count + k, above * count + k, above * count + after, ring * count + after))
    return vertices, faces
