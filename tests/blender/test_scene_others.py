# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What renders beside an object: as renders see it, not the viewport, and each where it stands."""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.scene.mesh.render_contents import RAYS, Beside, read_beside
from radtex_addon.scene.scratch import scratch_scene
from tests.blender import stage

context: Any = bpy.context  # to the stubs, every pointer may be None


@pytest.fixture
def baked() -> Any:
    bpy.ops.mesh.primitive_plane_add(location=(0, 0, -5))
    return context.object


def beside(baked: Any) -> Beside:
    with scratch_scene(context.scene) as scratch:
        return read_beside(scratch, baked)


def cube(at: tuple[float, float, float] = (0, 0, 0)) -> Any:
    bpy.ops.mesh.primitive_cube_add(size=2, location=at)
    return context.object


def places(found: Beside) -> list[list[float]]:
    return sorted(np.round(placed.matrix[:3, 3], 5).tolist() for placed in found.others)


def moved(item: Any, name: str) -> Any:
    """A new collection that holds the object alone."""
    collection = bpy.data.collections.new(name)
    context.scene.collection.children.link(collection)
    for before in list(item.users_collection):
        before.objects.unlink(item)
    collection.objects.link(item)
    return collection


def test_a_thing_is_all_its_triangles_where_it_stands(baked: Any) -> None:
    cube((1, 2, 3))
    found = beside(baked)
    (placed,) = found.others
    assert placed.shape.position.shape == (8, 3)
    assert placed.shape.triangles.shape == (12, 3)
    assert places(found) == [[1, 2, 3]]
    assert placed.seen_by == set(RAYS)
    np.testing.assert_allclose(found.matrix[:3, 3], [0, 0, -5])


def test_the_object_is_not_beside_itself_but_its_instances_are(baked: Any) -> None:
    assert beside(baked).others == ()
    collection = moved(baked, "instanced")
    collection.objects.link(cube((0, 0, 2)))
    bpy.ops.object.collection_instance_add(collection="instanced", location=(7, 0, 0))
    assert places(beside(baked)) == [[0, 0, 2], [7, 0, -5], [7, 0, 2]]


def test_instances_share_a_shape(baked: Any) -> None:
    moved(cube(), "brick")
    for x in (3, 6, 9):
        bpy.ops.object.collection_instance_add(collection="brick", location=(x, 0, 0))
    found = beside(baked)
    assert len(found.others) == 4
    assert len({placed.shape for placed in found.others}) == 1


def test_what_renders_leave_out_is_left_out(baked: Any) -> None:
    cube((1, 0, 0)).hide_render = True
    moved(cube((2, 0, 0)), "hidden").hide_render = True
    moved(cube((3, 0, 0)), "excluded")
    context.view_layer.layer_collection.children["excluded"].exclude = True
    bpy.ops.object.light_add(type="AREA")
    bpy.ops.object.camera_add()
    bpy.ops.mesh.primitive_circle_add(fill_type="NOTHING")
    assert beside(baked).others == ()


def test_what_only_the_viewport_hides_is_there(baked: Any) -> None:
    cube((1, 0, 0)).hide_viewport = True
    cube((2, 0, 0)).hide_set(True)
    moved(cube((3, 0, 0)), "hidden").hide_viewport = True
    assert places(beside(baked)) == [[1, 0, 0], [2, 0, 0], [3, 0, 0]]


def test_modifiers_are_those_of_renders(baked: Any) -> None:
    modifier = cube().modifiers.new("Subdivision", "SUBSURF")
    modifier.levels, modifier.render_levels = 0, 2
    modifier.show_viewport = False
    (placed,) = beside(baked).others
    assert len(placed.shape.triangles) == 12 * 4**2


def test_shear_is_kept(baked: Any) -> None:
    holder = bpy.data.objects.new("holder", None)
    context.scene.collection.objects.link(holder)
    holder.scale = (3, 1, 1)
    child = cube()
    child.parent, child.rotation_euler.z = holder, 0.5
    context.view_layer.update()
    (placed,) = beside(baked).others
    np.testing.assert_allclose(placed.matrix, np.array(child.matrix_world), atol=1e-6)
    axes = placed.matrix[:3, :3]
    assert abs(axes[:, 0] @ axes[:, 1]) > 1, "sheared"


def test_curves_and_texts_have_faces(baked: Any) -> None:
    bpy.ops.curve.primitive_bezier_circle_add()
    context.object.data.bevel_depth = 0.1
    bpy.ops.object.text_add()
    bpy.ops.object.metaball_add()
    assert len(beside(baked).others) == 3


def test_the_shape_of_geometry_nodes_instances_is_their_own(baked: Any) -> None:
    """The carrier has one face, and a cone on each of its corners."""
    bpy.ops.mesh.primitive_plane_add()
    group: Any = bpy.data.node_groups.new("cones", "GeometryNodeTree")
    for way in ("INPUT", "OUTPUT"):
        group.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
    nodes = [
        group.nodes.new(f"GeometryNode{kind}") for kind in ("InstanceOnPoints", "MeshCone", "JoinGeometry")
    ]
    instance, cone, joined = nodes
    source, sink = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
    group.links.new(source.outputs[0], instance.inputs["Points"])
    group.links.new(cone.outputs[0], instance.inputs["Instance"])
    group.links.new(source.outputs[0], joined.inputs[0])
    group.links.new(instance.outputs[0], joined.inputs[0])
    group.links.new(joined.outputs[0], sink.inputs[0])
    context.object.modifiers.new("Nodes", "NODES").node_group = group
    found = beside(baked)
    counts = sorted(len(placed.shape.triangles) for placed in found.others)
    assert counts[0] == 2
    assert len(counts) == 5
    assert min(counts[1:]) == max(counts) > 32


def test_rays_that_do_not_see_a_thing_are_told(baked: Any) -> None:
    item = cube()
    item.visible_glossy = False
    moved(item, "half")
    bpy.ops.object.collection_instance_add(collection="half")
    context.object.visible_camera = False
    context.view_layer.layer_collection.children["half"].indirect_only = True
    seen = sorted(sorted(set(RAYS) - placed.seen_by) for placed in beside(baked).others)
    assert seen == [["camera", "glossy"], ["camera", "glossy"]]


def test_a_volume_without_surface_lets_light_through(baked: Any) -> None:
    fog = bpy.data.materials.new("fog")
    if fog.node_tree is None:
        fog.use_nodes = True
    tree: Any = fog.node_tree
    tree.nodes.clear()
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(tree.nodes.new("ShaderNodeVolumePrincipled").outputs[0], output.inputs["Volume"])
    domain = cube()
    domain.data.materials.append(fog)
    assert beside(baked).others == ()
    domain.data.materials.append(stage.material("lid", "ShaderNodeBsdfDiffuse"))
    domain.data.polygons[0].material_index = 1
    assert [len(placed.shape.triangles) for placed in beside(baked).others] == [2]
