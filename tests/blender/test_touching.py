# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Which objects touch and make one asset, and which only stand side by side, or around the others."""

from __future__ import annotations

from typing import Any

import bpy
import pytest

from radtex_addon.scene.mesh import touching
from radtex_addon.scene.mesh.asset_parts import asset_groups
from radtex_addon.scene.mesh.touching import surfaces_in_render, surfaces_shown
from radtex_addon.scene.scratch import scratch_scene

context: Any = bpy.context  # to the stubs, every pointer may be None


def box(name: str, least: tuple[float, ...], most: tuple[float, ...]) -> Any:
    """A box from corner to corner, in the world."""
    bpy.ops.mesh.primitive_cube_add(size=1, location=[(a + b) / 2 for a, b in zip(least, most, strict=True)])
    context.object.name = name
    context.object.scale = [b - a for a, b in zip(least, most, strict=True)]
    return context.object


def ball(name: str, radius: float, at: tuple[float, float, float]) -> Any:
    bpy.ops.mesh.primitive_uv_sphere_add(radius=radius, location=at)
    context.object.name = name
    return context.object


def floor(size: float = 6) -> None:
    bpy.ops.mesh.primitive_plane_add(size=size)
    context.object.name = "Floor"


def chair(name: str, x: float) -> None:
    """A chair of three parts, from x to x + 0.45."""
    box(f"{name} seat", (x, 0, 0.42), (x + 0.45, 0.45, 0.46))
    box(f"{name} back", (x, 0.41, 0.46), (x + 0.45, 0.45, 0.95))
    box(f"{name} legs", (x + 0.02, 0.02, 0), (x + 0.43, 0.43, 0.42))


def groups() -> list[set[str]]:
    """The names of each group of the scene's objects, by what is shown; renders must tell the same."""
    items = [item for item in context.scene.objects if item.type == "MESH"]
    layer = context.view_layer
    layer.update()
    with scratch_scene(context.scene) as scratch:
        rendered = surfaces_in_render(scratch, items)
    shown = surfaces_shown(layer, items)
    assert None not in shown
    found = asset_groups([one for one in shown if one is not None])
    assert asset_groups([one for one in rendered if one is not None]) == found
    return [{items[index].name for index in group} for group in found]


def test_what_stands_on_one_floor_or_side_by_side_is_not_one() -> None:
    floor()
    chair("A", 0)
    chair("B", 0.5)  # five centimetres apart
    box("Sofa", (-2, -2, 0), (0.2, -1.1, 0.8))
    parts = ("seat", "back", "legs")
    assert groups() == [{f"A {part}" for part in parts}, {f"B {part}" for part in parts}]


def test_a_pile_of_spheres_that_touch_is_one() -> None:
    floor()
    for x in range(3):
        for y in range(2):
            ball(f"Low {x} {y}", 0.5, (x, y, 0.5))
    ball("High", 0.5, (0.5, 0.5, 0.5 + 0.5**0.5))
    assert [len(group) for group in groups()] == [7]


def test_a_hair_between_two_things_counts_as_contact_and_a_finger_does_not() -> None:
    box("Table", (0, 0, 0), (1, 1, 0.7))
    ball("Plate", 0.15, (0.5, 0.5, 0.851))  # a millimetre above
    assert groups() == [{"Table", "Plate"}]
    context.scene.objects["Plate"].location.z += 0.01
    assert groups() == []


def test_what_lies_inside_another_is_one_with_it() -> None:
    ball("Shell", 1, (0, 0, 0))
    ball("Core", 0.6, (0, 0, 0))
    assert groups() == [{"Shell", "Core"}]


def test_a_room_and_walls_are_no_part_of_what_stands_there() -> None:
    box("Room", (-3, -3, 0), (3, 3, 2.6))
    chair("A", 0)
    assert groups() == [{"A seat", "A back", "A legs"}]
    bpy.data.objects.remove(context.scene.objects["Room"])
    box("Wall", (-2, 0.45, 0), (2, 0.5, 2.6))
    assert groups() == [{"A seat", "A back", "A legs"}]


def test_a_table_keeps_its_top() -> None:
    floor()
    box("Top", (0, 0, 0.72), (1.8, 0.9, 0.75))
    for x in (0.1, 1.65):
        for y in (0.1, 0.75):
            box(f"Leg {x} {y}", (x, y, 0), (x + 0.05, y + 0.05, 0.72))
    assert [len(group) for group in groups()] == [5]


def test_versions_of_one_thing_in_one_place_are_none() -> None:
    for name, count in (("Fine", 64), ("Coarse", 24)):
        bpy.ops.mesh.primitive_uv_sphere_add(segments=count, ring_count=count // 2)
        context.object.name = name
    assert groups() == []


def test_modifiers_count_as_they_render() -> None:
    box("A", (0, 0, 0), (1, 1, 1))
    box("B", (2, 0, 0), (3, 1, 1))
    more: Any = context.scene.objects["A"].modifiers.new("Array", "ARRAY")
    assert groups() == [{"A", "B"}]
    more.show_render = False
    layer, items = context.view_layer, list(context.scene.objects)
    with scratch_scene(context.scene) as scratch:
        rendered = surfaces_in_render(scratch, items)
    assert asset_groups([one for one in rendered if one is not None]) == []
    assert len(asset_groups([one for one in surfaces_shown(layer, items) if one is not None])) == 1


def test_what_is_not_finite_or_has_no_face_is_none() -> None:
    ball("Ball", 1, (0, 0, 0))
    broken = ball("Broken", 1, (0, 0, 0))
    broken.data.vertices[3].co.x = float("inf")
    mesh = bpy.data.meshes.new("Bare")
    context.scene.collection.objects.link(bpy.data.objects.new("Bare", mesh))
    context.view_layer.update()
    found = surfaces_shown(context.view_layer, list(context.scene.objects))
    assert [one is None for one in found] == [False, True, True]


def test_a_pair_is_looked_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = []
    touch = touching._touch

    def counted(*pair: Any) -> bool:
        asked.append(pair)
        return touch(*pair)

    monkeypatch.setattr(touching, "_touch", counted)
    monkeypatch.setattr(touching, "_pairs", touching._Pairs())
    ball("A", 1, (0, 0, 0))
    ball("B", 1, (1, 0, 0))
    ball("C", 1, (2, 0, 0))
    groups()
    assert len(asked) == 2, "A and C belong together by way of B"
    groups()
    assert len(asked) == 2
    context.scene.objects["C"].location.x = 2.3
    groups()
    assert len(asked) == 3, "C has moved: it is compared with B, as it is far from A"
