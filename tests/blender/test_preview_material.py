# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The preview material on real geometry, turned, stretched, mirrored and instanced, against numpy."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import bmesh
import bpy
import numpy as np
import pytest
from mathutils import Matrix, Vector
from mathutils.bvhtree import BVHTree

from radtex_addon.core.arrays import Floats, Ints
from radtex_addon.core.frame import normalised, orthonormal_frame, to_frame
from radtex_addon.core.sampler import Filter, sample
from radtex_addon.core.surface import SurfaceMesh
from radtex_addon.preview.material import preview_material
from tests.blender.lookup_stage import ENGINES, add_camera_above, render_exr, set_up_render, write_exr
from tests.lookups import LAYOUT, relative_error

UV_LAYER = "RadTex"
RESOLUTION = (180, 120)


def monkey() -> bpy.types.Mesh:
    """A triangulated, smooth head with a second UV layer, which is not the one that renders."""
    mesh = bpy.data.meshes.new("head")
    bm = bmesh.new()
    bmesh.ops.create_monkey(bm)
    bmesh.ops.triangulate(bm, faces=list(bm.faces))
    bm.to_mesh(mesh)
    bm.free()
    mesh.shade_smooth()
    mesh.uv_layers.new(name="other")
    layer = mesh.uv_layers.new(name=UV_LAYER)
    position = corner_values(mesh, "vertices", "co")[corner_vertices(mesh)]
    around = np.arctan2(position[:, 0], -position[:, 1]) / (2 * np.pi) + 0.5
    layer.uv.foreach_set(
        "vector", np.stack([around, position[:, 2] / 2.2 + 0.5], axis=1).astype(np.float32).ravel()
    )
    return mesh


def surface_of(mesh: bpy.types.Mesh, matrix: Matrix) -> SurfaceMesh:
    """The surface as the bake knows it: world space, unit normals and tangents at every corner."""
    mesh.calc_tangents(uvmap=UV_LAYER)
    linear = np.array(matrix.to_3x3())
    corners = {name: corner_values(mesh, "loops", name).reshape(-1, 3, 3) for name in ("normal", "tangent")}
    sign = np.empty(len(mesh.loops), np.float32)
    mesh.loops.foreach_get("bitangent_sign", sign)
    uv = np.empty(len(mesh.loops) * 2, np.float32)
    mesh.uv_layers[UV_LAYER].uv.foreach_get("vector", uv)
    position = corner_values(mesh, "vertices", "co") @ linear.T + np.array(matrix.translation)
    return SurfaceMesh(
        position=position,
        triangles=corner_vertices(mesh).reshape(-1, 3),
        normal=normalised(corners["normal"] @ np.linalg.inv(linear)),
        tangent=normalised(corners["tangent"] @ linear.T),
        sign=sign.reshape(-1, 3) * np.sign(np.linalg.det(linear)),
        uv=uv.reshape(-1, 3, 2),
    )


def store_frame(mesh: bpy.types.Mesh, surface: SurfaceMesh, matrix: Matrix) -> None:
    """Write the attributes so that the object's matrix makes the surface's vectors of them, unit and all."""
    linear = np.array(matrix.to_3x3())
    values = {
        "radtex_normal": surface.normal @ linear,
        "radtex_tangent": surface.tangent @ np.linalg.inv(linear).T,
    }
    for name, vectors in values.items():
        attribute = cast(Any, mesh.attributes.new(name, "FLOAT_VECTOR", "CORNER"))
        attribute.data.foreach_set("vector", vectors.astype(np.float32).ravel())
    attribute = cast(Any, mesh.attributes.new("radtex_sign", "FLOAT", "CORNER"))
    sign = surface.sign * np.sign(np.linalg.det(linear))
    attribute.data.foreach_set("value", sign.astype(np.float32).ravel())


def corner_values(mesh: bpy.types.Mesh, elements: str, name: str) -> Floats:
    """A vector property of all vertices or loops: (K, 3)."""
    collection = getattr(mesh, elements)
    values = np.empty(len(collection) * 3, np.float32)
    collection.foreach_get(name, values)
    return values.reshape(-1, 3).astype(float)


def corner_vertices(mesh: bpy.types.Mesh) -> Ints:
    indices = np.empty(len(mesh.loops), np.int32)
    mesh.loops.foreach_get("vertex_index", indices)
    return indices


