# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Small random scenes: a body to bake, "Body", among floor, blocks and lamps, under a colour or an HDRI.

All shapes have a UV layer "UVMap" on which no two faces overlap, and no clamp cuts light away.
"""

from __future__ import annotations

from typing import Any, cast

import bmesh
import bpy
import numpy as np
from mathutils import Matrix, Vector

from tests.blender import stage

BODY = "Body"
context: Any = bpy.context  # to the stubs, every pointer may be None


def build(rng: np.random.Generator) -> Any:
    """Build a random scene into an empty file; returns the body."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = context.scene
    scene.render.engine = "CYCLES"
    stage.clamps_off()
    _world(rng)
    floor = add_mesh("Floor", grid(1, 0.0, rng))
    floor.scale, floor.location = (4, 4, 1), (0, 0, -1.2)
    floor.data.materials.append(random_material("floor", rng, plain=True))
    for number in range(int(rng.integers(1, 4))):
        block = add_mesh(f"Block {number}", box(1, 0.0, rng))
        angle = number * 2.1 + rng.uniform(0, 1)
        block.location = (2.2 * np.cos(angle), 2.2 * np.sin(angle), rng.uniform(-0.8, 0.6))
        block.rotation_euler = rng.uniform(-1, 1, 3).tolist()
        block.scale = rng.uniform(0.3, 0.8, 3).tolist()
        block.data.materials.append(random_material(f"block {number}", rng, plain=True))
    for number in range(int(rng.integers(1, 4))):
        _lamp(number, rng)
    body = add_mesh(BODY, (grid, box, ball)[int(rng.integers(3))](int(rng.integers(1, 4)), 0.1, rng))
    body.data.materials.append(random_material("body", rng))
    body.rotation_euler = rng.uniform(-1, 1, 3).tolist()
    body.data.polygons.foreach_set("use_smooth", [bool(rng.integers(2))] * len(body.data.polygons))
    context.view_layer.update()
    return body


def add_mesh(name: str, made: bmesh.types.BMesh) -> Any:
    """An object of a bmesh, in the scene."""
    mesh = bpy.data.meshes.new(name)
    made.to_mesh(mesh)
    made.free()
    item = bpy.data.objects.new(name, mesh)
    context.scene.collection.objects.link(item)
    return item


def grid(cuts: int, bumpy: float, rng: np.random.Generator) -> bmesh.types.BMesh:
    """A square of side 2 of (cuts + 1)² faces."""
    made = bmesh.new()
    made.loops.layers.uv.new("UVMap")
    bmesh.ops.create_grid(made, x_segments=cuts + 1, y_segments=cuts + 1, size=1, calc_uvs=True)
    return _bumped(made, bumpy, rng)


def box(cuts: int, bumpy: float, rng: np.random.Generator) -> bmesh.types.BMesh:
    """A cube of side 1.4 of 6 (cuts + 1)² faces."""
    made = bmesh.new()
    made.loops.layers.uv.new("UVMap")
    bmesh.ops.create_cube(made, size=1.4, calc_uvs=True)
    bmesh.ops.subdivide_edges(made, edges=made.edges[:], cuts=cuts, use_grid_fill=True)
    return _bumped(made, bumpy, rng)


def ball(cuts: int, bumpy: float, rng: np.random.Generator) -> bmesh.types.BMesh:
    """The same, blown up to a ball of radius 1."""
    made = box(cuts + 1, 0.0, rng)
    for vertex in made.verts:
        vertex.co = vertex.co.normalized()
    return _bumped(made, bumpy / 2, rng)


def random_material(name: str, rng: np.random.Generator, plain: bool = False) -> bpy.types.Material:
    """A material without textures: diffuse or glowing where it is to be `plain`, else perhaps shiny."""
    tint = (*rng.uniform(0.1, 0.9, 3).tolist(), 1.0)
    chosen = int(rng.integers(2 if plain else 4))
    if chosen == 0 or (plain and rng.uniform() < 0.7):
        return stage.material(name, "ShaderNodeBsdfDiffuse", Color=tint)
    if chosen == 1:
        glow = stage.material(name, "ShaderNodeEmission", Color=tint, Strength=float(rng.uniform(0.5, 3)))
        sampling: Any = (
            glow.cycles
        )  # left to itself it depends on the strength, and at smooth edges is lighter
        sampling.emission_sampling = "FRONT_BACK"
        return glow
    rough = float(rng.uniform(0.2, 0.6))
    if chosen == 2:
        return stage.material(name, "ShaderNodeBsdfAnisotropic", Color=tint, Roughness=rough)
    return stage.material(name, "ShaderNodeBsdfPrincipled", Base_Color=tint, Roughness=rough)


