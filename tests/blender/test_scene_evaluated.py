# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The evaluated mesh is what Cycles renders, and what cannot be baked is refused by name."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.core.errors import InputError
from radtex_addon.core.surface import SurfaceMesh
from radtex_addon.scene.mesh.copy import baked_mesh, surface_mesh
from radtex_addon.scene.mesh.evaluated import EvaluatedMesh, evaluate
from radtex_addon.scene.objects import find_object
from radtex_addon.scene.scratch import scratch_scene
from tests.blender import stage
from tests.blender.shot import distance_and_normal, rendered_surface

context: Any = bpy.context  # to the stubs, every pointer may be None


def read(item: Any, view_layer: str | None = None) -> EvaluatedMesh:
    """Find and evaluate an object, as a bake does."""
    scene = context.scene
    found = find_object(scene, item.name, view_layer)
    with scratch_scene(scene, view_layer) as scratch:
        return evaluate(scratch, found)


def surface_of(item: Any) -> SurfaceMesh:
    """The baked copy of an object as arrays, each triangle on the same piece of uv."""
    with scratch_scene(context.scene) as scratch:
        evaluated = evaluate(scratch, item)
        uv = np.tile(np.array([(0, 0), (1, 0), (0, 1)], dtype=np.float32), (len(evaluated.triangles), 1, 1))
        return surface_mesh(evaluated, baked_mesh(evaluated, uv))


def hilly(faces: int = 5) -> Any:
    """A grid of bent quads, so that polygons, triangles and vertices all have different normals."""
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=faces, y_subdivisions=faces, size=2)
    item = context.object
    rng = np.random.default_rng(1)
    for vertex in item.data.vertices:
        vertex.co.z = rng.uniform(-0.2, 0.2)
    item.data.shade_smooth()
    return item


def flat(item: Any) -> None:
    item.data.shade_flat()


def smooth(item: Any) -> None:
    item.data.shade_smooth()


def some_flat(item: Any) -> None:
    for face in item.data.polygons:
        face.use_smooth = face.index % 2 == 0


def some_sharp(item: Any) -> None:
    for edge in item.data.edges:
        edge.use_edge_sharp = edge.index % 3 == 0


def all_sharp(item: Any) -> None:
    for edge in item.data.edges:
        edge.use_edge_sharp = True


def flat_and_sharp(item: Any) -> None:
    some_flat(item)
    some_sharp(item)


def custom(item: Any) -> None:
    rng = np.random.default_rng(3)
    normals = rng.normal((0, 0, 1.5), 0.3, (len(item.data.loops), 3))
    item.data.normals_split_custom_set((normals / np.linalg.norm(normals, axis=1, keepdims=True)).tolist())


def custom_and_flat(item: Any) -> None:
    some_flat(item)
    custom(item)


def stretched(item: Any) -> None:
    item.scale, item.rotation_euler, item.location = (0.5, 1, 2), (0.3, 0.2, 0.9), (3, 1, 2)


def mirrored(item: Any) -> None:
    stretched(item)
    item.scale.x = -0.5


def sheared(item: Any) -> None:
    mirrored(item)
    bpy.ops.object.empty_add(rotation=(0.4, 0.5, 0.6))
    context.object.scale = (2, 1, 0.7)
    item.parent = context.object


def many_sided(item: Any) -> None:
    item.modifiers.new("holes", "DECIMATE").decimate_type = "DISSOLVE"
    item.modifiers["holes"].angle_limit = 0.35


SHAPES = [
    flat, smooth, some_flat, some_sharp, all_sharp, flat_and_sharp, custom, custom_and_flat,
    stretched, mirrored, sheared, many_sided,
]  # fmt: skip


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: shape.__name__)
def test_the_copy_is_the_surface_that_cycles_renders(shape: Callable[[Any], None], tmp_path: Path) -> None:
    """Where Cycles's rays hit, the copy lies, with Cycles's normal."""
    item = hilly()
    shape(item)
    context.view_layer.update()
    points, normals = rendered_surface(tmp_path, item.matrix_world.translation, 1.5)
    assert len(points) > 300
    gap, ours = distance_and_normal(surface_of(item), points)
    assert gap.max() < 1e-5
    angle = np.degrees(np.arccos(np.clip(np.abs(np.sum(ours * normals, axis=1)), 0, 1)))
    assert np.mean(angle < 0.1) > 0.995  # but where a ray hits an edge, and either triangle's normal is right


