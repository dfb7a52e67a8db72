# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a bake is held against: path-traced views, and where the camera's rays meet the baked mesh in them.

    python -m tests.bench.fidelity.references                          render what the cache lacks
    python -m tests.bench.fidelity.references --scenes bands,coat --tuning
    python -m tests.bench.fidelity.references --lottery 8 --seed 3

Pictures lie below the user's cache folder, by a hash of all that decides them, and are rendered where they
are missing. Rows run from the top.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, cast

import bpy
import numpy as np
import numpy.typing as npt
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from radtex_addon.report.gbuffer import Array, BakedSurface, CameraRays, GBuffer
from radtex_addon.report.metrics import Picture

from .choice import add_scene_options, chosen_scenes
from .lottery import is_lottery
from .pictures import LOTTERY_SAMPLES, SAMPLES, TUNING_SAMPLES, picture, picture_behind, picture_inside
from .scenes import PIXELS, Stage

SUBSAMPLES = 4  # along a pixel's side
_SEEDS = (11, 22)  # the reference's, and that of the repetition that tells its noise
_FAR = 1e9


@dataclass(frozen=True, eq=False)
class View:
    """A camera and what Cycles sees through it.

    `repetition` is the same picture of another seed, where there is one; `blocked` (N,) the distance at which
    each of the `rays` meets anything but the subject; `behind` what is seen without the subject, if one sees
    through it.
    """

    name: str
    held_out: bool
    reference: Picture
    repetition: Picture | None
    rays: CameraRays
    blocked: Array
    behind: Picture | None = None


def views(stage: Stage, quick: bool = False, tuning: bool = False) -> list[View]:
    """The stage's views with their references, rendered if need be.

    They are the held-out ones, and before them the tuning ones if `tuning`; `quick` takes one of each sort.
    The stage must be what the open file holds, as its function made it.
    """
    tree = blockers(stage)
    made = []
    for camera, held_out, reference, repetition in _pictures(stage, quick, tuning):
        rays = _rays(camera)
        blocked = distances(tree, rays)
        behind = picture_behind(stage, camera) if stage.see_through else None
        made.append(View(camera.name, held_out, reference, repetition, rays, blocked, behind))
    return made


def view_of(stage: Stage, camera: bpy.types.Object, samples: int, subsamples: int = SUBSAMPLES) -> View:
    """The view of one held-out camera, its reference of so many samples a pixel, without a repetition.

    The reference shows what the subject covers wholly; of what lies behind it a quarter of the samples are
    taken. As for `views`, the open file must hold the stage.
    """
    reference = picture_inside(stage, camera, samples, _SEEDS[0])
    rays = _rays(camera, subsamples)
    behind = picture_behind(stage, camera, max(1, samples // 4)) if stage.see_through else None
    return View(camera.name, True, reference, None, rays, distances(blockers(stage), rays), behind)


def _pictures(
    stage: Stage, quick: bool, tuning: bool
) -> Iterator[tuple[bpy.types.Object, bool, Picture, Picture | None]]:
    """Cameras, whether they are held out, their references, and the repetition of the first held-out one."""
    count = 1 if quick else None
    for camera in stage.tuning[:count] if tuning else ():
        yield camera, False, picture(stage, camera, TUNING_SAMPLES, _SEEDS[0]), None
    samples = LOTTERY_SAMPLES if is_lottery(stage.name) else SAMPLES
    for camera in stage.held_out[:count]:
        reference = picture(stage, camera, samples, _SEEDS[0])
        repeated = camera == stage.held_out[0]
        yield camera, True, reference, picture(stage, camera, samples, _SEEDS[1]) if repeated else None


def gbuffer(view: View, mesh: bpy.types.Mesh, matrix_world: npt.ArrayLike, uv_layer: str) -> GBuffer:
    """Where the view's rays meet the baked copy's `mesh` (as `baked_mesh` makes it) under `matrix_world`."""
    return BakedSurface(mesh, matrix_world, uv_layer).gbuffer(view.rays, view.blocked)


def distances(tree: BVHTree, rays: CameraRays) -> Array:
    """How far away each of a camera's rays meets a mesh, (N,); a great distance where it meets none."""
    start = Vector(rays.origin.tolist())
    cast_ray = tree.ray_cast
    met = (cast_ray(start, direction)[3] for direction in rays.away.tolist())
    distances = (_FAR if distance is None else distance for distance in met)
    return np.fromiter(distances, np.float64, len(rays.away))


def _rays(camera: bpy.types.Object, subsamples: int = SUBSAMPLES) -> CameraRays:
    data = cast(bpy.types.Camera, camera.data)
    turn = np.array(cast(Any, camera).rotation_euler.to_matrix())
    half = data.sensor_width / 2 / data.lens
    return CameraRays.of_camera(np.array(cast(Any, camera.location)), turn, half, PIXELS, subsamples)


def blockers(stage: Stage) -> BVHTree:
    """All that a camera sees but the subject, in world space."""
    items = cast(bpy.types.Scene, bpy.context.scene).objects
    return tree_of([item for item in items if item.type == "MESH" and item != stage.subject])


def tree_of(items: Sequence[bpy.types.Object]) -> BVHTree:
    """The surfaces of objects, curves and texts among them, in world space."""
    graph = bpy.context.evaluated_depsgraph_get()
    places: list[Any] = []
    faces: list[tuple[int, ...]] = []
    for item in items:
        shown: Any = item.evaluated_get(graph)
        mesh = shown.to_mesh()
        start = len(places)
        places += [shown.matrix_world @ vertex.co for vertex in mesh.vertices]
        faces += [tuple(start + index for index in face.vertices) for face in mesh.polygons]
        shown.to_mesh_clear()
    return cast(BVHTree, BVHTree.FromPolygons(places, faces))


def main() -> None:
    """Render the references that the cache lacks."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.bench.fidelity.references",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_scene_options(parser)
    options = parser.parse_args()
    for name, build in chosen_scenes(options).items():
        print(name, flush=True)
        for _ in _pictures(build(), options.quick, options.tuning):
            pass


if __name__ == "__main__":
    main()
