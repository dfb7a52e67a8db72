# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Aimed rays: they go where they say, and bring what layered bakes and the baselines are fitted to."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np
import pytest

from radtex_addon.bake.light_samples import EndSamples, mirrored
from radtex_addon.bake.plan import CapturePlan
from radtex_addon.bake.progress import finished
from radtex_addon.core.arrays import Floats
from radtex_addon.core.frame import normalised
from radtex_addon.cycles.path_ends import Body, PathEnds, path_ends
from radtex_addon.cycles.portal import Aim, PortalCapture
from radtex_addon.cycles.sampling import DIFFUSE, capture_ends, capture_samples, straight_shifts
from radtex_addon.scene.mesh.render_contents import read_beside
from radtex_addon.scene.scratch import scratch_scene
from radtex_addon.settings.kinds import Kind
from tests.blender import stage

context: Any = bpy.context  # to the stubs, every pointer may be None

TINT = (0.8, 0.4, 0.2, 1)


@contextmanager
def scratch() -> Iterator[bpy.types.Scene]:
    with scratch_scene(context.scene, context.scene.view_layers[0].name) as copy:
        yield copy


def card(shader: str = "ShaderNodeBsdfDiffuse", size: float = 2, **inputs: object) -> Any:
    """A square on z = 0, tinted."""
    bpy.ops.mesh.primitive_plane_add(size=size)
    context.object.data.materials.append(stage.material(shader, shader, Color=TINT, **inputs))
    return context.object


def mirror() -> Any:
    """A card that reflects perfectly, but for its tint."""
    return card("ShaderNodeBsdfAnisotropic", Roughness=0.0)


def corner(floor: Any) -> Any:
    """The floor with a wall at x = 1 that looks at it: one object, the wall has its last material."""
    bpy.ops.mesh.primitive_plane_add(size=2, location=(1, 0, 1), rotation=(0, -1.5707963, 0))
    wall = context.object
    for material in floor.data.materials:
        wall.data.materials.append(material)
    wall.data.polygons[0].material_index = len(wall.data.materials) - 1
    with context.temp_override(active_object=floor, selected_editable_objects=[floor, wall]):
        bpy.ops.object.join()
    return floor


def upward(count: int, bucket: int) -> CapturePlan:
    """Texels on the plane z = 0 that look up."""
    position = np.random.default_rng(1).uniform(-0.9, 0.9, (count, 3)) * [1, 1, 0]
    return stage.plan_of(position, np.tile([0.0, 0, 1], (count, 1)), bucket)


def nothing_hidden(plan: CapturePlan) -> Any:
    return np.zeros((len(plan.texel), 4, 4), dtype=bool)


@contextmanager
def ends_in_scratch(baked: Any, middle: tuple[float, ...]) -> Iterator[tuple[bpy.types.Scene, PathEnds]]:
    with scratch() as scene:
        beside = read_beside(scene, baked)
        with path_ends(
            scene, [Body(baked, baked.data, beside.matrix)], beside.others, np.array(middle)
        ) as ends:
            yield scene, ends


def ends_of(baked: Any, folder: Path, plan: CapturePlan, middle: tuple[float, ...] = (0, 0, 0)) -> EndSamples:
    with ends_in_scratch(baked, middle) as (_, ends):
        return capture_ends(ends, plan, 3, folder)


def starts(plan: CapturePlan) -> Floats:
    return plan.position.reshape(-1, 1, 3).astype(float)


# light


def test_a_furnace_is_all_diffuse_light_and_has_its_colour(tmp_path: Path) -> None:
    stage.world()
    card()
    plan = upward(16, 8)
    with scratch() as scene:
        samples = finished(capture_samples(scene, plan, nothing_hidden(plan), 0, tmp_path))
    assert samples.mirrored.shape == samples.through.shape == samples.diffuse.shape == (16, 64, 3)
    expected = np.broadcast_to(TINT[:3], (16, 64, 3))
    np.testing.assert_allclose(samples.diffuse.astype(float), expected, atol=1e-3)
    np.testing.assert_allclose(samples.mirrored.astype(float), 0, atol=1e-3)
    assert not samples.through.any()
    np.testing.assert_allclose(samples.colour, expected[:, 0], atol=1e-4)
    assert samples.seen.all()


