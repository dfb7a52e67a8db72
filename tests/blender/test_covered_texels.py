# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Texels under, behind or inside a neighbour take their neighbours' light, not darkness or the outdoors."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.bake.plan import plan_capture
from radtex_addon.bake.progress import finished
from radtex_addon.core.arrays import Bools, Floats
from radtex_addon.cycles.path_ends import Body
from radtex_addon.formats.containers.exr import read_whole
from radtex_addon.forms.layered.capture import capturing
from radtex_addon.job import bake_object
from radtex_addon.prepare.covered_texels import covered_texels
from radtex_addon.prepare.prepared import prepare
from radtex_addon.scene.mesh.render_contents import matrices_in_renders
from radtex_addon.scene.scratch import scratch_scene
from radtex_addon.settings.spec import BakeSpec, Layout, Unwrap
from tests.blender import stage
from tests.blender.plane_room import HIGH, LONG, box, card, walls

context: Any = bpy.context  # to the stubs, every pointer may be None

HALF = LONG / 2
SIDE = 40  # texels of the floor …
WIDE = 4.8  # … of so many metres, so that its rim is beyond the walls


def covered(*names: str, every_back: bool = False, texels: int = SIDE) -> tuple[Floats, Bools]:
    """The places (K, 3) of the objects' texels in one atlas, and which of them are covered, (K,)."""
    items = [bpy.data.objects[name] for name in names]
    spec = BakeSpec(texels=texels, unwrap=Unwrap.UVUNWRAP, padding=1, objects=names if len(names) > 1 else ())
    kept: list[bpy.types.ID] = []
    with scratch_scene(context.scene, None, kept) as scratch:
        prepared = finished(prepare(scratch, items, spec, kept, backs=True))
        found = prepared.texels()
        plan = plan_capture(found, 1)
        meshes = [mesh for _, mesh in prepared.rendered]
        bodies = list(map(Body, items, meshes, matrices_in_renders(scratch, items)))
        steps = covered_texels(scratch, bodies, prepared, plan, found, every_back)
        return plan.points.copy(), finished(steps)


def at_edges(place: Floats) -> Bools:
    """Which places (K, 3) on the planes of a room lie in a corner of two of them, (K,)."""
    beside = np.abs(place[:, :2]) > HALF - 0.01
    upright = (place[:, 2] < 0.01) | (place[:, 2] > HIGH - 0.01)
    found: Bools = np.column_stack([beside, upright]).sum(axis=1) >= 2
    return found


def floor(wide: float = WIDE) -> None:
    card("Wide Floor", (0, 0, 0), (0, 0, 1), (wide, wide))


def test_a_floor_is_covered_behind_walls_of_single_planes() -> None:
    walls(without=("Floor",))
    floor()
    place, found = covered("Wide Floor")
    beyond = np.abs(place[:, :2]) > HALF
    corner = (np.abs(place[:, :2]) > HALF - 0.2).all(axis=1)
    assert beyond.any(axis=1).mean() > 0.2
    assert not found[~beyond.any(axis=1)].any()
    assert found[beyond.any(axis=1) & ~corner].all()
    assert not covered("Wide Floor", every_back=True)[1].any(), "a camera may be outdoors, too"


def test_a_wall_is_covered_below_the_floor_and_beyond_the_next_wall() -> None:
    walls(without=("West",))
    card("Wall", (-HALF, 0, HIGH / 2), (1, 0, 0), (LONG + 0.4, HIGH + 0.4))
    place, found = covered("Wall", texels=32)
    beyond = np.stack([np.abs(place[:, 1]) > HALF, np.abs(place[:, 2] - HIGH / 2) > HIGH / 2], axis=1)
    assert beyond.any(axis=1).mean() > 0.2
    assert found[beyond.any(axis=1)].all()
    assert not found[~beyond.any(axis=1)].any()


def test_a_floor_is_covered_below_thick_walls_and_not_outdoors() -> None:
    thick = 0.25
    floor()
    box("Ceiling", (0, 0, HIGH + thick / 2), (LONG + 2 * thick, LONG + 2 * thick, thick))
    for side in (-1, 1):
        box("Wall", (side * (HALF + thick / 2), 0, HIGH / 2), (thick, LONG + 2 * thick, HIGH))
        box("Wall", (0, side * (HALF + thick / 2), HIGH / 2), (LONG, thick, HIGH))
    place, found = covered("Wide Floor")
    away = np.abs(place[:, :2]).max(axis=1)
    np.testing.assert_array_equal(found, (away > HALF) & (away < HALF + thick))


