# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a bake is held against: path-traced views, and where the camera's rays meet the baked mesh in them.

Pictures lie below the user's cache folder, by a hash of all that decides them, and are rendered where they
are missing. Rows run from the top; rays lie in the order (row, column, row within, column within).
"""

from __future__ import annotations

import hashlib
import inspect
import os
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np
import numpy.typing as npt
from mathutils import Vector
from mathutils.bvhtree import BVHTree
from scipy.ndimage import binary_erosion

from radtex_addon.core.frame import orthonormal_frame, to_frame
from radtex_addon.formats.atomic import replacing
from radtex_addon.formats.exr import read_render

from . import scenes
from .scenes import PIXELS, Stage

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]
Picture = npt.NDArray[np.float64]  # (PIXELS, PIXELS, 3), linear
Mask = npt.NDArray[np.bool_]  # (PIXELS, PIXELS)

SAMPLES = 256  # of a pixel of a reference, before it is denoised
SUBSAMPLES = 4  # along a pixel's side
_SEEDS = (11, 22)  # the reference's, and that of the repetition that tells its noise
_RENDERING = 1  # raise it with every change of `_render` that shows
_SCENES = inspect.getsource(scenes)  # as imported, whatever becomes of the file meanwhile
_FAR = 1e9


@dataclass(frozen=True, eq=False)
class View:
    """A camera and what Cycles sees through it.

    `repetition` is the same picture of another seed, where there is one. `origin` (3,) and `away` (N, 3),
    unit, are the N = PIXELS² SUBSAMPLES² camera rays in world space, `blocked` (N,) the distance at which a
    ray meets anything but the subject.
    """

    name: str
    held_out: bool
    reference: Picture
    repetition: Picture | None
    origin: Array
    away: Array
    blocked: Array


@dataclass(frozen=True, eq=False)
class GBuffer:
    """The subject's surface where a view's N rays first meet it; zeros where they do not.

    `hit` (N,) bool; `position` (N, 3), in world space; `normal`, `tangent`, `bitangent` (N, 3), the
    orthonormal frame that the preview makes there, in world space; `sign` (N,), the bitangent's, ±1; `uv`
    (N, 2), of the baked layer; `incoming` (N, 3), unit, towards the viewer in world space; `triangle` (N,),
    of the baked mesh, and `barycentric` (N, 3) in it.
    """

    hit: npt.NDArray[np.bool_]
    position: Array
    normal: Array
    tangent: Array
    bitangent: Array
    sign: Array
    uv: Array
    incoming: Array
    triangle: Indices
    barycentric: Array

    @cached_property
    def incidence(self) -> Array:
        """`incoming` in the frame (T, Bt, N): (N, 3)."""
        incidence = to_frame(self.incoming, self.tangent, self.bitangent, self.normal)
        return incidence.astype(np.float64, copy=False)

    @property
    def inside(self) -> Mask:
        """Pixels that the subject covers wholly, (PIXELS, PIXELS)."""
        covered: Mask = self.hit.reshape(PIXELS, PIXELS, -1).all(axis=2)
        return covered

    @property
    def eroded(self) -> Mask:
        """`inside` without its outermost pixels."""
        return cast(Mask, binary_erosion(self.inside))

    def spread(self, values: npt.NDArray[np.floating[Any]]) -> Array:
        """Values of the rays that hit, (hits, C), among all: (N, C), zero elsewhere."""
        return _spreader(self.hit)(values)

    def resolve(self, radiance: Array) -> Picture:
        """The picture of radiance (N, 3) along the rays: each pixel's mean over those that hit."""
        seen = self.hit.reshape(PIXELS, PIXELS, -1, 1)
        total = np.where(seen, radiance.reshape(PIXELS, PIXELS, -1, 3), 0).sum(axis=2)
        picture: Picture = total / np.maximum(seen.sum(axis=2), 1)
        return picture


def views(stage: Stage, quick: bool = False) -> list[View]:
    """The stage's views with their references, rendered if need be; `quick` takes one of each sort.

    The stage must be what the open file holds, as its function made it.
    """
    cameras = [(camera, False) for camera in stage.tuning[: 1 if quick else None]]
    cameras += [(camera, True) for camera in stage.held_out[: 1 if quick else None]]
    blockers = _blockers(stage)
    made = []
    for camera, held_out in cameras:
        origin, away = _rays(camera)
        repeated = camera == stage.held_out[0]
        made.append(
            View(
                name=camera.name,
                held_out=held_out,
                reference=_picture(stage, camera, _SEEDS[0]),
                repetition=_picture(stage, camera, _SEEDS[1]) if repeated else None,
                origin=origin,
                away=away,
                blocked=_distances(blockers, origin, away),
            )
        )
    return made


