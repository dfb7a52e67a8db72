# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The baked copy carries what the evaluated mesh has, and the frame of the baked UV layer."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.core.errors import ShapeError
from radtex_addon.core.frame import orthonormal_frame
from radtex_addon.core.surface import SurfaceMesh
from radtex_addon.scene.mesh.copy import (
    NORMAL,
    SIGN,
    TANGENT,
    UV_LAYER,
    baked_mesh,
    copy_object,
    surface_mesh,
)
from radtex_addon.scene.mesh.evaluated import EvaluatedMesh
from tests.blender import stage
from tests.blender.fingerprint import differences, fingerprint
from tests.blender.stage import read

context: Any = bpy.context  # to the stubs, every pointer may be None


def planar(evaluated: EvaluatedMesh) -> Floats:
    """The object's x and y as uv, in 0..1."""
    flat = evaluated.position[evaluated.triangles][..., :2]
    return (flat - flat.min()) / (flat.max() - flat.min())


def bake(item: Any) -> tuple[EvaluatedMesh, Any, SurfaceMesh]:
    evaluated = read(item)
    mesh = baked_mesh(evaluated, planar(evaluated))
    return evaluated, mesh, surface_mesh(evaluated, mesh)


def values(mesh: Any, name: str, width: int) -> Floats:
    layer = mesh.attributes[name]
    flat = np.empty(len(layer.data) * width, dtype=np.float32)
    layer.data.foreach_get("vector" if width > 1 else "value", flat)
    return flat.reshape(-1, width)


def hill(height: float = 0.3) -> Any:
    """A smooth hill over a grid, without overhang."""
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=6, y_subdivisions=6, size=2)
    item = context.object
    for vertex in item.data.vertices:
        vertex.co.z = height * np.cos(2 * vertex.co.x) * np.cos(vertex.co.y + 0.4)
    item.data.shade_smooth()
    return item


def plain(item: Any) -> None:
    pass


def stretched(item: Any) -> None:
    item.scale, item.rotation_euler, item.location = (0.3, 1, 2.5), (0.3, 0.2, 0.9), (3, 1, 2)


def mirrored(item: Any) -> None:
    stretched(item)
    item.scale.y = -1


def mirrored_thrice(item: Any) -> None:
    item.scale = (-1, -1, -1)


def sheared(item: Any) -> None:
    stretched(item)
    bpy.ops.object.empty_add(rotation=(0.4, 0.5, 0.6))
    context.object.scale = (2, -1, 0.7)
    item.parent = context.object


@pytest.mark.parametrize(
    "shape", [plain, stretched, mirrored, mirrored_thrice, sheared], ids=lambda f: f.__name__
)
def test_the_frame_points_where_u_and_v_grow(shape: Callable[[Any], None]) -> None:
    """In world space, under every transform: T along u, Bt along v, N outwards."""
    item = hill(height=0.08)
    shape(item)
    _, _, surface = bake(item)
    tangent, bitangent, normal = orthonormal_frame(surface.normal, surface.tangent, surface.sign)
    corners = surface.corner_position
    edges = np.stack([corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]], axis=1)
    in_uv = np.stack([surface.uv[:, 1] - surface.uv[:, 0], surface.uv[:, 2] - surface.uv[:, 0]], axis=1)
    along_u, along_v = np.moveaxis(np.linalg.inv(in_uv.astype(np.float64)) @ edges, 1, 0)
    along_u /= np.linalg.norm(along_u, axis=1, keepdims=True)
    # A sheared v is not orthogonal to u.
    along_v -= np.sum(along_v * along_u, axis=1, keepdims=True) * along_u
    along_v /= np.linalg.norm(along_v, axis=1, keepdims=True)
    assert np.min(np.sum(tangent * along_u[:, None], axis=-1)) > 0.9
    assert np.min(np.sum(bitangent * along_v[:, None], axis=-1)) > 0.9
    facet = np.cross(edges[:, 0], edges[:, 1]) * np.sign(np.linalg.det(np.array(item.matrix_world)[:3, :3]))
    assert np.min(np.sum(normal * facet[:, None], axis=-1)) > 0
    for first, second in ((tangent, bitangent), (bitangent, normal), (normal, tangent)):
        assert np.abs(np.sum(first * second, axis=-1)).max() < 1e-6


def test_vectors_are_unit_and_the_sign_is_one() -> None:
    item = hill()
    sheared(item)
    _, mesh, surface = bake(item)
    for name in (NORMAL, TANGENT):
        assert np.linalg.norm(values(mesh, name, 3), axis=1) == pytest.approx(1, abs=1e-6)
    matrix = np.array(item.matrix_world)[:3, :3]
    stretched = values(mesh, TANGENT, 3) @ matrix.T
    assert surface.tangent.reshape(-1, 3) == pytest.approx(stretched, abs=1e-6)  # as shaders interpolate it
    assert set(np.unique(values(mesh, SIGN, 1))) == {1}
    assert set(np.unique(surface.sign)) == {-1}


