# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Mirror rays that the layers of surroundings would show wrongly: a post before a wall, from a floor."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import groupby
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.bake.light_samples import mirrored
from radtex_addon.bake.progress import Progress, Stage, finished
from radtex_addon.core.arrays import Bools, Floats
from radtex_addon.core.fragments import Fragments
from radtex_addon.formats.sidecar import Sidecar
from radtex_addon.forms.layered.capture import capturing
from radtex_addon.forms.layered.capture.capturing import capture_layered
from radtex_addon.forms.layered.capture.misled_rays import Misled, find_misled
from radtex_addon.forms.layered.files.sidecar import LayeredSidecar
from radtex_addon.forms.layered.fit.fitting import fit_layered
from radtex_addon.forms.layered.lookup.atlas import LayeredAtlas, sample_layered
from radtex_addon.forms.layered.samples import LayeredSamples, OwnRays
from radtex_addon.job import bake_object, bake_steps
from radtex_addon.job.split_parts import part_specs
from radtex_addon.prepare.prepared import prepare
from radtex_addon.scene.objects import find_object
from radtex_addon.scene.scratch import scratch_scene
from radtex_addon.settings.spec import BakeSpec, Layout, Split
from tests.blender import stage

pytestmark = [pytest.mark.one_blender, pytest.mark.usefixtures("temporary")]
context: Any = bpy.context  # to the stubs, every pointer may be None

SPEC = BakeSpec(layout=Layout.LAYERED, texels=16, samples=1, half=False, uv_layer="UVMap")
POST, WALL, SKY = (np.array(colour, np.float32) for colour in ((1, 0.1, 0), (0, 0.2, 1), (0.1, 0.6, 0.1)))
LOW, HIGH = np.array([0.6, 0.4, 0]), np.array([0.8, 0.6, 1.2])  # of the post
BEHIND = 1.3  # where the wall stands, along Y


def glow(name: str, colour: Floats) -> bpy.types.Material:
    return stage.material(name, "ShaderNodeEmission", Color=(*colour.tolist(), 1), Strength=1.0)


@pytest.fixture
def corner(empty_file: None) -> Any:
    """A polished floor with a glowing post on it and a glowing wall behind."""
    bpy.ops.mesh.primitive_plane_add(size=2)
    floor = context.object
    floor.name = "Floor"
    shiny = stage.material("Floor", "ShaderNodeBsdfAnisotropic", Color=(1, 1, 1, 1), Roughness=0.05)
    floor.data.materials.append(shiny)
    bpy.ops.mesh.primitive_cube_add(size=1, location=(LOW + HIGH) / 2)
    context.object.scale = HIGH - LOW
    context.object.data.materials.append(glow("Post", POST))
    bpy.ops.mesh.primitive_plane_add(size=4, location=(0, BEHIND, 0), rotation=(np.pi / 2, 0, 0))
    context.object.name = "Wall"
    context.object.data.materials.append(glow("Wall", WALL))
    stage.world(tuple(SKY.tolist()))
    return floor


def captured(folder: Path, spec: BakeSpec = SPEC) -> LayeredSamples:
    folder.mkdir()
    kept: list[bpy.types.ID] = []
    with scratch_scene(context.scene, None, kept) as scratch:
        prepared = finished(prepare(scratch, [find_object(scratch, "Floor")], spec, kept, backs=True))
        return finished(capture_layered(scratch, prepared, spec, folder)).capture


def truth(start: Floats, axis: Floats) -> Floats:
    """The colours (N, 3) that rays (N, 3) from the floor meet."""
    with np.errstate(divide="ignore"):
        near, far = np.sort([(LOW - start) / axis, (HIGH - start) / axis], axis=0)
        to_wall = (BEHIND - start[:, 1]) / axis[:, 1]
    post = (near.max(axis=1) < far.min(axis=1)) & (far.min(axis=1) > 0)
    at = start + to_wall[:, None] * axis
    wall = (to_wall > 0) & (np.abs(at[:, 0]) < 2) & (at[:, 2] < 2)
    return np.where(post[:, None], POST, np.where(wall[:, None], WALL, SKY))


def rays_of(capture: LayeredSamples, some: Bools) -> tuple[Floats, Floats]:
    """Starts and axes of some rays, (N, 3) both."""
    row, number = np.nonzero(some)
    axis = mirrored(capture.light.plan, capture.own.rays.square[slice(None)])[row, number]
    return capture.light.plan.points[row], axis


def far_off(found: Floats, true: Floats) -> float:
    """The share of colours (N, 3) that are others."""
    return float((np.abs(found - true).max(axis=1) > 0.25).mean())