@dataclass(frozen=True)
class Hits:
    """What the camera sees: pixel (K, 2) as x, y; surface and triangle (K,); weights, viewer (K, 3)."""

    pixel: Ints
    surface: Ints
    triangle: Ints
    weights: Floats
    viewer: Floats


def cast_rays(camera: bpy.types.Object, scene: bpy.types.Scene, surfaces: list[SurfaceMesh]) -> Hits:
    """The first hit through each pixel's centre."""
    trees: list[Any] = [
        BVHTree.FromPolygons(s.position.tolist(), s.triangles.tolist(), epsilon=0.0) for s in surfaces
    ]
    top_right, _, bottom_left, top_left = (Vector(v) for v in cast(Any, camera.data).view_frame(scene=scene))
    origin, rotation = camera.matrix_world.translation, camera.matrix_world.to_3x3()
    rows = []
    for y in range(RESOLUTION[1]):
        for x in range(RESOLUTION[0]):
            across = (top_right - top_left) * ((x + 0.5) / RESOLUTION[0])
            up = (top_left - bottom_left) * ((y + 0.5) / RESOLUTION[1])
            direction = (rotation @ (bottom_left + across + up)).normalized()
            hits: list[Any] = [(*tree.ray_cast(origin, direction), index) for index, tree in enumerate(trees)]
            hits = sorted((hit for hit in hits if hit[0]), key=lambda hit: hit[3])
            for place, _, triangle, _, index in hits[:1]:
                rows.append(
                    [x, y, index, triangle, *place, *(-component for component in cast(Any, direction))]
                )
    table = np.array(rows)
    surface, triangle = table[:, 2].astype(int), table[:, 3].astype(int)
    corners = np.array([surfaces[s].corner_position[t] for s, t in zip(surface, triangle, strict=True)])
    return Hits(
        table[:, :2].astype(int), surface, triangle, barycentric(table[:, 4:7], corners), table[:, 7:]
    )


def barycentric(point: Floats, corners: Floats) -> Floats:
    edges = np.stack([corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]], axis=-1)
    vw = np.einsum("kij,kj->ki", np.linalg.pinv(edges), point - corners[:, 0])
    return np.concatenate([1 - vw.sum(axis=1, keepdims=True), vw], axis=1)


def at_hits(hits: Hits, surfaces: list[SurfaceMesh], name: str) -> Floats:
    """What the surfaces' corners know, between them: (K, ...)."""
    pairs = zip(hits.surface, hits.triangle, strict=True)
    values = np.array([getattr(surfaces[s], name)[t] for s, t in pairs])
    weights = hits.weights.reshape(hits.weights.shape + (1,) * (values.ndim - 2))
    return cast(Floats, np.sum(weights * values, axis=1))


def expected(hits: Hits, surfaces: list[SurfaceMesh], atlas: Floats, kind: Filter) -> Floats:
    """The reference's answers at the hits, (K, 4)."""
    normal, tangent, sign, uv = (
        at_hits(hits, surfaces, name) for name in ("normal", "tangent", "sign", "uv")
    )
    frame = orthonormal_frame(normal, tangent, sign)
    return sample(atlas.astype(float), LAYOUT, uv, to_frame(hits.viewer, *frame), kind)


PLACES = {  # location, angle and axis, scale
    "turned": ((-2.4, 0, 0), (0.9, (1, 2, 0.5)), (1, 1, 1)),
    "stretched and mirrored": ((0, 0.3, 0), (-0.5, (0.2, 0.3, 1)), (-0.6, 1.2, 1)),
}


def build_scene(material: bpy.types.Material) -> tuple[bpy.types.Object, list[SurfaceMesh]]:
    """Two objects, and a mirrored collection instance of the second; the camera and the three as surfaces."""
    scene = cast(Any, bpy.context.scene)
    heads = [add_head(scene, name, material) for name in PLACES]
    surfaces = [surface_of(cast(bpy.types.Mesh, head.data), head.matrix_world) for head in heads]
    instance = bpy.data.objects.new("mirror", None)
    instance.instance_type, instance.instance_collection = "COLLECTION", heads[1].users_collection[0]
    turn, mirror = Matrix.Rotation(0.4, 4, "Z"), Matrix.Scale(-1, 4, (1, 0, 0))
    instance.matrix_world = Matrix.Translation((2.4, 0, 0)) @ turn @ mirror
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.matrix_world = Matrix.Translation((0.3, -9, 0.8)) @ Matrix.Rotation(1.5, 4, "X")
    for extra in (instance, camera):
        scene.collection.objects.link(extra)
    scene.camera = camera
    scene.render.resolution_x, scene.render.resolution_y = RESOLUTION
    cast(Any, bpy.context.view_layer).update()
    matrix = instance.matrix_world @ heads[1].matrix_world
    return camera, [*surfaces, surface_of(cast(bpy.types.Mesh, heads[1].data), matrix)]


