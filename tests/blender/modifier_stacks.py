# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects whose meshes Blender makes: by every modifier of meshes, geometry nodes, shape keys, an armature.

`add_stack` adds one to the scene, with what its modifiers take beside it, hidden from renders.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import bpy

context: Any = bpy.context  # to the stubs, every pointer may be None


def add_stack(name: str, location: tuple[float, float, float] = (0, 0, 0), size: float = 1.0) -> Any:
    """Add the object of the stack `name`, called so too, at a place."""
    make = STACKS[name]
    if make in _ON_CUBES:
        bpy.ops.mesh.primitive_cube_add(size=1.5 * size, location=location)
    else:
        bpy.ops.mesh.primitive_monkey_add(size=size, location=location)
    item = context.object
    item.name = name
    make(item)
    return item


def _beside(item: Any, kind: str, **options: Any) -> Any:
    """An object at the same place that renders do not show; the scene's active object stays."""
    getattr(bpy.ops.mesh, f"primitive_{kind}_add")(location=item.location, **options)
    return _hidden(context.object, item)


def _hidden(added: Any, item: Any) -> Any:
    added.hide_render = True
    context.view_layer.objects.active = item
    return added


def _simple(kind: str, **settings: Any) -> Callable[[Any], None]:
    """A stack of one modifier."""

    def make(item: Any) -> None:
        modifier = item.modifiers.new(kind.title(), kind)
        for setting, value in settings.items():
            setattr(modifier, setting, value)

    return make


def _chain(*parts: Callable[[Any], None]) -> Callable[[Any], None]:
    """A stack of several."""

    def make(item: Any) -> None:
        for part in parts:
            part(item)

    return make


def _group(item: Any) -> None:
    """A vertex group of weights from 0 to 1."""
    group = item.vertex_groups.new(name="Group")
    for vertex in item.data.vertices:
        group.add([vertex.index], vertex.index / len(item.data.vertices), "REPLACE")


def _boolean(solver: str) -> Callable[[Any], None]:
    def make(item: Any) -> None:
        cutter = _beside(item, "ico_sphere", subdivisions=4, radius=0.75 * item.dimensions.x / 2)
        cutter.location.x += 0.3 * item.dimensions.x
        modifier = item.modifiers.new("Boolean", "BOOLEAN")
        modifier.operation, modifier.object = "DIFFERENCE", cutter
        modifier.solver = solver if bpy.app.version >= (5, 0, 0) or solver != "FLOAT" else "FAST"

    return make


def _armature(item: Any) -> None:
    bpy.ops.object.armature_add(location=item.location)
    rig = _hidden(context.object, item)
    rig.pose.bones[0].rotation_mode = "XYZ"
    rig.pose.bones[0].rotation_euler = (0.3, 0.2, 0.1)
    group = item.vertex_groups.new(name=rig.pose.bones[0].name)
    for vertex in item.data.vertices:
        group.add([vertex.index], 0.5 + 0.5 * vertex.co.z, "REPLACE")
    item.modifiers.new("Armature", "ARMATURE").object = rig


def _shape_keys(item: Any) -> None:
    item.shape_key_add(name="Basis")
    key = item.shape_key_add(name="Wide")
    for point in key.data:
        point.co.x *= 1.7
    key.value = 0.37


def _lattice(item: Any) -> None:
    bpy.ops.object.add(type="LATTICE", location=item.location)
    lattice = _hidden(context.object, item)
    lattice.scale = item.dimensions
    lattice.data.points[0].co_deform.x -= 0.4
    item.modifiers.new("Lattice", "LATTICE").object = lattice


def _curve(item: Any) -> None:
    bpy.ops.curve.primitive_bezier_curve_add(location=item.location)
    item.modifiers.new("Curve", "CURVE").object = _hidden(context.object, item)


def _hook(item: Any) -> None:
    bpy.ops.object.empty_add(location=item.location)
    empty = _hidden(context.object, item)
    modifier = item.modifiers.new("Hook", "HOOK")
    modifier.object, modifier.falloff_type = empty, "NONE"
    modifier.vertex_indices_set(list(range(8)))
    empty.location.z += 0.3


def _shrinkwrap(item: Any) -> None:
    modifier = item.modifiers.new("Shrinkwrap", "SHRINKWRAP")
    modifier.target = _beside(item, "ico_sphere", subdivisions=4, radius=0.8)


