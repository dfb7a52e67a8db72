# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The baked copy: the evaluated mesh triangulated, with the baked UV layer and its frame as attributes.

The bake, the preview and exports all read this one mesh, so that they agree to the last bit.

Its tangents are MikkTSpace's, bit-identical each time. For more than 10,000 faces Blender uses several
threads, and sums tangents at a vertex in the order in which the threads arrive. So large meshes are cut into
patches that are small enough for one thread.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import Any, cast

import bpy
import numpy as np

from ...bake.progress import Progress, Stage, Steps, finished
from ...core.arrays import Floats, Ints, blocks
from ...core.errors import ShapeError
from ...core.frame import DEGENERATE, fallback_tangent, normalised
from ...core.islands import weld
from ...core.surface import SurfaceMesh, patches
from ..geometry_digests import DRIFTS, MADE_OF
from .attribute_arrays import ATTRIBUTE_LAYOUT
from .evaluated import EvaluatedMesh, MeshAttribute
from .painted_weights import WEIGHT

_ALONE = 10_000  # faces for which Blender uses one thread only
_LAYER, _NORMAL = "RadTex patch", "custom_normal"
UV_LAYER = "RadTex"
NORMAL, TANGENT, SIGN = "radtex_normal", "radtex_tangent", "radtex_sign"  # on corners, in object space
OBJECT = "radtex_object"  # on faces of a joined copy: the number of the copy that they are of
MATERIAL = "radtex_material"  # on faces: the material's number, where there are several
SHOWN = "radtex_copy"  # of an object that a preview replaces: the preview, and how the object was hidden
_COPIED = (  # fields of an object, its parent before what depends on that
    *("rotation_mode", "location", "rotation_euler", "rotation_quaternion", "rotation_axis_angle", "scale"),
    *("delta_location", "delta_rotation_euler", "delta_rotation_quaternion", "delta_scale"),
    *("parent", "parent_type", "parent_bone", "parent_vertices", "matrix_parent_inverse"),
    *("hide_render", "hide_viewport", "hide_select", "pass_index", "color", "display_type"),
    *("visible_camera", "visible_diffuse", "visible_glossy", "visible_transmission"),
    *("visible_volume_scatter", "visible_shadow", "is_shadow_catcher", "is_holdout"),
)
_LINKED = ("receiver_collection", "blocker_collection")  # collections of light linking
MATRIX = "radtex_matrix_world"  # of the mesh: the object's matrix at the bake, row by row


def calc_tangents(position: Floats, triangles: Ints, normal: Floats, uv: Floats) -> tuple[Floats, Floats]:
    """`calc_tangents_steps`, without progress."""
    return finished(calc_tangents_steps(position, triangles, normal, uv))


def calc_tangents_steps(
    position: Floats, triangles: Ints, normal: Floats, uv: Floats
) -> Steps[tuple[Floats, Floats]]:
    """Tangents (F, 3, 3) float32 on corners, and the bitangents' signs (F, 3).

    `position` (V, 3), `triangles` (F, 3), `normal` (F, 3, 3) of unit length, `uv` (F, 3, 2). Yields progress
    in triangles.
    """
    tangent = np.empty((len(triangles), 3, 3), dtype=np.float32)
    sign = np.empty((len(triangles), 3), dtype=np.float32)
    # MikkTSpace, too, treats vertices at the same position as one.
    vertex = weld(position).astype(np.int32)[triangles]
    done = 0
    for own, whole in patches(vertex, position[triangles].mean(axis=1), _ALONE):
        found = _calc(position[triangles[whole]], normal[whole], uv[whole])
        here = np.searchsorted(whole, own)
        tangent[own], sign[own] = found[0][here], found[1][here]
        done += len(own)
        yield Progress(Stage.RASTER, done, len(triangles))
    return tangent, sign


