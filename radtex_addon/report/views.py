# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Path-traced views of an object in its scene: chosen cameras, reference pictures, and what hides the object.

Everything is rendered in scratch scenes, so that no data of the user's is changed.

The scene against which a bake is judged is the user's with the bake's lamps, and its source instead of the
object.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from math import cos, pi, radians, sin, sqrt
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix, Vector

from ..core.errors import InputError
from ..cycles.building_blocks import render_layers
from ..cycles.capture_settings import (
    apply_capture_settings,
    denoise,
    first_hit_only,
    keep_passes,
    look_at_centres,
)
from ..cycles.passes import Passes
from ..formats.disk.path_checks import render_path
from ..formats.sidecar import Sidecar
from ..scene.lights.lamps import light_only
from ..scene.mesh.cage import take_cage_out, take_out
from ..scene.mesh.source_hits import find_source
from ..scene.proxy_content import EVERYTHING, show_content_only
from ..scene.regroup import leave_alone
from ..scene.scratch import scene_copied
from .gbuffer import Array, BakedSurface, CameraRays, GBuffer
from .metrics import Picture
from .report_progress import ReportStep, ReportTask

MOST_PIXELS = 2048  # along a picture's side
_SUBSAMPLES = 4  # along a pixel's side; fewer if the picture is large
_SEEDS = (1101, 2202)  # the reference's, and the repetition's, which measures noise: other than a bake's
_LENS, _SENSOR = 50.0, 36.0  # millimetres
_HALF = _SENSOR / 2 / _LENS
_MARGIN = 1.1  # the frame's size divided by the object's
_HEIGHTS = (18.0, 38.0, 4.0)  # the cameras' elevations in degrees, in turn
_GOLDEN = pi * (3 - sqrt(5))  # the golden angle between cameras spreads any number of them evenly
_PEEK = 48  # side in pixels of the render that tests a camera
_CLEAR = 0.8  # share of the object's pixels that is visible in a good view
_LEAST = 0.05  # a view with a lower share is rejected
_THIN = 0.05  # share of the picture: an object that covers less is seen edge-on
_TRIES = 8  # cameras to test per view
_TOUCHING = 1e-4  # relative to the distance: what is this close to the surface does not hide it


@dataclass(frozen=True, eq=False)
class Reference:
    """Two scratch scenes: `pictured` is path traced, `before` holds what may hide the baked surface."""

    pictured: bpy.types.Scene
    before: bpy.types.Scene


@contextmanager
def reference_of(scratch: bpy.types.Scene, original: bpy.types.Object, bake: Sidecar) -> Iterator[Reference]:
    """Change a scratch scene so that it renders what a `bake` of its object `original` shows.

    For a bake from a source, the source renders, the object and a cage do not; for a bake of some lamps, only
    these give light; of a bake that was made alone, no other object renders. The scratch scene is not
    restored. Raises InputError for a missing source or lamp.
    """
    if "alone" in bake.marks:
        source = () if bake.source is None else (bake.source.object_name, bake.source.cage)
        leave_alone(scratch, {original.name, *bake.surfaces, *source})
    if bake.source is None:
        _light(scratch, bake)
        yield Reference(scratch, scratch)
        return
    detailed = find_source(scratch, original, bake.source.object_name)
    with scene_copied(scratch) as before:
        for scene in (scratch, before):
            show_content_only(scene, original, EVERYTHING)
            if bake.source.cage is not None:
                take_cage_out(scene, bake.source.cage)
        take_out(before, detailed)
        _light(scratch, bake)
        yield Reference(scratch, before)


def _light(scratch: bpy.types.Scene, bake: Sidecar) -> None:
    if bake.lights:
        light_only(scratch, bake.lights, denoised=True)


@dataclass(frozen=True, eq=False)
class TracedView:
    """A path-traced picture, and the rays that see the baked object from the same camera.

    `repetition` is the picture with another seed, if there is one; `blocked` (N,) are the distances at which
    the N `rays` first meet anything that renders.
    """

    name: str
    reference: Picture
    repetition: Picture | None
    rays: CameraRays
    blocked: Array


@dataclass(frozen=True)
class _Camera:
    """A camera's `matrix` (4, 4), which looks along −z."""

    matrix: Matrix
    reach: float  # distance from the object's middle

    def rays(self, pixels: int, subsamples: int) -> CameraRays:
        turn = np.array(self.matrix.to_3x3())
        return CameraRays.of_camera(np.array(self.matrix.translation), turn, _HALF, pixels, subsamples)


