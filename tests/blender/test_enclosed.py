# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What lies inside a clear object belongs to what light passes through; and how paths leave glass."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any, cast

import bmesh
import bpy
import numpy as np
import pytest

from radtex_addon.bake.plan import CapturePlan, plan_capture
from radtex_addon.bake.pooling import Neighbours
from radtex_addon.bake.progress import finished
from radtex_addon.core.hemisphere import cell_centres, square_to_direction
from radtex_addon.cycles.path_ends import Body
from radtex_addon.formats.containers.exr import read_whole
from radtex_addon.forms.layered.capture.clear_shape import find_distance_field
from radtex_addon.forms.layered.capture.enclosed import enclosed
from radtex_addon.forms.layered.capture.exits import capture_exits
from radtex_addon.forms.layered.capture.gloss_maps import width_of
from radtex_addon.forms.layered.cells import FIELD_SAMPLES
from radtex_addon.forms.layered.fit.through import fit_ways
from radtex_addon.forms.layered.lookup.distance_field import DistanceField
from radtex_addon.job import bake_object
from radtex_addon.prepare.prepared import prepare
from radtex_addon.scene.mesh.copy import baked_mesh
from radtex_addon.scene.mesh.evaluated import evaluate
from radtex_addon.scene.nodes import open_world
from radtex_addon.scene.objects import find_object
from radtex_addon.scene.scratch import scratch_scene
from radtex_addon.settings.spec import BakeSpec, Layout, Unwrap
from tests.bench.fidelity.scenes.materials import assign, principled
from tests.bench.fidelity.scenes.meshes import as_subject, made
from tests.blender import stage

context: Any = bpy.context  # to the stubs, every pointer may be None
_SPEC = BakeSpec(layout=Layout.LAYERED, texels=32)
_CELLS = 4


def glass() -> bpy.types.Material:
    return stage.material("glass", "ShaderNodeBsdfGlass", IOR=1.0)


def plaster() -> bpy.types.Material:
    return stage.material("plaster", "ShaderNodeBsdfDiffuse")


def cube(name: str, material: bpy.types.Material, size: float, place: tuple[float, float, float]) -> Any:
    bpy.ops.mesh.primitive_cube_add(size=size, location=place)
    item = context.object
    item.name = name
    item.data.materials.append(material)
    return item