def test_a_mirrored_island_has_the_other_sign() -> None:
    evaluated = read(hill())
    uv = planar(evaluated)
    uv[:10, :, 0] = 1 - uv[:10, :, 0]
    sign = surface_mesh(evaluated, baked_mesh(evaluated, uv)).sign
    assert (sign[:10] == -1).all()
    assert (sign[10:] == 1).all()


def test_the_attributes_are_exactly_what_the_bake_reads() -> None:
    """Preview and bake start from the same bits."""
    evaluated, mesh, surface = bake(hill())
    assert np.array_equal(values(mesh, NORMAL, 3).reshape(-1, 3, 3), evaluated.normal)
    assert np.array_equal(values(mesh, UV_LAYER, 2).reshape(-1, 3, 2), surface.uv)
    assert np.allclose(values(mesh, TANGENT, 3).reshape(-1, 3, 3), surface.tangent, atol=1e-7)
    assert {mesh.attributes[name].domain for name in (NORMAL, TANGENT, SIGN)} == {"CORNER"}
    assert mesh.uv_layers.active.name == UV_LAYER
    assert mesh.uv_layers[UV_LAYER].active_render


def test_a_layer_without_direction_still_has_a_frame() -> None:
    """Some tangent that every reader sees: MikkTSpace's default, or the fallback where that is the normal."""
    bpy.ops.mesh.primitive_cube_add()
    evaluated = read(context.object)
    mesh = baked_mesh(evaluated, np.zeros((12, 3, 2)))
    tangent, normal = values(mesh, TANGENT, 3), values(mesh, NORMAL, 3)
    assert np.linalg.norm(tangent, axis=1) == pytest.approx(1, abs=1e-6)
    assert np.abs(np.sum(tangent * normal, axis=1)).max() < 1e-6
    surface = surface_mesh(evaluated, mesh)
    assert all(np.isfinite(part).all() for part in (surface.tangent, surface.normal, surface.sign))


@pytest.mark.parametrize("custom", [False, True])
def test_the_copy_looks_like_the_original(custom: bool) -> None:
    """Blender's own normals of the copy are those that Cycles has of the original."""
    item = hill()
    if custom:
        normals = np.random.default_rng(3).normal((0, 0, 1.5), 0.3, (len(item.data.loops), 3))
        item.data.normals_split_custom_set(
            (normals / np.linalg.norm(normals, axis=1, keepdims=True)).tolist()
        )
    evaluated, mesh, _ = bake(item)
    flat = np.empty(len(mesh.loops) * 3, dtype=np.float32)
    mesh.corner_normals.foreach_get("vector", flat)
    exact = bpy.app.version >= (5, 0, 0)
    assert np.abs(flat.reshape(-1, 3, 3) - evaluated.normal).max() < (1e-6 if exact else 0.02)
    assert np.array_equal(read_positions(mesh), evaluated.position)


def read_positions(mesh: Any) -> Floats:
    flat = np.empty(len(mesh.vertices) * 3, dtype=np.float32)
    mesh.vertices.foreach_get("co", flat)
    return flat.reshape(-1, 3)


def test_flat_meshes_stay_flat() -> None:
    bpy.ops.mesh.primitive_cube_add()
    evaluated, mesh, _ = bake(context.object)
    assert evaluated.flat
    assert mesh.normals_domain == "FACE"
    assert not mesh.has_custom_normals


def test_n_gons_become_the_triangles_that_cycles_makes() -> None:
    bpy.ops.mesh.primitive_circle_add(vertices=17, fill_type="NGON")
    item = context.object
    evaluated, mesh, surface = bake(item)
    assert len(mesh.polygons) == 15
    assert {len(face.vertices) for face in mesh.polygons} == {3}
    cross = np.cross(
        surface.corner_position[:, 1] - surface.corner_position[:, 0],
        surface.corner_position[:, 2] - surface.corner_position[:, 0],
    )
    assert np.linalg.norm(cross, axis=1).sum() / 2 == pytest.approx(8.5 * np.sin(2 * np.pi / 17), rel=1e-5)
    assert len(evaluated.position) == 17