def _calc(corners: Floats, normal: Floats, uv: Floats) -> tuple[Floats, Floats]:
    """`calc_tangents` for triangles with these `corners` (F, 3, 3), by one call of Blender."""
    count = len(corners)
    mesh: Any = bpy.data.meshes.new("RadTex patch")
    try:
        mesh.vertices.add(3 * count)
        mesh.loops.add(3 * count)
        mesh.polygons.add(count)
        mesh.vertices.foreach_set("co", np.ascontiguousarray(corners, dtype=np.float32).ravel())
        mesh.loops.foreach_set("vertex_index", np.arange(3 * count, dtype=np.int32))
        mesh.polygons.foreach_set("loop_start", np.arange(0, 3 * count, 3, dtype=np.int32))
        for name, kind, field, values in (
            (_LAYER, "FLOAT2", "vector", uv),
            (_NORMAL, "FLOAT_VECTOR", "vector", normal),
        ):
            layer = mesh.attributes.new(name, kind, "CORNER")
            layer.data.foreach_set(field, np.ascontiguousarray(values, dtype=np.float32).ravel())
        mesh.update(calc_edges=True)
        mesh.calc_tangents(uvmap=_LAYER)
        tangent = np.empty((count, 3, 3), dtype=np.float32)
        sign = np.empty((count, 3), dtype=np.float32)
        mesh.loops.foreach_get("tangent", tangent.ravel())
        mesh.loops.foreach_get("bitangent_sign", sign.ravel())
    finally:
        bpy.data.meshes.remove(mesh)
    return tangent, sign


def baked_mesh(evaluated: EvaluatedMesh, uv: Floats, layer: str = UV_LAYER) -> bpy.types.Mesh:
    """`baked_mesh_steps`, without progress."""
    return finished(baked_mesh_steps(evaluated, uv, layer))


def baked_mesh_steps(evaluated: EvaluatedMesh, uv: Floats, layer: str = UV_LAYER) -> Steps[bpy.types.Mesh]:
    """Make the baked copy's mesh, with `uv` (F, 3, 2) as its active UV layer called `layer`.

    It carries the UV layers, colours and other attributes of the evaluated mesh, its materials and its
    normals, and for shaders, on corners in object space: `radtex_normal` (exactly Cycles's shading
    normal), `radtex_tangent` (MikkTSpace's of that layer, unit; `fallback_tangent` where the layer has
    no direction) and `radtex_sign` of the bitangent; on faces, where there are several materials,
    `radtex_material`. Its custom property MATRIX is the object's matrix. Yields progress. Raises ShapeError
    where uv does not fit the triangles.
    """
    count = len(evaluated.triangles)
    if uv.shape != (count, 3, 2):
        raise ShapeError(f"uv: expected shape {(count, 3, 2)}, got {uv.shape}")
    mesh = _built(evaluated, {layer, NORMAL, TANGENT, SIGN, MATERIAL, WEIGHT})
    if len(evaluated.materials) > 1:
        write_face_numbers(mesh, MATERIAL, evaluated.material_index)
    _write(mesh, MeshAttribute(layer, "CORNER", "FLOAT2", uv))
    _choose_active(mesh, evaluated, layer)
    yield from _write_frame(mesh, evaluated, uv)
    cast(Any, mesh)[MATRIX] = evaluated.matrix_world.ravel().tolist()
    return mesh


def plain_mesh(evaluated: EvaluatedMesh) -> bpy.types.Mesh:
    """A mesh that renders as the evaluated one does, with its UV layers, attributes, materials and normals.

    What it is made of goes with it, so that it is told apart as the evaluated mesh would be.
    """
    mesh = _built(evaluated, set())
    _choose_active(mesh, evaluated, evaluated.active_uv)
    _write_normals(mesh, evaluated)
    _settle_normals(mesh, evaluated)
    if evaluated.made_of:
        kept = cast(Any, mesh)
        kept[MADE_OF], kept[DRIFTS] = evaluated.made_of, evaluated.drifts
    return mesh


def _built(evaluated: EvaluatedMesh, without: Collection[str]) -> bpy.types.Mesh:
    """A mesh with the vertices, triangles, materials and attributes of an evaluated one, `without` some."""
    mesh = bpy.data.meshes.new(evaluated.name)
    _build(mesh, evaluated)
    for attribute in evaluated.attributes:
        if attribute.name not in without:
            _write(mesh, attribute)
    for material in evaluated.materials:
        mesh.materials.append(material)
    return mesh