def _data_transfer(item: Any) -> None:
    modifier = item.modifiers.new("Transfer", "DATA_TRANSFER")
    modifier.object = _beside(item, "uv_sphere", radius=0.8)
    modifier.use_loop_data = True
    modifier.data_types_loops = {"CUSTOM_NORMAL", "UV"}
    modifier.loop_mapping = "POLYINTERP_NEAREST"


def _surface_deform(item: Any) -> None:
    target = _beside(item, "ico_sphere", subdivisions=3, radius=1.2)
    modifier = item.modifiers.new("Surface Deform", "SURFACE_DEFORM")
    modifier.target = target
    bpy.ops.object.surfacedeform_bind(modifier=modifier.name)
    target.data.vertices[0].co *= 1.3
    for vertex in target.data.vertices:
        vertex.co.z *= 1.2


def _mesh_deform(item: Any) -> None:
    cage = _beside(item, "cube", size=3.5)
    modifier = item.modifiers.new("Mesh Deform", "MESH_DEFORM")
    modifier.object, modifier.precision = cage, 3
    bpy.ops.object.meshdeform_bind(modifier=modifier.name)
    cage.data.vertices[0].co *= 1.3


def _laplacian_deform(item: Any) -> None:
    group = item.vertex_groups.new(name="Anchors")
    group.add(list(range(0, len(item.data.vertices), 25)), 1.0, "REPLACE")
    modifier = item.modifiers.new("Laplacian", "LAPLACIANDEFORM")
    modifier.vertex_group = "Anchors"
    bpy.ops.object.laplaciandeform_bind(modifier=modifier.name)
    for index in range(0, len(item.data.vertices), 25):
        item.data.vertices[index].co *= 1.1


def _multires(item: Any) -> None:
    modifier = item.modifiers.new("Multires", "MULTIRES")
    bpy.ops.object.multires_subdivide(modifier=modifier.name, mode="CATMULL_CLARK")
    modifier.render_levels = 1


def _skin(item: Any) -> None:
    item.modifiers.new("Skin", "SKIN")
    for point in item.data.skin_vertices[0].data:
        point.radius = (0.05, 0.05)


def _uv_project(item: Any) -> None:
    bpy.ops.object.empty_add(location=item.location, rotation=(0.4, 0.2, 0.1))
    modifier = item.modifiers.new("Project", "UV_PROJECT")
    modifier.uv_layer = item.data.uv_layers[0].name
    modifier.projectors[0].object = _hidden(context.object, item)


def _warp(item: Any) -> None:
    bpy.ops.object.empty_add(location=item.location)
    start = _hidden(context.object, item)
    bpy.ops.object.empty_add(location=item.location)
    end = _hidden(context.object, item)
    end.location.x += 0.4
    modifier = item.modifiers.new("Warp", "WARP")
    modifier.object_from, modifier.object_to, modifier.strength = start, end, 0.8


def _displace(item: Any) -> None:
    texture = bpy.data.textures.new("Clouds", "CLOUDS")
    modifier = item.modifiers.new("Displace", "DISPLACE")
    modifier.texture, modifier.strength = texture, 0.2


def _volume_to_mesh(item: Any) -> None:
    volume = bpy.data.objects.new("Volume", bpy.data.volumes.new("Volume"))
    context.scene.collection.objects.link(volume)
    volume.location, volume.hide_render = item.location, True
    source = _beside(item, "ico_sphere", subdivisions=3, radius=0.7)
    filled: Any = volume.modifiers.new("Fill", "MESH_TO_VOLUME")
    filled.object, filled.voxel_amount = source, 24
    modifier = item.modifiers.new("Mesh", "VOLUME_TO_MESH")
    modifier.object = volume


def _particles(item: Any) -> None:
    system = item.modifiers.new("Particles", "PARTICLE_SYSTEM").particle_system.settings
    system.count, system.frame_start, system.frame_end = 40, 1, 1
    system.physics_type = "NO"


def _explode(item: Any) -> None:
    _particles(item)
    item.modifiers.new("Explode", "EXPLODE")


def _particle_instance(item: Any) -> None:
    maker = _beside(item, "grid", x_subdivisions=4, y_subdivisions=4)
    _particles(maker)
    modifier = item.modifiers.new("Instances", "PARTICLE_INSTANCE")
    modifier.object = maker


def _dynamic_paint(item: Any) -> None:
    modifier = item.modifiers.new("Paint", "DYNAMIC_PAINT")
    bpy.ops.dpaint.type_toggle(type="CANVAS")
    assert modifier.canvas_settings is not None