@pytest.fixture
def block() -> Iterator[tuple[bpy.types.Scene, Body, CapturePlan]]:
    """A scratch scene with a cube of 2 m, which things lie in and around, as a body, and its plan."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    subject = cube("Block", glass(), 2, (0, 0, 0))
    cube("Cast in it", plaster(), 0.6, (0.5, 0, 0))
    cube("Bubble", glass(), 0.4, (-0.5, 0, 0))
    glow = stage.material("glow", "ShaderNodeEmission", Strength=1.0)
    cube("Filament", glow, 0.2, (0, -0.5, 0))
    cube("Unseen", plaster(), 0.2, (0, 0.5, 0)).hide_render = True
    cube("Beside it", plaster(), 0.6, (2, 0, 0))
    cube("Half in it", plaster(), 0.6, (0, 0, 1.1))
    cube("Case", plaster(), 6, (0, 0, 0))
    bpy.ops.mesh.primitive_plane_add(size=20, location=(0, 0, -1))
    context.object.name = "Floor"
    kept: list[bpy.types.ID] = []
    with scratch_scene(context.scene, None, kept) as scratch:
        prepared = finished(prepare(scratch, [subject], _SPEC, kept))
        yield scratch, Body(subject, prepared.mesh, np.eye(4)), plan_capture(prepared.texels(), _CELLS)


def test_what_lies_inside_a_clear_object_is_found(
    block: tuple[bpy.types.Scene, Body, CapturePlan],
) -> None:
    scratch, body, _ = block
    meshes = len(bpy.data.meshes)
    with enclosed(scratch, [body]) as inside:
        materials = {one.original.name: one.mesh.materials[0] for one in inside}
        assert sorted(materials) == ["Bubble", "Cast in it"]
        assert materials["Bubble"] == bpy.data.objects["Bubble"].data.materials[0]
        assert materials["Cast in it"] not in tuple(bpy.data.objects["Cast in it"].data.materials)
    assert len(bpy.data.meshes) == meshes


def test_an_opaque_object_has_nothing_inside(block: tuple[bpy.types.Scene, Body, CapturePlan]) -> None:
    scratch, body, _ = block
    body.original.material_slots[0].material = plaster()
    with enclosed(scratch, [body]) as inside:
        assert inside == ()


@pytest.mark.one_blender
def test_paths_end_at_what_is_cast_in_and_pass_a_bubble(
    block: tuple[bpy.types.Scene, Body, CapturePlan], tmp_path: Path
) -> None:
    scratch, body, plan = block
    with enclosed(scratch, [body]) as inside:
        exits = capture_exits(scratch, [body, *inside], np.zeros(3, np.float32), 2, plan, 2, 1, tmp_path)
    upper = plan.normals[:, 2] > 0.99
    steep = square_to_direction(cell_centres(_CELLS).reshape(-1, 2))[:, 2] > 0.8
    through = exits.weight.mean(axis=0)[:, steep].mean(axis=1)
    above = np.abs(plan.points[:, 1]) < 0.1
    x = plan.points[:, 0]
    assert through[upper & above & (np.abs(x - 0.5) < 0.1)].max() < 0.05
    assert through[upper & above & (np.abs(x + 0.5) < 0.1)].min() > 0.9


_TIMES, _INDEX, _THICK = 3, 1.5, 0.2  # of the sheet of glass


@pytest.mark.one_blender
def test_a_sheet_of_glass_moves_rays_aside(tmp_path: Path) -> None:
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.ops.mesh.primitive_cube_add(size=1)
    sheet = as_subject(made())
    sheet.dimensions = (2, 2, _THICK)
    bpy.ops.object.transform_apply(scale=True)
    assign(sheet, principled("Glass", (1, 1, 1), Transmission_Weight=1.0, IOR=_INDEX, Roughness=0.0))
    kept: list[bpy.types.ID] = []
    scene = cast(bpy.types.Scene, bpy.context.scene)
    with scratch_scene(scene, None, kept) as scratch:
        item = find_object(scratch, sheet.name)
        prepared = finished(prepare(scratch, [item], BakeSpec(layout=Layout.LAYERED, texels=32), kept))
        plan = plan_capture(prepared.texels(), _CELLS)
        body = Body(item, prepared.mesh, np.eye(4))
        exits = capture_exits(scratch, [body], np.zeros(3, np.float32), 1.6, plan, _TIMES, 1, tmp_path)
    ways = fit_ways(exits, Neighbours(plan))
    top = (plan.normals[:, 2] > 0.99) & (np.abs(plan.points[:, :2]).max(axis=1) < 0.6)  # far from the sides
    assert top.sum() > 20
    viewer = square_to_direction(cell_centres(_CELLS).reshape(-1, 2))
    steep = viewer[:, 2] > 0.5
    found = ways[:, top][:, :, steep] / ways[3, top][:, steep]
    straight = np.broadcast_to(-viewer[steep].T[:, None], found[:3].shape)
    assert (np.abs(found[:3] - straight).max(axis=0) < 5e-3).mean() > 0.97
    sine = np.sqrt(1 - viewer[steep, 2] ** 2)
    inside = sine / _INDEX
    aside = _THICK * (inside / np.sqrt(1 - inside**2) * viewer[steep, 2] - sine)  # against the ray's drift
    length = np.linalg.norm(found[4:7], axis=0)
    assert (np.abs(length + aside) < 3e-3).mean() > 0.97  # a path may go astray
    normal = (1 - 1 / _INDEX) ** 2 / (1 + 1 / _INDEX) ** 2
    assert abs(float(np.median(ways[3, top][:, steep])) - (1 - normal) ** 2) < 0.06


def field_of(*items: tuple[Any, bpy.types.Material]) -> DistanceField | None:
    """The field of objects of the open scene, each of one material."""
    bodies = []
    for item, material in items:
        item.data.materials.clear()
        item.data.materials.append(material)
        shown = baked_mesh(evaluate(context.scene, item), np.zeros((len(item.data.loop_triangles), 3, 2)))
        bodies.append(Body(item, shown, np.array(item.matrix_world)))
    return find_distance_field(context.scene, bodies, np.array([0, 0, 1.0]))


def ball(radius: float, flipped: bool = False, place: tuple[float, float, float] = (0.5, 0, 1)) -> Any:
    bpy.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=24, radius=radius, location=place)
    bpy.ops.object.shade_smooth()
    item = context.object
    if flipped:
        item.data.flip_normals()
    item.data.calc_loop_triangles()
    context.view_layer.update()
    return item


def clear(ior: float = 1.5, colour: tuple[float, float, float] = (1, 1, 1)) -> bpy.types.Material:
    return principled("Glass", colour, Transmission_Weight=1.0, IOR=ior, Roughness=0.2)


@pytest.mark.one_blender
def test_closed_glass_has_a_field_of_distances() -> None:
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    context.scene.cycles.glossy_bounces = 3
    field = field_of((ball(1.0), clear()))
    assert field is not None
    facts = field.facts
    assert max(facts.size) == FIELD_SAMPLES
    assert (facts.ior, facts.reflections) == (1.5, 3)
    assert facts.slopes == pytest.approx(float(width_of(np.array(0.2))) / 4)
    place = np.array([[0.5, 0.3, 0], [1.4, 0, 0], [0.5, 0, 1.05], [0.5, 0.5, 0.5]], np.float32)
    values = field.at((place - facts.low) / facts.step)
    away = place - [0.5, 0, 0]
    far = np.linalg.norm(away, axis=1)
    assert values[:, 3] * facts.step == pytest.approx(far - 1, abs=0.02)  # it is no true ball
    assert (values[:, :3] * away).sum(axis=1) == pytest.approx(far, abs=0.02)


@pytest.mark.one_blender
@pytest.mark.parametrize(("radius", "place"), [(0.05, (50.0, -3.0, 20.0)), (400.0, (0.0, 0.0, 0.0))])
def test_a_field_is_the_same_far_away_and_of_any_size(
    radius: float, place: tuple[float, float, float]
) -> None:
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    near, far = field_of((ball(1.0), clear())), field_of((ball(radius, place=place), clear()))
    assert near is not None
    assert far is not None
    assert far.facts.size == near.facts.size
    assert far.facts.step == pytest.approx(near.facts.step * radius, rel=1e-3)
    wrong = np.abs(far.values - near.values)
    assert wrong[..., 3].max() < 0.02  # steps; vertices far away are single floats
    assert np.quantile(wrong[..., :3], 0.99) < 0.01


@pytest.mark.one_blender
def test_what_is_in_a_bubble_is_outside() -> None:
    """Its normals point into it."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    glass_, shell, bubble = clear(), ball(1.0), ball(0.4, flipped=True)
    field = field_of((shell, glass_), (bubble, glass_))
    assert field is not None
    place = np.array([[0.5, 0, 0.2], [0.5, 0, 0.3], [0.5, 0, 0.6], [0.5, 0, 1.05]], np.float32)
    values = field.at((place - field.facts.low) / field.facts.step)
    assert values[:, 3] * field.facts.step == pytest.approx([0.2, 0.1, -0.2, 0.05], abs=0.02)
    assert field_of((shell, glass_), (ball(0.4), glass_)) is None