def write_face_numbers(mesh: bpy.types.Mesh, name: str, numbers: Ints) -> None:
    """Write whole numbers (F,) as an attribute of faces, which is made if it is not there."""
    _write(mesh, MeshAttribute(name, "FACE", "INT", numbers[:, None]))


def material_numbers(mesh: bpy.types.Mesh) -> Ints:
    """The number of each triangle's material at the bake, (F,) int32, of a mesh of `baked_mesh`."""
    return face_numbers(mesh, MATERIAL)


def face_numbers(mesh: bpy.types.Mesh, name: str) -> Ints:
    """The whole numbers (F,) int32 of an attribute of faces; 0 where it is not there."""
    numbers = np.zeros(len(mesh.polygons), dtype=np.int32)
    attribute = cast(Any, mesh).attributes.get(name)
    if attribute is not None:
        attribute.data.foreach_get("value", numbers)
    return numbers


def copy_object(original: bpy.types.Object, mesh: bpy.types.Mesh) -> bpy.types.Object:
    """A copy of the object that shows `mesh` as it is, linked to no collection yet.

    Transform, parent, constraints and animation stay, of a curve, text or metaball without NLA tracks;
    modifiers are removed, since `mesh` includes their effect.
    """
    if original.type != "MESH":
        return _copy_as_mesh(original, mesh)
    copy = cast("bpy.types.Object", original.copy())
    copy.data = mesh
    copy.modifiers.clear()
    for slot in copy.material_slots:
        slot.link = "DATA"
    return copy


def _copy_as_mesh(original: Any, mesh: bpy.types.Mesh) -> bpy.types.Object:
    """A new mesh object in the place of one that Blender cannot give a mesh."""
    copy: Any = bpy.data.objects.new(original.name, mesh)
    for name in _COPIED:
        setattr(copy, name, getattr(original, name))
    for name in _LINKED:
        setattr(copy.light_linking, name, getattr(original.light_linking, name))
    for constraint in original.constraints:
        copy.constraints.copy(constraint)
    moved = original.animation_data
    if moved is not None:
        own = copy.animation_data_create()
        own.action = moved.action
        if moved.action is not None:
            own.action_slot = moved.action_slot
        for driver in moved.drivers:
            own.drivers.from_existing(src_driver=driver)
    for key in original.keys():  # noqa: SIM118 (of custom properties)
        copy[key] = original[key]
    return cast("bpy.types.Object", copy)


def surface_mesh(evaluated: EvaluatedMesh, mesh: bpy.types.Mesh, layer: str = UV_LAYER) -> SurfaceMesh:
    """The baked copy's `mesh` as arrays in world space; positions float64, directions float32.

    Normals are transformed by the inverse transpose of the object's matrix, tangents by the matrix; a
    negative determinant negates the sign, so that sign * cross(N, T) points towards larger v. A mirroring
    matrix also reverses the triangles' winding.
    """
    matrix = evaluated.matrix_world[:3, :3]
    return SurfaceMesh(
        position=evaluated.world_position,
        triangles=evaluated.triangles,
        normal=_turned(_corners(mesh, NORMAL), np.linalg.inv(matrix)),
        tangent=_turned(_corners(mesh, TANGENT), matrix.T),
        sign=_corners(mesh, SIGN)[..., 0] * (-1.0 if evaluated.mirrored else 1.0),
        uv=_corners(mesh, layer),
        material=evaluated.material_index.astype(np.int32),
    )


def _turned(vectors: Floats, matrix: Floats) -> Floats:
    """Vectors (F, 3, 3) times a matrix (3, 3), rounded to float32, as they are most of a large surface."""
    found = np.empty(vectors.shape, dtype=np.float32)
    for some in blocks(len(vectors)):
        found[some] = vectors[some].astype(np.float64) @ matrix
    return found


