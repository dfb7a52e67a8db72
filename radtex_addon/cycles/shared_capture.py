# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""All captures of the shared layout, one after another, each in a scratch scene of its own."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np

from ..bake.light_samples import EndSamples, LightSamples, SurroundingsSamples, joined, panorama_plan
from ..bake.piece_store import NO_STORE, PieceStore
from ..bake.plan import CapturePlan, plan_capture
from ..bake.progress import Progress, Stage, relayed
from ..bake.rays import PROBE_CELLS, PROBES, Rays
from ..bake.thumbnail import Thumbnail
from ..core.arrays import Floats
from ..core.texel_map import TexelMap
from ..scene.mesh.surrounding_shapes import read_beside
from ..scene.scratch import scene_copied
from .find_hidden import find_hidden
from .path_ends import path_ends
from .sampling import capture_colour, capture_ends, capture_samples, capture_surroundings

_OUTSIDE = 1.05  # times the object's radius: a sphere around it


@dataclass(frozen=True, eq=False)
class SharedCapture:
    """The input of `fit_shared`, and the number of camera `paths` that it took."""

    light: LightSamples
    ends: EndSamples
    surroundings: SurroundingsSamples
    colour: Floats
    paths: int

    @property
    def plan(self) -> CapturePlan:
        return self.light.plan


def capture_shared(
    scratch: bpy.types.Scene,
    baked: bpy.types.Object,
    mesh: bpy.types.Mesh,
    matrix_world: Floats,
    texels: TexelMap,
    finer: TexelMap,
    rays: Rays,
    seed: int,
    folder: Path,
    store: PieceStore = NO_STORE,
    thumbnail: Thumbnail | None = None,
) -> Generator[Progress, None, SharedCapture]:
    """Capture the scratch scene's object `baked` for the shared layout.

    `mesh` is the baked copy's mesh, `matrix_world` (4, 4) its object's matrix; `texels` is the atlas's texel
    map, `finer` the diffuse colour's. `folder` is for temporary files; the `store` stores every finished
    render; the light is shown in the `thumbnail`. Yields progress in texels, then in paths. Raises InputError
    where no texel is covered, BakeError where Cycles fails.
    """
    probe = plan_capture(texels, PROBE_CELLS)
    hidden = yield from find_hidden([(mesh, matrix_world)], probe, folder, store)
    buried = hidden.buried
    without = probe.texel[buried]

    def plan(cells: int) -> CapturePlan:
        return plan_capture(texels, cells, without=without)

    lit, fine = plan(rays.light), plan_capture(finer, 1)
    count, all_around = len(lit.texel), rays.of_panorama
    total = count * rays.of_texel + all_around + len(fine.texel)
    middle, radius = reach_of(lit)
    yield Progress(Stage.CAPTURE, 0, total)
    beside = read_beside(scratch, baked)
    with scene_copied(scratch) as scene, path_ends(scene, baked, mesh, beside, middle) as ends:
        found = capture_ends(ends, plan(rays.ends), seed, folder, store)
        done = 2 * count * rays.ends**2
        yield Progress(Stage.CAPTURE, done, total)
        near = capture_surroundings(scene, ends, plan(rays.around), middle, seed, folder, store, "near")
    done += 2 * count * rays.around**2
    yield Progress(Stage.CAPTURE, done, total)
    around = panorama_plan(near, middle, radius, rays.size, rays.panorama)
    with scene_copied(scratch) as scene, path_ends(scene, baked, mesh, beside, middle) as ends:
        far = capture_surroundings(scene, ends, around, middle, seed, folder, store, "far")
    done += all_around

    def in_paths(step: Progress) -> Progress:
        return Progress(step.stage, done + step.done * rays.light**2, total)

    with scene_copied(scratch) as scene:
        steps = capture_samples(scene, lit, hidden.of_texels(~buried).cells, seed, folder, store, thumbnail)
        light = yield from relayed(steps, in_paths)
    with scene_copied(scratch) as scene:
        colour = capture_colour(scene, fine, seed, folder, store)
    yield Progress(Stage.CAPTURE, total, total)
    probes = len(probe.texel) * PROBES * PROBE_CELLS**2
    return SharedCapture(light, found, joined(near, far), colour, total + probes)


def reach_of(plan: CapturePlan) -> tuple[Floats, float]:
    """The middle of the plan's points, (3,) float32, and the radius of a sphere around all of them."""
    places = plan.points
    middle: Floats = ((places.min(axis=0) + places.max(axis=0)) / 2).astype(np.float32)
    return middle, _OUTSIDE * max(float(np.linalg.norm(places - middle, axis=1).max()), 1e-6)