def test_rays_that_the_layers_show_wrongly_are_found_with_their_light(
    corner: Any, tmp_path: Path, whole_surroundings: None
) -> None:
    capture = captured(tmp_path / "capture")
    own, around = capture.own, capture.around
    assert own.misled is not None
    assert own.light is not None
    assert 0.02 < own.misled.mean() < 0.4
    start, axis = rays_of(capture, own.misled)
    offset, sharp = (start - around.middle).astype(np.float32), np.full(len(axis), 1e-4, np.float32)
    true = truth(start, axis)
    shown = around.look(offset, axis, sharp).T
    light = own.light[own.misled[own.hit]]
    traced = np.isfinite(light[:, 0])
    print(f"\n{own.misled.mean():.1%} are misled, of which {far_off(shown, true):.1%} were others")
    assert far_off(shown, true) > 0.8
    assert traced.any()
    np.testing.assert_allclose(light[traced], true[traced], atol=2e-3)
    assert (true[traced] == POST).all(axis=1).mean() > 0.5

    start, axis = rays_of(capture, ~own.hit)
    right = around.look(
        (start - around.middle).astype(np.float32), axis, np.full(len(axis), 1e-4, np.float32)
    )
    assert far_off(right.T, truth(start, axis)) < 0.04


def light_seen(atlas: LayeredAtlas, position: Floats, axis: Floats) -> Floats:
    """What viewers see along mirrored axes (N, 3) at places on the floor (N, 3)."""
    up = np.broadcast_to(np.array([0, 0, 1.0]), axis.shape)
    viewer = axis * [-1, -1, 1]
    uv = position[:, :2] / 2 + 0.5
    nothing = np.zeros(len(uv), np.int64)
    return sample_layered(
        atlas, Fragments(uv=uv, position=position, normal=up, viewer=viewer, material=nothing)
    )