def add_head(scene: Any, name: str, material: bpy.types.Material) -> bpy.types.Object:
    """A head in its place, with its frame as attributes, in a collection of its own."""
    location, (angle, axis), scale = PLACES[name]
    mesh = monkey()
    mesh.materials.append(material)
    head = bpy.data.objects.new(name, mesh)
    head.matrix_world = Matrix.LocRotScale(location, Matrix.Rotation(angle, 3, axis), scale)
    store_frame(mesh, surface_of(mesh, head.matrix_world), head.matrix_world)
    collection = bpy.data.collections.new(name)
    collection.objects.link(head)
    scene.collection.children.link(collection)
    return head


@pytest.mark.parametrize("engine", ENGINES.values(), ids=ENGINES)
def test_turned_stretched_mirrored_and_instanced_objects_show_their_atlas(
    engine: str, tmp_path: Path
) -> None:
    atlas = (
        np.random.default_rng(5)
        .uniform(1, 2, (LAYOUT.pixel_height, LAYOUT.pixel_width, 4))
        .astype(np.float16)
    )
    atlas[..., 3] = 1
    path = write_exr(tmp_path / "atlas.exr", atlas)
    material = preview_material("preview", path, LAYOUT, UV_LAYER, Filter.QUADRILINEAR)
    scene = cast(Any, bpy.context.scene)
    set_up_render(scene, engine)
    camera, surfaces = build_scene(material)
    image = render_exr(scene, tmp_path / "view.exr")
    hits = cast_rays(camera, scene, surfaces)
    x, y = hits.pixel.T
    error = relative_error(image[y, x], expected(hits, surfaces, atlas, Filter.QUADRILINEAR))
    check_each_surface(engine, error, hits)


def check_each_surface(engine: str, error: Floats, hits: Hits) -> None:
    """Nearly all pixels are right: at silhouettes and UV seams a ray may fall on the other side."""
    for index, name in enumerate([*PLACES, "mirrored instance"]):
        own = error[hits.surface == index]
        wrong = np.mean(own > 2e-3)
        print(f"{engine} {name}: {len(own)} pixels, median error {np.median(own):.1e}, wrong {wrong:.2%}")
        assert len(own) > 1000
        assert wrong <= 0.01


@pytest.mark.parametrize("engine", ENGINES.values(), ids=ENGINES)
def test_alpha_lets_through_what_lies_behind(engine: str, tmp_path: Path) -> None:
    colour = np.array([0.5, 0.25, 0.125, 0.25], np.float16)  # premultiplied
    atlas = np.broadcast_to(colour, (LAYOUT.pixel_height, LAYOUT.pixel_width, 4))
    material = preview_material(
        "preview", write_exr(tmp_path / "a.exr", atlas), LAYOUT, UV_LAYER, Filter.NEAREST
    )
    scene = cast(Any, bpy.context.scene)
    set_up_render(scene, engine)
    scene.cycles.samples = scene.eevee.taa_render_samples = 64
    mesh = bpy.data.meshes.new("pane")
    mesh.from_pydata([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [], [(0, 1, 2, 3)])
    mesh.uv_layers.new(name=UV_LAYER)
    mesh.materials.append(material)
    scene.collection.objects.link(bpy.data.objects.new("pane", mesh))
    add_camera_above(scene, (0, 0), (2, 2), 8)
    image = render_exr(scene, tmp_path / "view.exr")
    print(f"{engine}: {image.mean(axis=(0, 1))}, spread {np.ptp(image, axis=(0, 1))}")
    np.testing.assert_allclose(image.mean(axis=(0, 1)), colour, rtol=0.02)
