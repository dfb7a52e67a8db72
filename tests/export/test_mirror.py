# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The texture and the manifest's entry that a mirror ball needs, and the way it moves."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from radtex_addon.core.errors import InputError
from radtex_addon.core.ray_tree import build_tree
from radtex_addon.core.surface import SurfaceMesh
from radtex_addon.export.mirror import MOST_MATERIALS, Mirror, check_mirror, packed, path_over, write_mirror
from radtex_addon.formats.json_reader import Facts
from radtex_addon.textures.export_spec import Arrangement, ExportSpec, Target
from tests.reference.textures import read_ktx2
from tests.reference.traced import random_surface

SKY = (0.25, 0.5, 0.75)


def box(side: float, inwards: bool) -> SurfaceMesh:
    """A cube about the origin, seen from inside or from outside."""
    signs = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
    squares = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = np.array([each for a, b, c, d in squares for each in ((a, b, c), (a, c, d))])
    triangles = triangles[:, ::-1] if inwards else triangles
    ones = np.ones((12, 3, 3))
    return SurfaceMesh(signs * side / 2, triangles, ones, ones, ones[..., 0], ones[..., :2])


def test_the_texture_and_the_facts_are_read_as_they_were_written(tmp_path: Path) -> None:
    surface = random_surface()
    spec = ExportSpec(Target.WEB, mirror=True, sky=SKY)
    mirror = write_mirror(surface, False, False, "Thing", spec, tmp_path)
    assert Mirror.from_facts(Facts(mirror.facts(), "a manifest")) == mirror
    assert mirror.sky == SKY
    texture = read_ktx2(tmp_path / "Thing.mirror.ktx2")
    values = texture.levels[0].reshape(-1).view("<f4").reshape(-1, 4)
    expected = packed(surface, build_tree(surface.corner_position), mirrored=False)
    assert np.array_equal(values[: len(expected)], expected)
    assert (mirror.nodes, mirror.triangles) == (
        (len(expected) - 9 * mirror.triangles) // 2,
        len(surface.triangles),
    )


def test_a_mirrored_object_has_its_corners_turned_round() -> None:
    surface = random_surface()
    tree = build_tree(surface.corner_position)
    plain, turned = (
        packed(surface, tree, each)[2 * len(tree.skip) :].reshape(-1, 3, 3, 4) for each in (False, True)
    )
    assert np.array_equal(plain[:, :2, [0, 2, 1]], turned[:, :2])
    assert np.array_equal(plain[:, 2, :, 3], turned[:, 2, :, 3])


def test_the_ball_keeps_inside_a_room_and_outside_of_a_thing() -> None:
    room, thing = path_over(box(2, True), False, False), path_over(box(2, False), False, False)
    assert max(room.across) + room.radius < 1
    assert min(thing.across) - thing.radius > 0
    assert max(thing.across) > 1 or abs(thing.middle[2]) - thing.radius > 1
    mirrored = path_over(box(2, False), True, False)
    assert mirrored == room
    there = box(2, True).position + np.array([1.0, 2.0, 3.0])
    moved = path_over(replace(box(2, True), position=there), False, False)
    np.testing.assert_allclose(np.subtract(moved.middle, room.middle), [1, 2, 3], atol=1e-12)
    assert (moved.across, moved.radius) == (room.across, room.radius)


def test_what_no_mirror_shows_is_refused() -> None:
    with pytest.raises(InputError, match="choose from web, godot"):
        ExportSpec(Target.UNITY, mirror=True)
    with pytest.raises(InputError, match="slices"):
        ExportSpec(Target.WEB, arrangement=Arrangement.SLICES, mirror=True)
    with pytest.raises(InputError, match="three numbers"):
        ExportSpec(Target.WEB, mirror=True, sky=(-1, 0, 0))
    with pytest.raises(InputError, match="radiance alone"):
        check_mirror("a bake", "shadow", 1)
    with pytest.raises(InputError, match="materials"):
        check_mirror("a bake", "radiance", MOST_MATERIALS + 1)
    check_mirror("a bake", "radiance", MOST_MATERIALS)
    assert replace(ExportSpec(Target.GODOT), mirror=True).mirror