@pytest.mark.parametrize(
    ("lobe", "shader"),
    [("mirrored", "ShaderNodeBsdfAnisotropic"), ("through", "ShaderNodeBsdfRefraction")],
)
def test_mirrored_light_is_told_from_what_comes_through(lobe: str, shader: str, tmp_path: Path) -> None:
    stage.world((1, 2, 3))
    card(shader, Roughness=0.0)
    plan = upward(4, 4)
    with scratch() as scene:
        samples = finished(capture_samples(scene, plan, nothing_hidden(plan), 0, tmp_path))
    light = {name: getattr(samples, name).astype(float) for name in ("diffuse", "mirrored", "through")}
    expected = np.broadcast_to(np.array(TINT[:3]) * [1, 2, 3], (4, 16, 3))
    np.testing.assert_allclose(light.pop(lobe), expected, rtol=2e-3)
    for other in light.values():
        np.testing.assert_allclose(other, 0, atol=2e-3)


@pytest.mark.one_blender
def test_hidden_directions_are_marked_by_the_cell_that_holds_them(tmp_path: Path) -> None:
    stage.world()
    card()
    plan = upward(5, 8)
    hidden = nothing_hidden(plan)
    hidden[2, 1, 3] = True
    with scratch() as scene:
        samples = finished(capture_samples(scene, plan, hidden, 0, tmp_path))
    texel, ray = np.nonzero(~samples.seen)
    assert set(texel) == {2}
    assert len(ray) == 4  # of 8 x 8 rays, four lie in each of 4 x 4 cells
    place = (samples.square[:][2, ray] + 1) / 2 * 4
    assert (np.floor(place) == [3, 1]).all()


# where paths end


def test_a_mirrors_paths_end_in_the_mirror_direction(tmp_path: Path) -> None:
    stage.world()
    plan = upward(12, 6)
    found = ends_of(mirror(), tmp_path, plan)
    weight = np.broadcast_to(TINT[:3], (12, 36, 3))
    np.testing.assert_allclose(found.mirrored_weight.astype(float), weight, rtol=2e-3)
    np.testing.assert_allclose(found.mirrored_end.astype(float), mirrored(plan, found.square[:]), atol=2e-3)
    np.testing.assert_allclose(found.through_weight.astype(float), 0, atol=1e-3)
    np.testing.assert_allclose(found.through_end.astype(float), 0, atol=1e-3)


@pytest.mark.one_blender
def test_a_near_things_direction_is_seen_from_the_middle(tmp_path: Path) -> None:
    """All paths end on a ceiling at z = 3, where numpy's rays meet it."""
    middle = (0.5, -0.25, 0.0)
    baked = mirror()
    card(size=2000).location.z = 3
    plan = upward(12, 6)
    found = ends_of(baked, tmp_path, plan, middle)
    away = mirrored(plan, found.square[:]).astype(float)
    met = starts(plan) + away * (3 / away[..., 2:])
    near = away[..., 2] > 0.05  # elsewhere the ceiling ends before the ray meets it
    assert near.mean() > 0.9
    expected = normalised(met - middle)
    np.testing.assert_allclose(found.mirrored_end.astype(float)[near], expected[near], atol=3e-3)


def test_an_object_without_material_lets_through_what_it_does_in_the_users_scene(tmp_path: Path) -> None:
    """Blender 5 gives it a coat, 4.5 does not."""
    stage.world()
    bpy.ops.mesh.primitive_plane_add(size=2)
    baked, plan = context.object, upward(64, 12)
    found = ends_of(baked, tmp_path, plan)
    with scratch() as scene:
        light = finished(capture_samples(scene, plan, nothing_hidden(plan), 0, tmp_path))
    mean = light.mirrored.astype(float).mean()
    assert (mean > 0.05) == (bpy.app.version >= (5, 0, 0))
    np.testing.assert_allclose(found.mirrored_weight.astype(float).mean(), mean, atol=5e-3)
    assert not found.through_weight.any()


@pytest.mark.one_blender
@pytest.mark.parametrize("tint", [(1, 0, 0, 1), (0, 0.25, 0.5, 1)])
def test_light_goes_straight_through_a_tinted_slab(tint: Any, tmp_path: Path) -> None:
    """Two refractions at parallel faces leave the direction what it was, and each takes the tint."""
    stage.world()
    bpy.ops.mesh.primitive_cube_add(size=1, location=(0, 0, -0.05))
    slab = context.object
    slab.scale = (400, 400, 0.1)
    slab.data.materials.append(
        stage.material("tinted", "ShaderNodeBsdfRefraction", Color=tint, Roughness=0.0, IOR=1.3)
    )
    plan = upward(12, 6)
    found = ends_of(slab, tmp_path, plan)
    weight = np.broadcast_to(np.array(tint[:3]) ** 2, (12, 36, 3))
    np.testing.assert_allclose(found.through_weight.astype(float), weight, atol=2e-3)
    straight = mirrored(plan, found.square[:]) * [1, 1, -1]
    np.testing.assert_allclose(found.through_end.astype(float), straight, atol=3e-3)
    np.testing.assert_allclose(found.mirrored_weight.astype(float), 0, atol=1e-3)