def gbuffer(view: View, mesh: bpy.types.Mesh, matrix_world: npt.ArrayLike, uv_layer: str) -> GBuffer:
    """Where the view's rays meet the baked copy's `mesh` (as `baked_mesh` makes it) under `matrix_world`."""
    matrix = np.array(matrix_world, dtype=np.float64)
    place = _values(mesh.vertices, "co", 3) @ matrix[:3, :3].T + matrix[:3, 3]
    corner = _values(mesh.loops, "vertex_index", 1).astype(np.int64).reshape(-1, 3)
    tree = cast(BVHTree, BVHTree.FromPolygons(place.tolist(), corner.tolist(), all_triangles=True))
    near = _around(view, place)
    triangle = np.full(len(view.away), -1, dtype=np.int64)
    triangle[near] = _first_met(tree, view.origin, view.away[near])
    hit = triangle >= 0
    distance, weights = _meet(view.origin, view.away[hit], place[corner[triangle[hit]]])
    kept = distance < view.blocked[hit]
    hit[hit] = kept
    triangle[~hit] = 0
    distance, weights = distance[kept], weights[kept]

    def at_hits(name: str, field: str, width: int) -> Array:
        values = _values(cast(Any, mesh).attributes[name].data, field, width).reshape(-1, 3, width)
        mixed: Array = np.einsum("kc,kcw->kw", weights, values[triangle[hit]])
        return mixed

    mirrored = -1.0 if np.linalg.det(matrix[:3, :3]) < 0 else 1.0
    sign = np.sign(at_hits("radtex_sign", "value", 1)[:, 0]) * mirrored
    tangent, bitangent, normal = orthonormal_frame(
        at_hits("radtex_normal", "vector", 3) @ np.linalg.inv(matrix[:3, :3]),
        at_hits("radtex_tangent", "vector", 3) @ matrix[:3, :3].T,
        sign,
    )
    spread = _spreader(hit)
    return GBuffer(
        hit=hit,
        position=spread(view.origin + view.away[hit] * distance[:, None]),
        normal=spread(normal),
        tangent=spread(tangent),
        bitangent=spread(bitangent),
        sign=spread(sign[:, None])[:, 0],
        uv=spread(at_hits(uv_layer, "vector", 2)),
        incoming=spread(-view.away[hit]),
        triangle=triangle,
        barycentric=spread(weights),
    )


def _spreader(hit: npt.NDArray[np.bool_]) -> Callable[[npt.NDArray[np.floating[Any]]], Array]:
    def spread(values: npt.NDArray[np.floating[Any]]) -> Array:
        every = np.zeros((len(hit), values.shape[1]))
        every[hit] = values
        return every

    return spread


def _values(items: Any, field: str, width: int) -> Array:
    values = np.empty(len(items) * width, dtype=np.float32 if field != "vertex_index" else np.int32)
    items.foreach_get(field, values)
    return values.reshape(-1, width).astype(np.float64)


def _around(view: View, place: Array) -> npt.NDArray[np.bool_]:
    """Which rays can meet a mesh: those within the cone of its vertices."""
    towards = place - view.origin
    towards /= np.linalg.norm(towards, axis=1, keepdims=True)
    axis = towards.mean(axis=0)
    within: npt.NDArray[np.bool_] = view.away @ axis >= (towards @ axis).min() - 1e-4
    return within


def _first_met(tree: BVHTree, origin: Array, away: Array) -> Indices:
    start = Vector(origin.tolist())
    cast_ray = tree.ray_cast
    met = (cast_ray(start, direction)[2] for direction in away.tolist())
    return np.fromiter((-1 if index is None else index for index in met), np.int64, len(away))


def _distances(tree: BVHTree, origin: Array, away: Array) -> Array:
    start = Vector(origin.tolist())
    cast_ray = tree.ray_cast
    met = (cast_ray(start, direction)[3] for direction in away.tolist())
    return np.fromiter((_FAR if distance is None else distance for distance in met), np.float64, len(away))


