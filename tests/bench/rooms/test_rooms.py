# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The rooms build in both Blenders, with the cameras and objects that they promise."""

from __future__ import annotations

from collections import Counter
from typing import Any

import bpy
import numpy as np
import pytest

from ..assets.views import scene_cameras
from ..fidelity.references import distances, tree_of
from . import living
from .baking import build, rendered
from .building import THICKNESS

SURFACES = ("MESH", "CURVE", "FONT")
INDOORS = 13.0  # metres: nothing in a room is further away than its windows' other side
NEAREST = 0.15  # metres in front of a camera


@pytest.mark.parametrize("room", ["living", "gallery", "seed 1"])
def test_cameras_stand_free_inside_a_closed_room(room: str) -> None:
    """Most rays of each view end in the room, and none before somebody's nose; no thing is inside out."""
    build(room)
    cameras = scene_cameras(24)
    assert [camera.name for camera in cameras] == [f"view{number}" for number in range(6)]
    tree = tree_of(rendered(SURFACES))
    for camera in cameras:
        found = distances(tree, camera.rays)
        assert found.min() > NEAREST, camera.name
        assert np.mean(found < INDOORS) > 0.6, camera.name
    closed = [item for item in rendered() if is_closed(item.data)]
    assert {item.name for item in closed} >= {"Floor", "Ceiling", "Wall North", "Wall East"}
    assert [item.name for item in closed if volume(item.data) <= 0] == []
    if room == "living":
        check_the_living_room()


def is_closed(mesh: Any) -> bool:
    """Whether each edge is between two faces."""
    faces = Counter(key for face in mesh.polygons for key in face.edge_keys)
    return set(faces.values()) == {2}


def volume(mesh: Any) -> float:
    """Of a closed mesh, negative if its faces look inwards."""
    place = [vertex.co for vertex in mesh.vertices]
    mesh.calc_loop_triangles()
    corners = (triangle.vertices for triangle in mesh.loop_triangles)
    return float(sum(place[a].dot(place[b].cross(place[c])) / 6 for a, b, c in corners))


def check_the_living_room() -> None:
    """Some thirty meshes, none joined with another, a text, a curve, images; a wall with a hole in it."""
    items: list[Any] = rendered(SURFACES)
    assert {item.type for item in items} == set(SURFACES)
    assert 29 <= len(rendered()) <= 36
    assert all(item.material_slots for item in items)
    images = {image.name for image in bpy.data.images if image.packed_file}
    assert {"Parquet", "Rug", "Leaf"} <= images
    north: Any = bpy.data.objects["Wall North"].data
    whole = (living.WIDTH + 2 * THICKNESS) * living.HEIGHT * THICKNESS
    window = 2.4 * 1.55 * THICKNESS
    assert volume(north) == pytest.approx(whole - window, rel=1e-4)


def test_a_seed_is_a_room() -> None:
    """The same at every call, and another for another seed."""

    def told() -> list[Any]:
        items: list[Any] = rendered()
        return [(item.name, [tuple(row) for row in item.matrix_world]) for item in items]

    rooms = []
    for seed in (4, 4, 5):
        build(f"seed {seed}")
        rooms.append(told())
    assert rooms[0] == rooms[1] != rooms[2]