@pytest.mark.parametrize("grouped", [False, True])
def test_what_glows_of_the_object_itself_brings_nothing(grouped: bool, tmp_path: Path) -> None:
    """A mirror before a glowing wall of the same mesh."""
    stage.world()
    floor = mirror()
    glow = stage.material("glow", "ShaderNodeEmission", Color=(1, 1, 1, 1), Strength=50.0)
    if grouped:
        glow = in_a_group(glow)
    floor.data.materials.append(glow)
    plan = upward(12, 6)
    found = ends_of(corner(floor), tmp_path, plan)
    weight = found.mirrored_weight.astype(float)[..., 0]
    away = mirrored(plan, found.square[:]).astype(float)
    wall = starts(plan) + away * ((1 - starts(plan)[..., :1]) / away[..., :1])
    meets = (away[..., 0] > 0) & (np.abs(wall[..., 1]) < 1) & (np.abs(wall[..., 2] - 1) < 1)
    assert 0.05 < meets.mean() < 0.9
    np.testing.assert_allclose(weight, np.where(meets, 0, TINT[0]), atol=2e-3)
    assert glow.name in bpy.data.materials
    assert len(bpy.data.materials) == 2


def in_a_group(material: Any) -> Any:
    """The material with its shader in a node group, its strength driven."""
    group: Any = bpy.data.node_groups.new("lamp", "ShaderNodeTree")
    group.interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
    emission = group.nodes.new("ShaderNodeEmission")
    emission.inputs["Strength"].driver_add("default_value").driver.expression = "50"
    group.links.new(emission.outputs[0], group.nodes.new("NodeGroupOutput").inputs[0])
    tree = material.node_tree
    tree.nodes.clear()
    node = tree.nodes.new("ShaderNodeGroup")
    node.node_tree = group
    tree.links.new(node.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return material


@pytest.mark.parametrize("trouble", ["parent", "constraint", "driver", "rigid body"])
def test_the_object_stays_where_it_renders(trouble: str, tmp_path: Path) -> None:
    """Paths meet the mirror where it is in the user's scene, sheared or moved as it may be."""
    stage.world()
    baked = mirror()
    if trouble == "parent":
        holder = bpy.data.objects.new("holder", None)
        context.scene.collection.objects.link(holder)
        holder.scale, holder.location = (3, 1, 1), (0, 0, 1)
        baked.parent, baked.rotation_euler.z = holder, 0.5
    elif trouble == "constraint":
        limit = baked.constraints.new("LIMIT_LOCATION")
        limit.use_min_z, limit.min_z = True, 1
    elif trouble == "driver":
        baked.driver_add("location", 2).driver.expression = "1"
    else:
        baked.location.z = 1
        context.view_layer.objects.active = baked
        bpy.ops.rigidbody.object_add()
        baked.rigid_body.type = "PASSIVE"
    context.view_layer.update()
    np.testing.assert_allclose(baked.matrix_world.translation[:], [0, 0, 1])
    position = np.random.default_rng(1).uniform(-0.6, 0.6, (6, 3)) * [1, 1, 0] + [0, 0, 1]
    plan = stage.plan_of(position, np.tile([0.0, 0, 1], (6, 1)), 4)
    found = ends_of(baked, tmp_path, plan)
    weight = np.broadcast_to(TINT[:3], (6, 16, 3))
    np.testing.assert_allclose(found.mirrored_weight.astype(float), weight, rtol=2e-3)


@pytest.mark.parametrize(("count", "width"), [(1, 0.01), (16, 1.0)])
def test_a_ray_from_a_known_start_goes_through_its_pixel_s_middle(
    count: int, width: float, tmp_path: Path
) -> None:
    """Of several starts each has a part of the pixel; of one, another place in it is another direction."""
    card()
    plan = stage.plan_of(np.zeros((4, 3)), np.tile([0.0, 0, 1], (4, 1)), 1)
    with scratch() as scene:
        aim = Aim(straight_shifts(4), DIFFUSE, np.repeat(plan.points[:, None], count, axis=1))
        PortalCapture(scene, plan, Kind.RADIANCE, 1, 1, tmp_path, aim)
        assert cast(Any, scene).cycles.filter_width == pytest.approx(width)
