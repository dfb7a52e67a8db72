# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The shared layout: many directions, one path each, fitted to what all texels have in common."""

from __future__ import annotations

from collections.abc import Generator
from pathlib import Path
from time import perf_counter
from typing import Any, TypeVar, cast

import bpy
import numpy as np

from radtex_addon.bake.fit import fit_shared
from radtex_addon.bake.plan import plan_capture
from radtex_addon.bake.spec import Unwrap
from radtex_addon.core.inset import inset
from radtex_addon.core.shared import SharedAtlas, sample_shared
from radtex_addon.core.texel_map import rasterise
from radtex_addon.cycles.hidden import find_hidden
from radtex_addon.cycles.offset import ray_offset
from radtex_addon.cycles.sampling import capture_colour, capture_meetings, capture_samples
from radtex_addon.scene.copy import UV_LAYER, baked_mesh, surface_mesh
from radtex_addon.scene.evaluated import evaluate
from radtex_addon.scene.objects import find_object
from radtex_addon.scene.scratch import scratch_scene
from radtex_addon.scene.unwrap import unwrap_steps
from radtex_addon.scene.unwrap_options import UnwrapOptions

from ..method import Baked
from ..references import Array, GBuffer
from ..scenes import Stage

_HALF = 2  # bytes of a channel
_RIM = 0.2  # as the bake keeps its points off their triangles' edges, in ray offsets
_PROBE = 8  # cells of the probes' buckets
_FINER = 4  # times as many texels a side has the diffuse colour

_Result = TypeVar("_Result")


class Shared:
    """Captures, fits, and samples the fit; paths, seconds and bytes count all of it."""

    name = "shared"

    def __init__(self, texels: int, directions: int) -> None:
        self.texels, self.directions = texels, directions

    def bake(self, stage: Stage, folder: Path) -> Baked:
        scene = cast(bpy.types.Scene, bpy.context.scene)
        name, started = stage.subject.name, perf_counter()
        kept: list[bpy.types.ID] = []
        with scratch_scene(scene, None, kept) as scratch:
            baked = find_object(scratch, name)
            evaluated = evaluate(scratch, baked)
            unwrapped = _finish(unwrap_steps(evaluated, self.texels, Unwrap.XATLAS, UnwrapOptions()))
            mesh = baked_mesh(evaluated, unwrapped.uv, UV_LAYER)
            kept.append(mesh)
            surface = surface_mesh(evaluated, mesh, UV_LAYER)

            def texels(times: int) -> Any:
                found = rasterise(surface, unwrapped.width * times, unwrapped.height * times)
                return inset(found, surface, _RIM * ray_offset(surface.position))

            coarse = texels(1)
            probe = plan_capture(coarse, _PROBE)
            hidden = _finish(find_hidden(mesh, evaluated.matrix_world, probe, folder))
            buried = hidden.all(axis=(1, 2))
            probe = plan_capture(coarse, _PROBE, without=probe.texel[buried])
            hidden = hidden[~buried]
            meetings = capture_meetings(scratch, baked, probe, 0, folder)
        plan = plan_capture(coarse, self.directions, without=np.setdiff1d(_covered(coarse), probe.texel))
        fine = plan_capture(texels(_FINER), 1)
        with scratch_scene(scene, None, []) as scratch:
            samples = _finish(capture_samples(scratch, plan, hidden, 0, folder))
        with scratch_scene(scene, None, []) as scratch:
            colour = capture_colour(scratch, fine, 0, folder)
        captured = perf_counter()
        fitted = fit_shared(samples, meetings, colour)
        atlas, ended = fitted.atlas, perf_counter()
        print(
            f"{stage.name}: captured in {captured - started:.1f} s, fitted in {ended - captured:.1f} s, "
            f"{100 * fitted.fireflies:.2f} % of the energy cut off as fireflies",
            flush=True,
        )

        def radiance(buffer: GBuffer) -> Array:
            hit = buffer.hit
            fragment = (buffer.uv, buffer.position, buffer.normal, buffer.incoming)
            return buffer.spread(sample_shared(atlas, *(part[hit].astype(np.float32) for part in fragment)))

        rays = self.directions**2 + 3 * _PROBE**2  # the light's, one for what is met, two for what is hidden
        return Baked(
            paths=len(plan.texel) * rays + len(fine.texel),
            seconds=ended - started,
            bytes=_bytes(atlas),
            radiance=radiance,
            mesh=mesh,
            matrix_world=np.array(stage.subject.matrix_world),
            uv_layer=UV_LAYER,
        )


def _covered(texels: Any) -> Any:
    return np.flatnonzero(texels.triangle >= 0)


def _finish(steps: Generator[Any, None, _Result]) -> _Result:
    while True:
        try:
            next(steps)
        except StopIteration as stop:
            return cast(_Result, stop.value)


def _bytes(atlas: SharedAtlas) -> int:
    """Half floats throughout, as a GPU holds them, three channels in four; no compression yet."""
    images = (atlas.rest, atlas.surroundings, atlas.colour, atlas.irradiance)
    pixels = sum(int(np.prod(image.shape[:-1])) for image in images)
    return _HALF * (4 * pixels + int(np.prod(atlas.nearness.shape)))


METHOD = Shared(texels=128, directions=28)