def _nodes(build: Callable[[Any, Any, Any], None]) -> Callable[[Any], None]:
    """A stack of geometry nodes, which `build` adds between a group's input and output."""

    def make(item: Any) -> None:
        tree: Any = bpy.data.node_groups.new("Nodes", "GeometryNodeTree")
        tree.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
        tree.interface.new_socket("Amount", in_out="INPUT", socket_type="NodeSocketFloat")
        tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
        begin, end = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
        build(tree, begin, end)
        modifier = item.modifiers.new("Nodes", "NODES")
        modifier.node_group = tree

    return make


def _through(*kinds: str) -> Callable[[Any, Any, Any], None]:
    """Nodes one after another, of their first inputs and outputs."""

    def build(tree: Any, begin: Any, end: Any) -> None:
        last = begin.outputs[0]
        for kind in kinds:
            node = tree.nodes.new(kind)
            tree.links.new(last, next(each for each in node.inputs if each.type == "GEOMETRY"))
            last = node.outputs[0]
        tree.links.new(last, end.inputs[0])

    return build


def _noise(tree: Any, begin: Any, end: Any) -> None:
    """Positions moved by a noise, and a named attribute of it."""
    place = tree.nodes.new("GeometryNodeSetPosition")
    noise = tree.nodes.new("ShaderNodeTexNoise")
    stored = tree.nodes.new("GeometryNodeStoreNamedAttribute")
    stored.inputs["Name"].default_value = "noise"
    tree.links.new(begin.outputs[0], place.inputs[0])
    tree.links.new(noise.outputs["Color"], place.inputs["Offset"])
    tree.links.new(place.outputs[0], stored.inputs[0])
    value = next(each for each in stored.inputs if each.name == "Value" and each.enabled)
    tree.links.new(noise.outputs[0], value)
    tree.links.new(stored.outputs[0], end.inputs[0])


def _scatter(realized: bool) -> Callable[[Any, Any, Any], None]:
    """Cubes on points that lie on the mesh."""

    def build(tree: Any, begin: Any, end: Any) -> None:
        points = tree.nodes.new("GeometryNodeDistributePointsOnFaces")
        cubes, put = tree.nodes.new("GeometryNodeMeshCube"), tree.nodes.new("GeometryNodeInstanceOnPoints")
        join = tree.nodes.new("GeometryNodeJoinGeometry")
        cubes.inputs[0].default_value = (0.05, 0.05, 0.05)
        tree.links.new(begin.outputs[0], points.inputs[0])
        tree.links.new(points.outputs["Points"], put.inputs["Points"])
        tree.links.new(points.outputs["Rotation"], put.inputs["Rotation"])
        tree.links.new(cubes.outputs[0], put.inputs["Instance"])
        last = put.outputs[0]
        if realized:
            real = tree.nodes.new("GeometryNodeRealizeInstances")
            tree.links.new(last, real.inputs[0])
            last = real.outputs[0]
        tree.links.new(begin.outputs[0], join.inputs[0])
        tree.links.new(last, join.inputs[0])
        tree.links.new(join.outputs[0], end.inputs[0])

    return build


_BEVEL = _simple("BEVEL", width=0.1, segments=3)
_BEVELLED_CUBE = _simple("BEVEL", width=0.2, segments=3, limit_method="ANGLE")
_FLOAT, _EXACT, _MANIFOLD = _boolean("FLOAT"), _boolean("EXACT"), _boolean("MANIFOLD")
_HARD = _simple("BEVEL", width=0.1, segments=2, harden_normals=True)
_MULTIRES, _SKIN = _multires, _skin
_FLOAT_BEVEL = _chain(_FLOAT, _simple("BEVEL", width=0.02, segments=2))