def test_a_floor_mirrors_the_post_before_the_wall(
    corner: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def off(capture: LayeredSamples) -> float:
        rng = np.random.default_rng(1)
        place = np.concatenate([rng.uniform([0.35, 0], [0.95, 0.3], (400, 2)), np.zeros((400, 1))], axis=1)
        axis = rng.uniform(LOW, HIGH, (400, 3)) - place
        axis /= np.linalg.norm(axis, axis=1, keepdims=True)
        found = light_seen(finished(fit_layered(capture)), place, axis.astype(np.float32))
        return float(np.abs(found - truth(place, axis)).mean())

    capture = captured(tmp_path / "capture", replace(SPEC, samples=4))
    monkeypatch.setattr(capturing, "find_misled", lambda *_: None)
    without = off(captured(tmp_path / "without", replace(SPEC, samples=4)))
    print(f"\noff by {off(capture):.3f}, by the layers alone {without:.3f}")
    assert off(capture) < 0.85 * without


def _two_materials(floor: Any) -> BakeSpec:
    mesh = bpy.data.meshes.new("Halves")
    corners = [(x, y, 0) for y in (-1, 1) for x in (-1, 0, 1)]
    mesh.from_pydata(corners, [], [(0, 1, 4, 3), (1, 2, 5, 4)])
    for name in ("Left", "Right"):
        mesh.materials.append(stage.material(name, "ShaderNodeBsdfGlossy", Roughness=0.05))
    mesh.polygons[1].material_index = 1
    floor.data = mesh
    return part_specs(context.scene, "Floor", replace(SPEC, uv_layer=None, split=Split.MATERIAL))[1]


def _source(floor: Any) -> BakeSpec:
    floor.name = "High"
    bpy.ops.mesh.primitive_plane_add(size=2)
    context.object.name = "Floor"
    return replace(SPEC, uv_layer=None, source="High", extrusion=0.05)


CASES: dict[str, Callable[[Any], BakeSpec]] = {
    "draft": lambda _: replace(SPEC, samples=6),
    "part": _two_materials,
    "source": _source,
    "together": lambda _: replace(SPEC, uv_layer=None, objects=("Floor", "Wall")),
}


@pytest.mark.parametrize("case", CASES)
def test_they_are_found_in_every_kind_of_bake(
    corner: Any, out: Path, monkeypatch: pytest.MonkeyPatch, case: str
) -> None:
    found: list[Misled | None] = []

    def kept(*arguments: Any) -> Misled | None:
        found.append(find_misled(*arguments))
        return found[-1]

    spec = CASES[case](corner)
    monkeypatch.setattr(capturing, "find_misled", kept)
    bake_object(context.scene, "Pair" if spec.objects else "Floor", spec, out)
    (misled,) = found
    assert misled is not None
    assert 0.003 < misled.rays.mean() < 0.4
    with np.errstate(invalid="ignore"):
        at_post = ((misled.place > LOW - 0.01) & (misled.place < HIGH + 0.01)).all(axis=1)
    light = misled.light[at_post & np.isfinite(misled.light[:, 0])]
    assert at_post.any()
    np.testing.assert_allclose(light, np.broadcast_to(POST, light.shape), atol=2e-3)


def test_a_bake_goes_on_to_the_same_bytes_and_finds_them_once(
    corner: Any, out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = bake_object(context.scene, "Floor", SPEC, out / "whole").files
    steps = bake_steps(context.scene, "Floor", SPEC, out / "stopped")
    for step in steps:
        if step.stage == "fit":
            steps.close()

    def again(*_: Any) -> None:
        raise AssertionError("they were stored")

    monkeypatch.setattr(capturing, "find_misled", again)
    later = bake_object(context.scene, "Floor", SPEC, out / "stopped", resume=True).files
    for path in whole.sidecar.parent.glob("*.exr"):
        assert (later.sidecar.parent / path.name).read_bytes() == path.read_bytes(), path.name


def test_nothing_changes_where_the_layers_are_right(corner: Any, tmp_path: Path) -> None:
    """A floor below a sky, and a plane far below it."""
    for name in ("Cube", "Wall"):
        bpy.data.objects.remove(bpy.data.objects[name])
    bpy.ops.mesh.primitive_plane_add(size=40, location=(0, 0, -1))
    capture = captured(tmp_path / "capture")
    assert capture.own.misled is None
    assert capture.own.light is None
    atlas = finished(fit_layered(capture))
    assert (atlas.own == (0, 0, 0, 1)).all()  # it mirrors nothing of itself
    facts = Sidecar("Floor", "radiance", 16, 16, 14, "UVMap", 1, 0, "portal", "RadTex 0", "5.2")
    sidecar = LayeredSidecar.from_json(LayeredSidecar.of(atlas, facts).to_json())
    assert not sidecar.mirrors_itself


def test_things_without_faces_leave_no_ray_misled(corner: Any, tmp_path: Path) -> None:
    bpy.ops.object.volume_add(location=(0, 0, 3))
    assert captured(tmp_path / "capture").own.misled is None


def test_a_text_and_a_cord_hide_no_misled_ray(corner: Any, tmp_path: Path) -> None:
    """Their faces come as meshes, and a curve that has none shows nothing."""
    for add in (bpy.ops.object.text_add, bpy.ops.curve.primitive_bezier_curve_add):
        add(location=(-0.5, 0.9, 0.5))
    context.object.data.bevel_depth = 0.02
    bpy.ops.curve.primitive_bezier_curve_add(location=(0, 0, 0.5))
    misled = captured(tmp_path / "capture").own.misled
    assert misled is not None
    assert 0.02 < misled.mean() < 0.4


def test_misled_rays_join_those_that_meet_the_object() -> None:
    hit = np.array([[True, False, False], [False, True, False]])
    misled = np.array([[False, True, False], [True, False, False]])
    met, place = np.array([4, -1], np.int32), np.arange(6, dtype=np.float32).reshape(2, 3)
    own = OwnRays(None, hit, met, place, -place)  # type: ignore[arg-type]  # no ray is asked for
    more = np.full((2, 3), 9.0, np.float32)
    both = own.with_misled(misled, more, 2 * more, np.array([True, False]))
    np.testing.assert_array_equal(both.hit, hit | misled)
    np.testing.assert_array_equal(both.meets, hit)
    assert both.met.tolist() == [4, -1, -1, -1]
    np.testing.assert_array_equal(both.place, [place[0], more[0], more[0], place[1]])
    assert both.light is not None
    np.testing.assert_array_equal(both.light, [-place[0], 2 * more[0], 2 * more[0], -place[1]])
    assert both.traced == 6  # a path in each cell of both texels
    assert both.without(both.hit).traced == 3


def test_the_bar_moves_through_them(corner: Any, out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """No stage comes again, and what was done when they were looked for is neither nothing nor all."""
    steps: list[Progress] = []
    before: list[float] = []

    def looked(*arguments: Any) -> Misled | None:
        before.append(steps[-1].done / steps[-1].total)
        return find_misled(*arguments)

    monkeypatch.setattr(capturing, "find_misled", looked)
    for step in bake_steps(context.scene, "Floor", SPEC, out):
        assert isinstance(step, Progress)
        steps.append(step)
    stages = [stage for stage, _ in groupby(step.stage for step in steps)]
    assert stages == list(dict.fromkeys(stages))
    around = [step for step in steps if step.stage is Stage.SURROUNDINGS]
    assert [step.done for step in around] == sorted({step.done for step in around})
    assert around[-1].done == around[-1].total
    assert 0.1 < before[0] < 0.99
