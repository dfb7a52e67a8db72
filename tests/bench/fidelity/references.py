# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a bake is held against: path-traced views, and where the camera's rays meet the baked mesh in them.

Pictures lie below the user's cache folder, by a hash of all that decides them, and are rendered where they
are missing. Rows run from the top.
"""

from __future__ import annotations

import hashlib
import inspect
import os
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np
import numpy.typing as npt
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from radtex_addon.formats.atomic import replacing
from radtex_addon.formats.exr import read_render
from radtex_addon.report.gbuffer import Array, BakedSurface, GBuffer, Rays
from radtex_addon.report.metrics import Picture

from .scenes import PIXELS, Stage
from .scenes import seven as scenes

SAMPLES = 256  # of a pixel of a reference, before it is denoised
SUBSAMPLES = 4  # along a pixel's side
_SEEDS = (11, 22)  # the reference's, and that of the repetition that tells its noise
_RENDERING = 1  # raise it with every change of `_render` that shows
_SCENES = inspect.getsource(scenes)  # as imported, whatever becomes of the file meanwhile
_FAR = 1e9


@dataclass(frozen=True, eq=False)
class View:
    """A camera and what Cycles sees through it.

    `repetition` is the same picture of another seed, where there is one; `blocked` (N,) the distance at which
    each of the `rays` meets anything but the subject.
    """

    name: str
    held_out: bool
    reference: Picture
    repetition: Picture | None
    rays: Rays
    blocked: Array


def views(stage: Stage, quick: bool = False) -> list[View]:
    """The stage's views with their references, rendered if need be; `quick` takes one of each sort.

    The stage must be what the open file holds, as its function made it.
    """
    cameras = [(camera, False) for camera in stage.tuning[: 1 if quick else None]]
    cameras += [(camera, True) for camera in stage.held_out[: 1 if quick else None]]
    blockers = _blockers(stage)
    made = []
    for camera, held_out in cameras:
        rays = _rays(camera)
        repeated = camera == stage.held_out[0]
        made.append(
            View(
                name=camera.name,
                held_out=held_out,
                reference=_picture(stage, camera, _SEEDS[0]),
                repetition=_picture(stage, camera, _SEEDS[1]) if repeated else None,
                rays=rays,
                blocked=_distances(blockers, rays),
            )
        )
    return made


def gbuffer(view: View, mesh: bpy.types.Mesh, matrix_world: npt.ArrayLike, uv_layer: str) -> GBuffer:
    """Where the view's rays meet the baked copy's `mesh` (as `baked_mesh` makes it) under `matrix_world`."""
    return BakedSurface(mesh, matrix_world, uv_layer).gbuffer(view.rays, view.blocked)


def _distances(tree: BVHTree, rays: Rays) -> Array:
    start = Vector(rays.origin.tolist())
    cast_ray = tree.ray_cast
    met = (cast_ray(start, direction)[3] for direction in rays.away.tolist())
    distances = (_FAR if distance is None else distance for distance in met)
    return np.fromiter(distances, np.float64, len(rays.away))


def _rays(camera: bpy.types.Object) -> Rays:
    data = cast(bpy.types.Camera, camera.data)
    turn = np.array(cast(Any, camera).rotation_euler.to_matrix())
    half = data.sensor_width / 2 / data.lens
    return Rays.of_camera(np.array(cast(Any, camera.location)), turn, half, PIXELS, SUBSAMPLES)


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
