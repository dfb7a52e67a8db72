# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Aimed rays: they go where they say, and bring the passes that the shared layout is fitted to."""

from __future__ import annotations

from collections.abc import Generator, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar, cast

import bpy
import numpy as np

from radtex_addon.bake.light_samples import mirrored, spread_shifts
from radtex_addon.bake.plan import CapturePlan
from radtex_addon.bake.progress import Progress
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.cycles.sampling import capture_colour, capture_meetings, capture_samples
from radtex_addon.scene.scratch import scratch_scene
from tests.blender import stage

context: Any = bpy.context  # to the stubs, every pointer may be None
_Result = TypeVar("_Result")


@contextmanager
def scratch() -> Iterator[bpy.types.Scene]:
    with scratch_scene(context.scene, context.scene.view_layers[0].name) as copy:
        yield copy


def finish(steps: Generator[Progress, None, _Result]) -> _Result:
    while True:
        try:
            next(steps)
        except StopIteration as stop:
            return cast(_Result, stop.value)


def card(albedo: float, size: float = 2, at: tuple[float, float, float] = (0, 0, 0)) -> bpy.types.Object:
    bpy.ops.mesh.primitive_plane_add(size=size, location=at)
    colour = (albedo, albedo / 2, albedo / 4, 1)
    context.object.data.materials.append(stage.material("d", "ShaderNodeBsdfDiffuse", Color=colour))
    return cast(bpy.types.Object, context.object)


def upward(count: int, bucket: int) -> CapturePlan:
    """Texels on the plane z = 0 that look up."""
    position = np.random.default_rng(1).uniform(-0.9, 0.9, (count, 3)) * [1, 1, 0]
    return stage.plan_of(position, np.tile([0.0, 0, 1], (count, 1)), bucket)


def nothing_hidden(plan: CapturePlan) -> Any:
    return np.zeros((len(plan.texel), 4, 4), dtype=bool)


def test_a_furnace_is_all_diffuse_light_and_has_its_colour(tmp_path: Path) -> None:
    stage.world()
    card(0.8)
    plan = upward(16, 8)
    with scratch() as scene:
        samples = finish(capture_samples(scene, plan, nothing_hidden(plan), 0, tmp_path))
    assert samples.radiance.shape == samples.diffuse.shape == (16, 64, 3)
    expected = np.broadcast_to([0.8, 0.4, 0.2], (16, 64, 3))
    np.testing.assert_allclose(samples.radiance.astype(float), expected, atol=1e-3)
    np.testing.assert_allclose(samples.diffuse.astype(float), expected, atol=1e-3)
    np.testing.assert_allclose(samples.colour, expected[:, 0], atol=1e-4)
    assert samples.seen.all()


def test_hidden_directions_are_marked_by_the_cell_that_holds_them(tmp_path: Path) -> None:
    stage.world()
    card(0.8)
    plan = upward(5, 8)
    hidden = nothing_hidden(plan)
    hidden[2, 1, 3] = True
    with scratch() as scene:
        samples = finish(capture_samples(scene, plan, hidden, 0, tmp_path))
    texel, ray = np.nonzero(~samples.seen)
    assert set(texel) == {2}
    assert len(ray) == 4  # of 8 x 8 rays, four lie in each of 4 x 4 cells
    place = (samples.square[2, ray] + 1) / 2 * 4
    assert (np.floor(place) == [3, 1]).all()


def test_a_mirrored_ray_meets_the_ceiling_where_it_aims(tmp_path: Path) -> None:
    """The aim is exact: the point that Cycles met lies on the ray that numpy drew."""
    stage.world()
    baked = card(0.5)
    ceiling = card(0.5, size=200, at=(0, 0, 3))
    ceiling.rotation_euler = (3.14159265, 0, 0)
    plan = upward(12, 6)
    with scratch() as scene:
        meetings = capture_meetings(scene, scene.objects[baked.name], plan, 3, tmp_path)
    away = mirrored(plan, meetings.square).astype(float)
    start = plan.position.reshape(-1, 1, 3).astype(float)
    near = away[..., 2] > 0.1  # elsewhere the ceiling ends before the ray meets it
    expected = start + away * (3 / away[..., 2:])
    np.testing.assert_allclose(meetings.point[near], expected[near], rtol=2e-3, atol=5e-3)
    assert not meetings.nothing[near].any()
    assert not meetings.itself.any()


def test_what_is_met_is_told_apart(tmp_path: Path) -> None:
    stage.world()
    baked = card(0.5)
    bpy.ops.object.duplicate()
    wall = context.object
    wall.rotation_euler, wall.location = (0, 1.5707963, 0), (1, 0, 1)
    bpy.ops.object.select_all(action="DESELECT")
    baked.select_set(True)
    wall.select_set(True)
    context.view_layer.objects.active = baked
    bpy.ops.object.join()  # an open corner that reflects itself, and the empty sky
    plan = upward(12, 6)
    with scratch() as scene:
        meetings = capture_meetings(scene, scene.objects[baked.name], plan, 3, tmp_path)
    assert meetings.itself.any()
    assert meetings.nothing.any()
    assert (meetings.itself != meetings.nothing).all()  # there is nothing else
    np.testing.assert_allclose(meetings.point[meetings.itself][:, 0], 1, atol=1e-3)


def test_the_colour_lies_where_its_texels_lie(tmp_path: Path) -> None:
    stage.world()
    card(0.6)
    row = upward(8, 1)
    plan = CapturePlan(AtlasLayout(4, 4, 1), np.arange(8) + 4, *fields_of(row))
    with scratch() as scene:
        colour = capture_colour(scene, plan, 0, tmp_path)
    assert colour.shape == (4, 4, 3)
    np.testing.assert_allclose(colour, np.broadcast_to([0.6, 0.3, 0.15], (4, 4, 3)), atol=1e-4)


def fields_of(plan: CapturePlan) -> list[Any]:
    fields = (plan.position, plan.tangent, plan.bitangent, plan.normal, plan.facet)
    return [field.reshape(4, 2, 3).repeat(2, axis=1)[:, :4] for field in fields]


def test_shifts_do_not_depend_on_how_many_follow() -> None:
    assert (spread_shifts(10, 4) == spread_shifts(100, 4)[:10]).all()