def test_modifiers_count_as_renders_show_them() -> None:
    bpy.ops.mesh.primitive_cube_add()
    item = context.object
    subdivision = item.modifiers.new("subdivision", "SUBSURF")
    subdivision.levels, subdivision.render_levels = 0, 2
    item.modifiers.new("seen in the viewport only", "WIREFRAME").show_render = False
    copies = item.modifiers.new("seen in renders only", "ARRAY")
    copies.count, copies.show_viewport = 3, False
    evaluated = read(item)
    assert len(evaluated.triangles) == 6 * 4**2 * 2 * 3
    assert not evaluated.uv_layers or evaluated.uv(evaluated.uv_layers[0]).shape == (576, 3, 2)


def test_simplify_of_the_scene_counts_too() -> None:
    bpy.ops.mesh.primitive_cube_add()
    context.object.modifiers.new("subdivision", "SUBSURF").render_levels = 3
    context.scene.render.use_simplify = True
    context.scene.render.simplify_subdivision_render = 1
    assert len(read(context.object).triangles) == 6 * 4 * 2


def test_the_matrix_is_the_one_that_constraints_parents_and_animation_make() -> None:
    bpy.ops.object.empty_add(location=(1, 2, 3), rotation=(0.1, 0.2, 0.3))
    parent = context.object
    parent.scale = (1, 2, -3)
    bpy.ops.mesh.primitive_cube_add()
    item = context.object
    item.parent = parent
    item.constraints.new("COPY_LOCATION").target = parent
    item.rotation_euler.x = 0
    item.keyframe_insert("rotation_euler", frame=1)
    item.rotation_euler.x = 1
    item.keyframe_insert("rotation_euler", frame=11)
    context.scene.frame_set(6)
    expected = np.array(item.evaluated_get(context.evaluated_depsgraph_get()).matrix_world)
    evaluated = read(item)
    assert np.allclose(evaluated.matrix_world, expected, atol=1e-6)
    assert evaluated.mirrored
    homogeneous = np.c_[evaluated.position, np.ones(len(evaluated.position))]
    assert np.allclose(evaluated.world_position, (homogeneous @ expected.T)[:, :3], atol=1e-6)


def test_attributes_materials_and_loose_parts_come_along() -> None:
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=2, y_subdivisions=2)
    item = context.object
    mesh = item.data
    mesh.vertices.add(1)  # loose: no triangle needs it
    red, blue = stage.material("red", "ShaderNodeEmission"), stage.material("blue", "ShaderNodeEmission")
    mesh.materials.append(red)
    mesh.materials.append(None)
    mesh.materials.append(blue)
    mesh.polygons[3].material_index = 2
    mesh.polygons[2].material_index = 9  # Cycles takes the last slot for it
    mesh.attributes.new("heat", "FLOAT", "POINT").data.foreach_set("value", np.arange(10, dtype=np.float32))
    mesh.attributes.new("part", "INT", "FACE").data.foreach_set("value", np.arange(4, dtype=np.int32))
    mesh.color_attributes.new("tint", "BYTE_COLOR", "CORNER")
    evaluated = read(item)
    assert evaluated.position.shape == (9, 3)
    assert evaluated.materials == (red, None, blue)
    assert evaluated.material_index.tolist() == [0, 0, 0, 0, 2, 2, 2, 2]
    by_name = {attribute.name: attribute for attribute in evaluated.attributes}
    assert by_name["heat"].values[:, 0].tolist() == list(range(9))
    assert by_name["part"].values[:, 0].tolist() == [0, 0, 1, 1, 2, 2, 3, 3]
    assert by_name["tint"].values.shape == (8, 3, 4)
    assert evaluated.active_color == "tint"
    assert evaluated.uv_layers == ("UVMap",)
    on_vertices = (evaluated.position[evaluated.triangles][..., :2] + 1) / 2
    assert np.allclose(evaluated.uv("UVMap"), on_vertices, atol=1e-6)
    with pytest.raises(KeyError):
        evaluated.uv("heat")


