# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""All captures of the shared layout, one after another, each in a scratch scene of its own."""

from __future__ import annotations

from collections.abc import Generator, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import cast

import bpy
import numpy as np

from ..bake.light_samples import EndSamples, LightSamples, SurroundingsSamples, joined, panorama_plan
from ..bake.plan import CapturePlan, plan_capture
from ..bake.progress import Progress
from ..core.arrays import Floats
from ..core.texel_map import TexelMap
from .hidden import PROBES, find_hidden
from .path_ends import path_ends
from .sampling import capture_colour, capture_ends, capture_samples, capture_surroundings

_PROBE = 4  # cells of the buckets that tell hidden directions
_OUTSIDE = 1.05  # of the object's reach from its middle: beyond it


@dataclass(frozen=True)
class Rays:
    """How many paths a texel spends: `light`², and `ends`² and `around`² twice; `panorama` a cell, twice."""

    light: int = 21
    ends: int = 10
    around: int = 5
    panorama: int = 16
    size: int = 256


@dataclass(frozen=True, eq=False)
class SharedCapture:
    """What `fit_shared` takes, and the `paths` that it cost. `middle` (3,) is the object's, in world space."""

    light: LightSamples
    ends: EndSamples
    surroundings: SurroundingsSamples
    colour: Floats
    middle: Floats
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
) -> Generator[Progress, None, SharedCapture]:
    """Capture the scratch scene's object `baked` for the shared layout.

    `mesh` is the baked copy's, `matrix_world` (4, 4) its object's; `texels` are the atlas's, `finer` those of
    the diffuse colour. `folder` takes temporary files. Yields progress in texels. Raises InputError where no
    texel is covered, BakeError where Cycles fails.
    """
    probe = plan_capture(texels, _PROBE)
    hidden = yield from find_hidden(mesh, matrix_world, probe, folder)
    buried = hidden.all(axis=(1, 2))
    without = probe.texel[buried]

    def plan(cells: int) -> CapturePlan:
        return plan_capture(texels, cells, without=without)

    lit = plan(rays.light)
    places = lit.position.reshape(-1, 3)[: len(lit.texel)]
    middle = ((places.min(axis=0) + places.max(axis=0)) / 2).astype(np.float32)
    radius = _OUTSIDE * max(float(np.linalg.norm(places - middle, axis=1).max()), 1e-6)
    with _copied(scratch) as scene, path_ends(scene, baked, mesh, middle) as ends:
        found = capture_ends(ends, plan(rays.ends), seed, folder)
        near = capture_surroundings(scene, ends, plan(rays.around), middle, seed, folder)
    around = panorama_plan(near, middle, radius, rays.size, rays.panorama)
    with _copied(scratch) as scene, path_ends(scene, baked, mesh, middle) as ends:
        far = capture_surroundings(scene, ends, around, middle, seed, folder)
    with _copied(scratch) as scene:
        light = yield from capture_samples(scene, lit, hidden[~buried], seed, folder)
    fine = plan_capture(finer, 1)
    with _copied(scratch) as scene:
        colour = capture_colour(scene, fine, seed, folder)
    each = rays.light**2 + 2 * rays.ends**2 + 2 * rays.around**2
    paths = len(lit.texel) * each + len(probe.texel) * PROBES * _PROBE**2 + 2 * len(around.texel) + len(fine.texel)
    return SharedCapture(light, found, joined(near, far), colour, middle, paths)


@contextmanager
def _copied(scene: bpy.types.Scene) -> Iterator[bpy.types.Scene]:
    copy = cast(bpy.types.Scene, scene.copy())
    try:
        yield copy
    finally:
        bpy.data.scenes.remove(copy)