@pytest.mark.one_blender
def test_a_small_hole_is_no_harm() -> None:
    """Light samples judge what is shown: rays through it are few."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    item = ball(1.0)
    shape = bmesh.new()
    shape.from_mesh(item.data)
    bmesh.ops.delete(shape, geom=cast(Any, list(shape.faces)[600:604]), context="FACES")
    shape.to_mesh(item.data)
    item.data.calc_loop_triangles()
    assert field_of((item, clear())) is not None


@pytest.mark.one_blender
def test_a_field_knows_how_surfaces_tint_light() -> None:
    """Of all glass by its colour, of several colours or a textured one by none."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    item, red = ball(1.0), clear()
    tree: Any = red.node_tree
    colour = tree.nodes["Principled BSDF"].inputs["Base Color"]
    colour.default_value = (0.81, 0.25, 1.0, 1.0)

    def tint_of(*items: tuple[Any, bpy.types.Material]) -> tuple[list[float], bool]:
        field = field_of(*items)
        assert field is not None
        return np.round(field.facts.tint, 4).tolist(), field.facts.tints_reflections

    assert tint_of((item, red)) == ([0.9, 0.5, 1.0], False)
    assert tint_of((item, red), (ball(0.3, flipped=True), clear()))[0] == [1.0, 1.0, 1.0]
    single = tree.nodes.new("ShaderNodeRGB")
    single.outputs[0].default_value = (0.64, 1.0, 0.25, 1.0)
    tree.links.new(single.outputs[0], colour)
    assert tint_of((item, red)) == ([0.8, 1.0, 0.5], False)
    tree.links.new(tree.nodes.new("ShaderNodeTexChecker").outputs[0], colour)
    assert tint_of((item, red))[0] == [1.0, 1.0, 1.0]
    shader = tree.nodes.new("ShaderNodeBsdfGlass")
    shader.inputs["Color"].default_value = (0.5, 0.75, 1.0, 1.0)
    tree.links.new(shader.outputs[0], tree.get_output_node("CYCLES").inputs["Surface"])
    assert tint_of((item, red)) == ([0.5, 0.75, 1.0], True)