def _build(mesh: bpy.types.Mesh, evaluated: EvaluatedMesh) -> None:
    count = len(evaluated.triangles)
    mesh.vertices.add(len(evaluated.position))
    mesh.loops.add(3 * count)
    mesh.polygons.add(count)
    mesh.vertices.foreach_set("co", evaluated.position.ravel())
    mesh.loops.foreach_set("vertex_index", evaluated.triangles.ravel())
    mesh.polygons.foreach_set("loop_start", np.arange(0, 3 * count, 3, dtype=np.int32))
    mesh.update(calc_edges=True)
    mesh.use_auto_texspace = False
    location, size = evaluated.texture_space
    mesh.texspace_location, mesh.texspace_size = location.tolist(), size.tolist()


def _write(mesh: Any, attribute: MeshAttribute) -> None:
    """Write an attribute; for UV layers `attributes.new` has no limit of eight, as `uv_layers.new` has."""
    name, _, dtype = ATTRIBUTE_LAYOUT[attribute.data_type]
    layer = mesh.attributes.get(attribute.name)
    if layer is None:
        layer = mesh.attributes.new(attribute.name, attribute.data_type, attribute.domain)
    layer.data.foreach_set(name, np.ascontiguousarray(attribute.values, dtype=dtype).ravel())


def _choose_active(mesh: bpy.types.Mesh, evaluated: EvaluatedMesh, layer: str | None) -> None:
    if layer is not None:
        mesh.uv_layers.active = mesh.uv_layers[layer]
        mesh.uv_layers[layer].active_render = True
    colours = mesh.color_attributes
    if evaluated.active_color and evaluated.active_color in colours:
        colours.active_color_name = evaluated.active_color
    if evaluated.render_color and evaluated.render_color in colours:
        colours.default_color_name = evaluated.render_color


def _write_frame(mesh: bpy.types.Mesh, evaluated: EvaluatedMesh, uv: Floats) -> Steps[None]:
    """Give the mesh its normals, and the frame of `uv` (F, 3, 2) as attributes. Yields progress."""
    normal = _write_normals(mesh, evaluated)
    corners = evaluated.normal.reshape(-1, 3, 3)
    found = yield from calc_tangents_steps(evaluated.position, evaluated.triangles, corners, uv)
    tangent, sign = found[0].reshape(-1, 3), found[1].ravel()
    for some in blocks(len(tangent)):
        flat = tangent[some] - normal[some] * np.sum(normal[some] * tangent[some], axis=-1, keepdims=True)
        degenerate = np.flatnonzero(np.sum(flat * flat, axis=-1) < DEGENERATE) + some.start
        tangent[degenerate] = fallback_tangent(normal[degenerate])
        tangent[some] = normalised(tangent[some])
    _write(mesh, MeshAttribute(NORMAL, "CORNER", "FLOAT_VECTOR", normal))
    _write(mesh, MeshAttribute(TANGENT, "CORNER", "FLOAT_VECTOR", tangent))
    _write(mesh, MeshAttribute(SIGN, "CORNER", "FLOAT", np.where(sign < 0, np.float32(-1), np.float32(1))))
    _settle_normals(mesh, evaluated)


def _write_normals(mesh: bpy.types.Mesh, evaluated: EvaluatedMesh) -> Floats:
    """Give the mesh its normals as exact vectors, and return them, (3F, 3)."""
    normal: Floats = evaluated.normal.reshape(-1, 3)
    _write(mesh, MeshAttribute("custom_normal", "CORNER", "FLOAT_VECTOR", normal))
    mesh.update()
    return normal


def _settle_normals(mesh: bpy.types.Mesh, evaluated: EvaluatedMesh) -> None:
    """Store normals in a form that Cycles reads: exact vectors if it can, else Blender's packed normals."""
    if bpy.app.version >= (5, 0, 0) and not evaluated.flat:
        return
    mesh.attributes.remove(mesh.attributes["custom_normal"])
    if evaluated.flat:
        mesh.shade_flat()
    else:  # Cycles 4.5 misreads normals stored as plain vectors
        cast(Any, mesh).normals_split_custom_set(evaluated.normal.reshape(-1, 3))


def _corners(mesh: Any, name: str) -> Floats:
    attribute = mesh.attributes[name]
    field, width, dtype = ATTRIBUTE_LAYOUT[attribute.data_type]
    values = np.empty(len(mesh.loops) * width, dtype=dtype)
    attribute.data.foreach_get(field, values)
    return cast("Floats", values.reshape(-1, 3, width))