def test_layers_colours_materials_and_attributes_are_carried() -> None:
    item = hill()
    source = item.data
    red, blue = stage.material("red", "ShaderNodeEmission"), stage.material("blue", "ShaderNodeEmission")
    for material in (red, None, blue):
        source.materials.append(material)
    source.polygons[5].material_index = 2
    for index in range(7):
        source.uv_layers.new(name=f"uv {index}")
    source.uv_layers["uv 3"].uv[0].vector = (0.25, 0.75)
    source.attributes.new("ninth", "FLOAT2", "CORNER")
    tint = source.color_attributes.new("tint", "BYTE_COLOR", "CORNER")
    tint.data[0].color_srgb = (1, 0.5, 0.2, 1)
    source.color_attributes.new("light", "FLOAT_COLOR", "POINT").data[3].color = (7, 5, 3, 1)
    source.attributes.new("part", "INT8", "FACE").data[4].value = 3
    source.attributes.new("on", "BOOLEAN", "POINT").data[2].value = True
    source.attributes.new("turn", "QUATERNION", "POINT").data[2].value = (0.5, 0.5, 0.5, 0.5)
    source.attributes.new(NORMAL, "FLOAT", "POINT")  # of some earlier bake
    evaluated, mesh, _ = bake(item)
    names = {layer.name for layer in mesh.uv_layers}
    assert {"UVMap", "ninth", UV_LAYER} | {f"uv {index}" for index in range(7)} == names
    assert tuple(mesh.materials) == (red, None, blue)
    assert [face.material_index for face in mesh.polygons].count(2) == 2
    corner = next(
        k for k, loop in enumerate(mesh.loops) if tuple(mesh.uv_layers["uv 3"].uv[k].vector) != (0, 0)
    )
    assert tuple(mesh.uv_layers["uv 3"].uv[corner].vector) == (0.25, 0.75)
    assert tuple(mesh.attributes["tint"].data[corner].color_srgb) == pytest.approx(
        (1, 0.5, 0.2, 1), abs=0.003
    )
    assert tuple(mesh.attributes["light"].data[3].color) == (7, 5, 3, 1)
    assert mesh.attributes["part"].data[8].value == mesh.attributes["part"].data[9].value == 3
    assert mesh.attributes["on"].data[2].value
    assert tuple(mesh.attributes["turn"].data[2].value) == (0.5, 0.5, 0.5, 0.5)
    assert mesh.color_attributes.active_color_name == source.color_attributes.active_color_name
    assert mesh.attributes[NORMAL].data_type == "FLOAT_VECTOR"
    assert evaluated.material_index.tolist() == [face.material_index for face in mesh.polygons]
    assert tuple(mesh.texspace_size) == pytest.approx(tuple(source.texspace_size))


def test_baking_on_a_layer_of_the_user_keeps_the_others() -> None:
    item = hill()
    item.data.uv_layers.new(name="lightmap")
    evaluated = read(item)
    mesh = baked_mesh(evaluated, planar(evaluated), "lightmap")
    assert [layer.name for layer in mesh.uv_layers] == ["UVMap", "lightmap"]
    assert mesh.uv_layers.active.name == "lightmap"
    assert UV_LAYER not in mesh.attributes


def test_the_original_is_not_written() -> None:
    item = hill()
    item.modifiers.new("mirror", "MIRROR")
    item.modifiers.new("bevel", "BEVEL")
    before = fingerprint()
    evaluated = read(item)
    mesh = baked_mesh(evaluated, stage.unwrapped(evaluated, 64).uv)
    copy = copy_object(item, mesh)
    bpy.data.objects.remove(copy)
    bpy.data.meshes.remove(mesh)
    assert differences(before, fingerprint()) == {}


def test_the_copy_stands_where_the_original_does() -> None:
    item = hill()
    sheared(item)
    item.modifiers.new("subdivision", "SUBSURF")
    item.constraints.new("COPY_ROTATION").target = item.parent
    item.data.materials.append(stage.material("mesh", "ShaderNodeEmission"))
    item.material_slots[0].link = "OBJECT"
    item.material_slots[0].material = shown = stage.material("object", "ShaderNodeEmission")
    item.shape_key_add(name="Basis")
    context.view_layer.update()
    evaluated, mesh, surface = bake(item)
    copy: Any = copy_object(item, mesh)
    assert copy.users_collection == ()
    context.scene.collection.objects.link(copy)
    context.view_layer.update()
    assert np.allclose(np.array(copy.matrix_world), evaluated.matrix_world, atol=1e-6)
    assert len(copy.modifiers) == 0
    assert len(copy.constraints) == 1
    assert copy.material_slots[0].material == shown
    assert len(item.modifiers) == 1
    again = read(copy)
    assert np.allclose(again.world_position, surface.position, atol=1e-6)
    assert np.array_equal(again.triangles, evaluated.triangles)


def test_coordinates_that_do_not_fit_are_refused() -> None:
    evaluated = read(hill())
    with pytest.raises(ShapeError, match=r"uv: expected shape \(72, 3, 2\), got \(3, 3, 2\)"):
        baked_mesh(evaluated, np.zeros((3, 3, 2)))
    assert len(bpy.data.meshes) == 1