def _meet(origin: Array, away: Array, corners: Array) -> tuple[Array, Array]:
    """Distances (K,) and barycentric weights (K, 3) where rays meet the triangles (K, 3, 3) they hit."""
    first, second, third = corners[:, 0], corners[:, 1], corners[:, 2]
    along, across = second - first, third - first
    normal = np.cross(away, across)
    scale = 1 / np.einsum("ki,ki->k", along, normal)
    offset = origin - first
    u = np.einsum("ki,ki->k", offset, normal) * scale
    turned = np.cross(offset, along)
    v = np.einsum("ki,ki->k", away, turned) * scale
    distance = np.einsum("ki,ki->k", across, turned) * scale
    weights = np.clip(np.stack([1 - u - v, u, v], axis=1), 0, 1)  # a hair outside, by float32's rounding
    return distance, weights / weights.sum(axis=1, keepdims=True)


def _rays(camera: bpy.types.Object) -> tuple[Array, Array]:
    """The camera's place (3,) and its rays' directions (N, 3) in world space."""
    data = cast(bpy.types.Camera, camera.data)
    half = data.sensor_width / 2 / data.lens
    count = PIXELS * SUBSAMPLES
    steps = ((np.arange(count) + 0.5) / count * 2 - 1) * half
    x, y = np.meshgrid(steps, -steps)
    local = np.stack([x, y, -np.ones_like(x)], axis=2)
    local = local.reshape(PIXELS, SUBSAMPLES, PIXELS, SUBSAMPLES, 3).swapaxes(1, 2).reshape(-1, 3)
    turn = np.array(cast(Any, camera).rotation_euler.to_matrix())
    away = local @ turn.T
    return np.array(cast(Any, camera.location)), away / np.linalg.norm(away, axis=1, keepdims=True)


def _blockers(stage: Stage) -> BVHTree:
    """All that a camera sees but the subject, in world space."""
    graph = bpy.context.evaluated_depsgraph_get()
    places: list[Any] = []
    faces: list[tuple[int, ...]] = []
    for item in cast(bpy.types.Scene, bpy.context.scene).objects:
        if item.type != "MESH" or item == stage.subject:
            continue
        shown: Any = item.evaluated_get(graph)
        mesh = shown.data
        start = len(places)
        places += [shown.matrix_world @ vertex.co for vertex in mesh.vertices]
        faces += [tuple(start + index for index in face.vertices) for face in mesh.polygons]
    return cast(BVHTree, BVHTree.FromPolygons(places, faces))


def _picture(stage: Stage, camera: bpy.types.Object, seed: int) -> Picture:
    path = _cache() / f"{stage.name}-{camera.name.replace(' ', '-')}-{seed}.npy"
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        rendered = _render(camera, seed)
        with replacing(path) as beside, beside.open("wb") as file:
            np.save(file, rendered.astype(np.float32))
    picture: Picture = np.load(path).astype(np.float64)
    return picture


def _cache() -> Path:
    root = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    facts = f"{_SCENES}\n{bpy.app.version_string}\n{SAMPLES}\n{_RENDERING}"
    return root / "radtex" / "fidelity" / hashlib.sha256(facts.encode()).hexdigest()[:16]


def _render(camera: bpy.types.Object, seed: int) -> Picture:
    """A denoised picture, by a copy of the scene, so that the scene keeps its settings."""
    copy = cast(bpy.types.Scene, cast(bpy.types.Scene, bpy.context.scene).copy())
    try:
        copy.camera = camera
        cycles = cast(Any, copy).cycles
        cycles.samples, cycles.seed, cycles.use_adaptive_sampling = SAMPLES, seed, False
        cycles.use_denoising, cycles.denoiser = True, "OPENIMAGEDENOISE"
        cycles.pixel_filter_type = "BOX"
        cycles.filter_width = 1.0
        image = copy.render.image_settings
        if hasattr(image, "media_type"):
            image.media_type = "IMAGE"
        image.file_format, image.color_depth = "OPEN_EXR", "32"
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "view.exr")
            copy.render.filepath = str(path)
            bpy.ops.render.render(write_still=True, scene=copy.name)
            (pixels,) = read_render(path).values()
    finally:
        bpy.data.scenes.remove(copy)
    picture: Picture = pixels[::-1, :, :3].astype(np.float64)
    return picture