@pytest.mark.one_blender
@pytest.mark.parametrize(
    "case", ["open", "inside out", "two kinds", "opaque in part", "a normal map", "roughness from an image"]
)
def test_what_rays_cannot_be_followed_through_has_no_field(case: str) -> None:
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    item, material = ball(1.0, flipped=case == "inside out"), clear()
    if case == "open":
        bpy.ops.mesh.primitive_plane_add()
        item = context.object
        item.data.calc_loop_triangles()
    tree: Any = material.node_tree
    glass_node = tree.nodes["Principled BSDF"]
    if case == "a normal map":
        tree.links.new(tree.nodes.new("ShaderNodeBump").outputs[0], glass_node.inputs["Normal"])
    if case == "roughness from an image":
        tree.links.new(tree.nodes.new("ShaderNodeTexImage").outputs[0], glass_node.inputs["Roughness"])
    others = {"two kinds": [(ball(0.4), clear(1.3))], "opaque in part": [(ball(0.4), plaster())]}
    assert field_of((item, material), *others.get(case, [])) is None


@pytest.mark.one_blender
def test_a_bake_of_closed_glass_follows_rays_through_its_field(tmp_path: Path) -> None:
    """Samples choose it before the rays of cells; an orange ball is seen through it."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = context.scene
    scene.world, build = open_world("Sky")
    build.node("ShaderNodeOutputWorld", build.node("ShaderNodeBackground", (0.5, 0.5, 0.5, 1)).outputs[0])
    assign(ball(0.5, place=(0, 2, 0)), principled("Orange", (0.8, 0.3, 0.1)))
    item = ball(1.0, place=(0, 0, 0))
    assign(item, clear(colour=(0.9, 0.6, 0.3)))
    spec = BakeSpec(layout=Layout.LAYERED, texels=24, unwrap=Unwrap.BLENDER)
    found = bake_object(scene, item.name, spec, tmp_path)
    through = json.loads(found.files.sidecar.read_text(encoding="utf-8"))["layered"]["through"]
    assert through["field"]["ior"] == 1.5
    assert through["field"]["all_around"] in (0, 1)
    assert through["field"]["tint"] == pytest.approx(np.sqrt([0.9, 0.6, 0.3]))
    colour = read_whole(tmp_path / f"{item.name}.radiance.through_colour.exr")[0]
    assert colour / colour[..., :1] == pytest.approx(
        np.broadcast_to([1, 2 / 3, 1 / 3], colour.shape), rel=2e-3
    )
    assert 0.75 < float(np.median(colour[..., 0])) <= 0.9  # of both its ends; rough glass swallows some