def make_views(
    shown: Reference, surface: BakedSurface, count: int, pixels: int, samples: int, folder: Path
) -> Generator[ReportStep, None, list[TracedView]]:
    """Render `count` views around the surface in the scenes `shown`: square, denoised, the first one twice.

    `folder` is for temporary files. Yields progress. Raises InputError if other objects hide the object on
    all sides, BakeError if Cycles fails.
    """
    cameras = yield from _clear_cameras(shown.before, surface, count, folder)
    views: list[TracedView] = []
    for index, camera in enumerate(cameras):
        yield ReportStep(ReportTask.REFERENCE, len(views) + bool(views), len(cameras) + 1)
        rays = camera.rays(pixels, min(_SUBSAMPLES, MOST_PIXELS // pixels))
        blocked = _distances(shown.before, camera, rays, folder)
        reference = _picture(shown.pictured, camera, pixels, samples, _SEEDS[0], folder)
        again = None
        if index == 0:
            yield ReportStep(ReportTask.REFERENCE, 1, len(cameras) + 1)
            again = _picture(shown.pictured, camera, pixels, samples, _SEEDS[1], folder)
        views.append(TracedView(f"View {index + 1}", reference, again, rays, blocked))
    yield ReportStep(ReportTask.REFERENCE, len(cameras) + 1, len(cameras) + 1)
    return views


def seen(surface: BakedSurface, view: TracedView) -> GBuffer:
    """The G-buffer of the surface in a view."""
    return surface.gbuffer(view.rays, view.blocked)


def _clear_cameras(
    scratch: bpy.types.Scene, surface: BakedSurface, count: int, folder: Path
) -> Generator[ReportStep, None, list[_Camera]]:
    """The first `count` cameras around the object that see it well, or else the best of those tested."""
    good: list[_Camera] = []
    poor: list[tuple[float, _Camera]] = []
    for index, camera in enumerate(_around(surface, count * _TRIES)):
        yield ReportStep(ReportTask.FIND_VIEWS, len(good), count)
        share = _share_seen(scratch, surface, camera, folder)
        if share >= _CLEAR:
            good.append(camera)
        elif share >= _LEAST:
            poor.append((share + 1e-6 * index, camera))
        if len(good) == count:
            return good
    poor.sort(key=lambda found: -found[0])
    cameras = good + [camera for _, camera in poor[: count - len(good)]]
    if not cameras:
        raise InputError(
            "no view around the object shows it: other objects hide it on all sides; hide those from render"
        )
    return cameras


def _around(surface: BakedSurface, count: int) -> Iterator[_Camera]:
    """Cameras around the surface, in which it fills the frame."""
    low, high = surface.place.min(axis=0), surface.place.max(axis=0)
    middle = (low + high) / 2
    around = surface.place - middle
    for index in range(count):
        side, height = index * _GOLDEN - pi / 2 + 0.4, radians(_HEIGHTS[index % len(_HEIGHTS)])
        away = Vector((cos(side) * cos(height), sin(side) * cos(height), sin(height)))
        matrix = away.to_track_quat("Z", "Y").to_matrix().to_4x4()
        seen_from_there = np.abs(around @ np.array(matrix.to_3x3())[:, :2]).max(axis=1)
        far = float((around @ np.array(away) + seen_from_there * _MARGIN / _HALF).max())
        matrix.translation = Vector(middle.tolist()) + away * far
        yield _Camera(matrix, far)


def _share_seen(scratch: bpy.types.Scene, surface: BakedSurface, camera: _Camera, folder: Path) -> float:
    """The share of the surface that nothing hides from a camera, 0 to 1; less if it is seen edge-on."""
    rays = camera.rays(_PEEK, 1)
    alone = surface.gbuffer(rays, np.full(len(rays.away), np.inf)).hit
    found = surface.gbuffer(rays, _distances(scratch, camera, rays, folder)).hit
    return float(found.sum()) / max(float(alone.sum()), _THIN * len(rays.away))


def _distances(scratch: bpy.types.Scene, camera: _Camera, rays: CameraRays, folder: Path) -> Array:
    """The distance along each ray to just behind the first thing that renders; huge if there is none."""
    count = rays.pixels * rays.subsamples
    with scene_copied(scratch) as scene:
        apply_capture_settings(scene, 1, 0)
        look_at_centres(scene)
        keep_passes(scene, ("use_pass_z",))
        first_hit_only(scene)
        depth = _render(scene, camera, count, folder).raw["Depth"][::-1, :, 0].astype(np.float64)
    split = depth.reshape(rays.pixels, rays.subsamples, rays.pixels, rays.subsamples)
    along = rays.away @ -np.array(camera.matrix.to_3x3())[:, 2]
    distance: Array = split.swapaxes(1, 2).reshape(-1) / along
    return distance * (1 + _TOUCHING)


def _picture(
    scratch: bpy.types.Scene, camera: _Camera, pixels: int, samples: int, seed: int, folder: Path
) -> Picture:
    with scene_copied(scratch) as scene:
        apply_capture_settings(scene, samples, seed)
        denoise(scene)
        combined = _render(scene, camera, pixels, folder).whole
    picture: Picture = combined[::-1, :, :3].astype(np.float64)
    return picture


def _render(scene: bpy.types.Scene, camera: _Camera, pixels: int, folder: Path) -> Passes:
    scene.camera = _camera_object(scene, camera)
    scene.render.resolution_x = scene.render.resolution_y = pixels
    file = folder / "view.exr"
    scene.render.filepath = render_path(file)
    return render_layers(scene, file)


def _camera_object(scene: bpy.types.Scene, camera: _Camera) -> bpy.types.Object:
    data = bpy.data.cameras.new("RadTex view")
    data.lens, data.sensor_width, data.sensor_fit = _LENS, _SENSOR, "HORIZONTAL"
    data.clip_start, data.clip_end = camera.reach * 1e-4, camera.reach * 1e4
    item = bpy.data.objects.new("RadTex view", data)
    item.matrix_world = camera.matrix
    scene.collection.objects.link(item)
    return item