def test_slots_of_the_object_win_over_those_of_the_mesh() -> None:
    bpy.ops.mesh.primitive_cube_add()
    item = context.object
    item.data.materials.append(stage.material("mesh", "ShaderNodeEmission"))
    item.material_slots[0].link = "OBJECT"
    item.material_slots[0].material = stage.material("object", "ShaderNodeEmission")
    assert read(item).materials[0].name == "object"


def test_objects_of_a_library_can_be_read(tmp_path: Path) -> None:
    bpy.ops.mesh.primitive_cube_add()
    context.object.name = "far"
    bpy.data.libraries.write(str(tmp_path / "lib.blend"), {context.object})
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    libraries: Any = bpy.data.libraries
    with libraries.load(str(tmp_path / "lib.blend"), link=True) as (_, there):
        there.objects = ["far"]
    far = bpy.data.objects["far"]
    context.scene.collection.objects.link(far)
    assert len(read(far).triangles) == 12
    assert far.library is not None


# What cannot be baked


def refused(item: Any, message: str, view_layer: str | None = None) -> None:
    before = len(bpy.data.scenes), len(bpy.data.objects)
    with pytest.raises(InputError, match=message) as caught:
        read(item, view_layer)
    assert "\n" not in str(caught.value)
    assert caught.value.exit_code == 2
    assert (len(bpy.data.scenes), len(bpy.data.objects)) == before


@pytest.fixture
def cube() -> Any:
    bpy.ops.mesh.primitive_cube_add()
    return context.object


def test_an_unknown_name_is_answered_with_close_ones(cube: Any) -> None:
    cube.name = "Teapot"
    scene = context.scene
    with pytest.raises(InputError, match=r"no object 'teapot' in scene 'Scene': did you mean 'Teapot'\?"):
        find_object(scene, "teapot")
    with pytest.raises(InputError, match=r"no object 'Zzz' in scene 'Scene': its meshes are 'Teapot'"):
        find_object(scene, "Zzz")
    more = [bpy.data.objects.new(f"Vase {number}", cube.data) for number in range(9)]
    for item in more:
        scene.collection.objects.link(item)
    with pytest.raises(InputError, match=r"its meshes are 'Teapot', .*, 'Vase 6' and 2 more$"):
        find_object(scene, "Zzz")
    bpy.data.batch_remove(more)
    bpy.data.objects.remove(cube)
    with pytest.raises(InputError, match=r"it has no mesh at all"):
        find_object(scene, "Teapot")


def test_an_object_of_another_scene_is_refused(cube: Any) -> None:
    context.scene.collection.objects.unlink(cube)
    cube.use_fake_user = True
    refused(cube, r"object 'Cube' is not in scene 'Scene': link it")


def test_an_instanced_collection_is_to_be_made_real(cube: Any) -> None:
    group = bpy.data.collections.new("group")
    group.objects.link(cube)
    context.scene.collection.objects.unlink(cube)
    bpy.ops.object.collection_instance_add(collection="group")
    refused(context.object, r"object 'group' instances a collection: join its instances")
    refused(cube, r"object 'Cube' is in scene 'Scene' only as an instance of 'group': join its instances")


@pytest.mark.parametrize(
    ("add", "message"),
    [
        (bpy.ops.object.pointcloud_random_add, r"is a point cloud, not a mesh: convert it"),
        (lambda: bpy.ops.object.light_add(type="POINT"), r"is a light, not a mesh: name a mesh object"),
        (bpy.ops.object.empty_add, r"is an? empty, not a mesh: name a mesh object"),
    ],
)
def test_other_types_are_refused(add: Callable[[], object], message: str) -> None:
    add()
    refused(context.object, message)


def test_no_faces_after_modifiers(cube: Any) -> None:
    cube.modifiers.new("none", "MASK").mode = "ARMATURE"
    assert len(cube.data.polygons) == 6
    refused(cube, r"object 'Cube' has no faces in renders")