STACKS: dict[str, Callable[[Any], None]] = {
    "none": _chain(),
    "bevel": _BEVEL,
    "bevelled cube": _BEVELLED_CUBE,
    "hard bevel": _HARD,
    "bevel and subdivision": _chain(_BEVEL, _simple("SUBSURF", render_levels=2)),
    "bevel and solidify": _chain(_BEVEL, _simple("SOLIDIFY", thickness=0.05)),
    "bevel and array": _chain(_BEVELLED_CUBE, _simple("ARRAY", count=3)),
    "mirror and bevel": _chain(_simple("MIRROR", use_axis=(False, True, False)), _BEVEL),
    "bevel and weighted normals": _chain(_BEVELLED_CUBE, _simple("WEIGHTED_NORMAL")),
    "bevel and triangulate": _chain(_BEVEL, _simple("TRIANGULATE")),
    "bevel and decimate": _chain(_BEVEL, _simple("DECIMATE", ratio=0.5)),
    "bevel and scattered": _chain(_BEVEL, _nodes(_scatter(False))),
    "bevel and realized": _chain(_BEVEL, _nodes(_scatter(True))),
    "float boolean": _FLOAT,
    "exact boolean": _EXACT,
    "float boolean and bevel": _FLOAT_BEVEL,
    "data transfer": _data_transfer,
    "normal edit": _simple("NORMAL_EDIT"),
    "weighted normal": _simple("WEIGHTED_NORMAL"),
    "uv project": _uv_project,
    "uv warp": _simple("UV_WARP", rotation=0.3),
    "weight edit": _chain(_group, _simple("VERTEX_WEIGHT_EDIT", vertex_group="Group")),
    "array": _simple("ARRAY", count=3),
    "build": _simple("BUILD", frame_start=1, frame_duration=1),
    "decimate": _simple("DECIMATE", ratio=0.4),
    "planar decimate": _simple("DECIMATE", decimate_type="DISSOLVE", angle_limit=0.3),
    "edge split": _simple("EDGE_SPLIT"),
    "mask": _chain(_group, _simple("MASK", vertex_group="Group", threshold=0.3)),
    "mirror": _simple("MIRROR"),
    "multires": _MULTIRES,
    "voxel remesh": _simple("REMESH", mode="VOXEL", voxel_size=0.06),
    "sharp remesh": _simple("REMESH", mode="SHARP", octree_depth=5),
    "screw": _simple("SCREW", steps=5, angle=0.6),
    "skin": _SKIN,
    "solidify": _simple("SOLIDIFY", thickness=0.1),
    "complex solidify": _simple("SOLIDIFY", thickness=0.1, solidify_mode="NON_MANIFOLD"),
    "subdivision": _simple("SUBSURF", render_levels=3),
    "triangulate": _simple("TRIANGULATE"),
    "volume to mesh": _volume_to_mesh,
    "weld": _simple("WELD", merge_threshold=0.05),
    "wireframe": _simple("WIREFRAME", thickness=0.03),
    "armature": _armature,
    "cast": _simple("CAST", factor=0.6),
    "curve": _curve,
    "displace": _displace,
    "hook": _hook,
    "laplacian deform": _laplacian_deform,
    "lattice": _lattice,
    "mesh deform": _mesh_deform,
    "shrinkwrap": _shrinkwrap,
    "simple deform": _simple("SIMPLE_DEFORM", deform_method="TWIST", angle=0.5),
    "smooth": _simple("SMOOTH", iterations=10),
    "corrective smooth": _simple("CORRECTIVE_SMOOTH", iterations=10),
    "laplacian smooth": _simple("LAPLACIANSMOOTH", iterations=5),
    "surface deform": _surface_deform,
    "warp": _warp,
    "wave": _simple("WAVE", height=0.2),
    "cloth": _simple("CLOTH"),
    "collision": _simple("COLLISION"),
    "dynamic paint": _dynamic_paint,
    "explode": _explode,
    "ocean": _simple("OCEAN", geometry_mode="DISPLACE", resolution=4),
    "particle instance": _particle_instance,
    "particles": _particles,
    "soft body": _simple("SOFT_BODY"),
    "shape keys": _shape_keys,
    "nodes: noise": _nodes(_noise),
    "nodes: subdivision": _nodes(_through("GeometryNodeSubdivisionSurface", "GeometryNodeExtrudeMesh")),
    "nodes: hull": _nodes(_through("GeometryNodeConvexHull")),
    "nodes: dual": _nodes(_through("GeometryNodeTriangulate", "GeometryNodeDualMesh")),
    "nodes: volume": _nodes(_through("GeometryNodeMeshToVolume", "GeometryNodeVolumeToMesh")),
    "nodes: merged": _nodes(_through("GeometryNodeMergeByDistance", "GeometryNodeScaleElements")),
    "nodes: scattered": _nodes(_scatter(False)),
    "nodes: realized": _nodes(_scatter(True)),
}
if bpy.app.version >= (5, 0, 0):
    STACKS["manifold boolean"] = _MANIFOLD
_ON_CUBES = {_BEVELLED_CUBE, _HARD, _FLOAT, _EXACT, _MANIFOLD, _SKIN, _FLOAT_BEVEL} | {
    STACKS[name] for name in ("bevel and array", "bevel and weighted normals")
}