def transform_scene(matrix: Matrix) -> None:
    """Move everything by a matrix: objects, lamps with their sizes and powers, and the world's directions."""
    size = abs(matrix.to_3x3().determinant()) ** (1 / 3)
    for item in list(context.scene.objects):
        if item.parent is None:
            item.matrix_world = matrix @ item.matrix_world
        if item.type == "LIGHT":
            _resize(item, size)
    _turn_world(matrix)
    context.view_layer.update()


def _resize(item: Any, size: float) -> None:
    """Let a lamp light a scene that is `size` times as large alike; its object keeps its scale."""
    lamp, matrix = item.data, item.matrix_world
    item.matrix_world = Matrix.Translation(matrix.translation) @ _direction(matrix).to_matrix().to_4x4()
    if lamp.type != "SUN":
        lamp.energy *= size * size
    if lamp.type in {"POINT", "SPOT"}:
        lamp.shadow_soft_size *= size
    elif lamp.type == "AREA":
        lamp.size *= size


def _direction(matrix: Matrix) -> Any:
    """A turn that looks where the lamp's matrix does: lamps are round, so that a mirror image is a turn."""
    return (matrix.to_3x3() @ Vector((0, 0, 1))).to_track_quat("Z", "Y")


def _turn_world(matrix: Matrix) -> None:
    tree = context.scene.world.node_tree
    for node in [node for node in tree.nodes if node.type == "MAPPING"]:
        size = matrix.to_3x3().determinant()
        back = (matrix.to_3x3() * (1 / abs(size) ** (1 / 3))).transposed()
        if size < 0:  # of mirrors the one along x alone is known
            node.inputs["Scale"].default_value = (-1, 1, 1)
            back = Matrix.Scale(-1, 3, (1, 0, 0)) @ back
        node.inputs["Rotation"].default_value = back.to_euler()


def _world(rng: np.random.Generator) -> None:
    made = stage.world(tuple(rng.uniform(0.1, 0.6, 3).tolist()))
    if rng.uniform() < 0.5:
        return
    stage.hdri(made)
    tree = made.node_tree
    picture = next(node for node in tree.nodes if node.type == "TEX_ENVIRONMENT")
    mapping, directions = tree.nodes.new("ShaderNodeMapping"), tree.nodes.new("ShaderNodeTexCoord")
    mapping.vector_type = "VECTOR"
    tree.links.new(directions.outputs["Generated"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs["Vector"], picture.inputs["Vector"])


def _lamp(number: int, rng: np.random.Generator) -> None:
    kind = ("POINT", "AREA", "SUN", "SPOT")[int(rng.integers(4))]
    new_lamp: Any = bpy.data.lights.new  # to the stubs its type is a literal
    lamp = new_lamp(f"Lamp {number}", kind)
    item = bpy.data.objects.new(f"Lamp {number}", lamp)
    context.scene.collection.objects.link(item)
    place = Vector((*rng.uniform(-2, 2, 2).tolist(), float(rng.uniform(1.8, 3))))
    item.location = place
    item.rotation_euler = place.to_track_quat("Z", "Y").to_euler()
    lamp.color = rng.uniform(0.4, 1, 3).tolist()
    lamp.energy = float(rng.uniform(0.5, 2)) if kind == "SUN" else float(rng.uniform(50, 200))
    if kind == "SUN":
        lamp.angle = float(rng.uniform(0.01, 0.3))
    elif kind == "AREA":
        lamp.shape, lamp.size = "DISK", float(rng.uniform(0.3, 1))
    else:
        lamp.shadow_soft_size = float(rng.uniform(0.05, 0.4))


def _bumped(made: bmesh.types.BMesh, bumpy: float, rng: np.random.Generator) -> bmesh.types.BMesh:
    """Move vertices a little, and UVs off the middles of texels: there either of two triangles is right."""
    for vertex in made.verts:
        vertex.co += Vector(rng.uniform(-bumpy, bumpy, 3).tolist())
    layer = cast(Any, made.loops.layers.uv)["UVMap"]
    for face in made.faces:
        for corner in face.loops:
            corner[layer].uv = 0.95 * corner[layer].uv + Vector((0.021, 0.013))
    return made