def test_instances_of_geometry_nodes_are_to_be_realized(cube: Any) -> None:
    group: Any = bpy.data.node_groups.new("instance", "GeometryNodeTree")
    group.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    shape = group.nodes.new("GeometryNodeMeshCube")
    instances = group.nodes.new("GeometryNodeGeometryToInstance")
    group.links.new(shape.outputs[0], instances.inputs[0])
    group.links.new(instances.outputs[0], group.nodes.new("NodeGroupOutput").inputs[0])
    cube.modifiers.new("nodes", "NODES").node_group = group
    refused(
        cube,
        r"object 'Cube' has no faces in renders: join its instances, or add Realize Instances",
    )


def test_hidden_objects(cube: Any) -> None:
    cube.hide_set(True)
    cube.hide_viewport = True
    assert len(read(cube).triangles) == 12, "hidden in the viewport alone"
    cube.hide_render = True
    refused(cube, r"object 'Cube' is hidden from render: enable it in renders")
    cube.hide_render = False
    cube.instance_type, cube.show_instancer_for_render = "VERTS", False
    refused(cube, r"hidden from render: it is an instancer; enable Show Instancer")


def test_hidden_collections(cube: Any) -> None:
    outer, inner = bpy.data.collections.new("outer"), bpy.data.collections.new("inner")
    context.scene.collection.children.link(outer)
    outer.children.link(inner)
    context.scene.collection.objects.unlink(cube)
    inner.objects.link(cube)
    assert len(read(cube).triangles) == 12
    outer.hide_render = True
    refused(cube, r"object 'Cube' is hidden from render: enable its collection 'outer' in renders")
    outer.hide_render = False
    layers = context.view_layer.layer_collection.children["outer"]
    layers.children["inner"].exclude = True
    refused(cube, r"hidden from render: include its collection 'inner' in view layer 'ViewLayer'")
    context.scene.view_layers.new("all of it")
    assert len(read(cube, "all of it").triangles) == 12


def displacing(method: str) -> Any:
    made: Any = stage.material("waves", "ShaderNodeBsdfDiffuse")
    made.displacement_method = method
    node = made.node_tree.nodes.new("ShaderNodeDisplacement")
    output = made.node_tree.get_output_node("CYCLES")
    made.node_tree.links.new(node.outputs[0], output.inputs["Displacement"])
    return made


@pytest.mark.parametrize("method", ["DISPLACEMENT", "BOTH"])
def test_displacement_is_refused_by_name(cube: Any, method: str) -> None:
    cube.data.materials.append(displacing(method))
    refused(cube, r"object 'Cube': material 'waves' displaces the surface: set its Displacement to Bump Only")
    cube.data.materials[0] = displacing("BUMP")
    cube.data.materials.append(displacing(method))  # which no face shows
    assert len(read(cube).triangles) == 12


def test_adaptive_subdivision_is_refused_by_name(cube: Any) -> None:
    modifier = cube.modifiers.new("dice", "SUBSURF")
    if hasattr(modifier, "use_adaptive_subdivision"):
        modifier.use_adaptive_subdivision = True
    else:
        context.scene.cycles.feature_set = "EXPERIMENTAL"
        cube.cycles.use_adaptive_subdivision = True
    refused(cube, r"object 'Cube': its modifier 'dice' subdivides adaptively, by the camera: turn")


def test_rigid_bodies_must_be_baked(cube: Any) -> None:
    """Their cache does not come along into a copy of the scene, unless it is baked."""
    bpy.ops.rigidbody.object_add(type="ACTIVE")
    scene = context.scene
    assert len(read(cube).triangles) == 12
    for frame in range(1, 11):
        scene.frame_set(frame)
    fallen = cube.evaluated_get(context.evaluated_depsgraph_get()).matrix_world.translation.z
    assert fallen < -0.5
    refused(
        cube,
        r"scene 'Scene': rigid bodies such as 'Cube' have moved, and their simulation is not baked: bake",
    )
    bpy.ops.ptcache.bake_all(bake=True)
    assert read(cube).matrix_world[2, 3] == pytest.approx(fallen, abs=1e-5)