@pytest.mark.parametrize("below", [0.0, 0.05, -0.008])
def test_a_floor_is_covered_below_what_stands_on_it(below: float) -> None:
    """Whether it stands on the floor, is sunk into it, or is a hair above."""
    walls(without=("Floor",))
    floor(LONG)
    box("Leg", (0.5, 0.5, 0.5 - below), (0.5, 0.5, 1))
    bpy.ops.mesh.primitive_cylinder_add(
        radius=0.15, depth=HIGH, end_fill_type="NOTHING", location=(-1, 0.5, HIGH / 2)
    )
    card("Rug", (0, -1, 0.004), (0, 0, 1), (2, 1))
    place, found = covered("Wide Floor", texels=64)
    leg = (np.abs(place[:, :2] - 0.5) < 0.26).all(axis=1)
    under_leg = (np.abs(place[:, :2] - 0.5) < (0.2 if below < 0 else 0.25)).all(axis=1)
    pipe = np.linalg.norm(place[:, :2] - [-1, 0.5], axis=1) < 0.16
    rug = (np.abs(place[:, :2] - [0, -1]) < [1, 0.5]).all(axis=1)
    assert under_leg.any()
    in_pipe = np.linalg.norm(place[:, :2] - [-1, 0.5], axis=1) < 0.1
    assert in_pipe.any()
    assert found[under_leg | rug | in_pipe].all()
    assert not found[~(leg | pipe | rug | at_edges(place))].any()


def test_a_wall_is_covered_behind_a_picture_in_one_atlas_and_by_itself() -> None:
    walls()
    box("Picture", (-HALF + 0.015, 0.2, 1.5), (0.03, 0.8, 0.6))
    for names in (("West",), ("West", "Floor", "North")):
        place, found = covered(*names, texels=64)
        behind = (np.abs(place[:, 1:] - [0.2, 1.5]) < [0.4, 0.3]).all(axis=1) & (place[:, 0] == -HALF)
        assert behind.any()
        np.testing.assert_array_equal(found, behind | at_edges(place))


def test_the_inside_of_planes_that_face_outwards_is_not_covered() -> None:
    walls(turned=True)
    place, found = covered("Floor", "West", texels=48)
    assert not found[~at_edges(place)].any()


def test_in_the_open_only_what_is_covered_is() -> None:
    floor()
    card("Leaf", (0.5, 0.3, 0.3), (0, 0, 1), (0.4, 0.4))
    card("Flag", (-1, -1, 1), (0, 1, 0), (0.5, 1))
    box("Crate", (1.5, 1.5, 0.5), (1, 1, 1))
    for name in ("Leaf", "Flag", "Crate"):
        place, found = covered(name, texels=24)
        np.testing.assert_array_equal(found, place[:, 2] < 0.001, err_msg=f"{name}: what stands on the floor")
    place, found = covered("Wide Floor")
    assert found.sum() == (np.abs(place[:, :2] - 1.5) < 0.5).all(axis=1).sum() / 2
    assert not found[(np.abs(place[:, :2] - 1.5) > 0.5).any(axis=1)].any()


def test_nothing_is_covered_where_nothing_else_is() -> None:
    bpy.ops.mesh.primitive_uv_sphere_add()
    context.object.name = "Ball"
    assert not covered("Ball", texels=64)[1].any()


def test_no_light_leaks_in_along_the_walls(out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Outdoors it is a thousand times as bright as in the room."""
    walls(without=("Floor",))
    floor(LONG + 0.5)
    stage.world((30, 30, 30))
    grey = stage.material("Grey", "ShaderNodeBsdfDiffuse", Color=(0.8, 0.8, 0.8, 1))
    for item in context.scene.objects:
        item.data.materials.append(grey)
    bpy.ops.object.light_add(type="POINT", location=(1, 1, 2))
    context.object.data.energy = 10
    spec = BakeSpec(layout=Layout.LAYERED, texels=18, samples=1, unwrap=Unwrap.UVUNWRAP, padding=1)

    def light(folder: Path) -> Floats:
        files = bake_object(context.scene, "Wide Floor", spec, folder).files
        (path,) = files.sidecar.parent.glob("*.irradiance.exr")
        return np.asarray(read_whole(path)[0]).mean(axis=2)

    found = light(out / "found")
    monkeypatch.setattr(capturing, "covered_texels", lambda *asked: iter_nothing(len(asked[3].texel)))
    leaking = light(out / "leaking")
    print(f"\nat most {found.max():.2f}, else {leaking.max():.1f}")
    assert found.max() < 1
    assert (leaking > 10).mean() > 0.1


def iter_nothing(texels: int) -> Any:
    """No texel is covered, as steps."""
    yield from ()
    return np.zeros(texels, dtype=bool)


def test_texels_in_a_corner_are_not_looked_at_through_the_next_wall() -> None:
    """Points at the rim of a floor lie off the walls by less than rays' starts do."""
    walls()
    place, found = covered("Floor", "West", texels=48)
    assert at_edges(place).any()
    np.testing.assert_array_equal(found, at_edges(place))
