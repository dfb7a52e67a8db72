# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The diffuse light of an object as the layered layout has it, and nothing else."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

import bpy
import numpy as np

from radtex_addon.bake.piece_store import NO_STORE
from radtex_addon.bake.plan import CapturePlan, plan_capture
from radtex_addon.bake.pooling import Neighbours
from radtex_addon.bake.progress import finished
from radtex_addon.core.arrays import Floats
from radtex_addon.cycles.sampling import capture_samples
from radtex_addon.forms.layered.capture.gloss_maps import within_texels
from radtex_addon.forms.layered.capture.light_map import capture_light_map
from radtex_addon.forms.layered.capture.material_maps import capture_maps
from radtex_addon.forms.layered.capture.surface_alone import surface_alone
from radtex_addon.forms.layered.fit.diffuse import facing_of, fit_falloffs, fit_irradiance
from radtex_addon.forms.layered.fit.light_map import PLACES
from radtex_addon.prepare.prepared import Prepared
from radtex_addon.scene.scratch import scene_copied
from radtex_addon.settings.rays import PROBE_CELLS, LayeredRays
from radtex_addon.settings.spec import BakeSpec


@dataclass(frozen=True, eq=False)
class Ours:
    """Irradiance (K, 3) of a plan's texels, `before` it is traced anew and denoised, and after that.

    With the paths of a texel that both took in the mean, and their seconds.
    """

    plan: CapturePlan
    before: Floats
    after: Floats
    paths: tuple[float, float]
    seconds: tuple[float, float]


def bake_ours(scratch: bpy.types.Scene, prepared: Prepared, spec: BakeSpec, folder: Path) -> Ours:
    """Capture the scratch scene's prepared object. `folder` is for temporary files."""
    originals, meshes = zip(*prepared.rendered, strict=True)
    with surface_alone(originals, meshes):
        texels = prepared.texels()
        probe = plan_capture(texels, PROBE_CELLS)
        hidden = finished(prepared.hidden(probe, texels, folder, NO_STORE))
        without = probe.texel[hidden.buried]
        single = plan_capture(texels, 1, without=without)
        lit = plan_capture(texels, LayeredRays.of(spec.samples).light, without=without)
        with scene_copied(scratch) as copy:
            maps = capture_maps(copy, single, spec.seed, folder)
        unseen = hidden.of_texels(np.isin(probe.texel, lit.texel)).cells
        started = perf_counter()
        with scene_copied(scratch) as copy:
            light = finished(capture_samples(copy, lit, unseen, spec.seed, folder))
        seconds = perf_counter() - started
        colour = maps["diffuse"].reshape(-1, 3)[lit.texel].astype(np.float32)
        triangle = texels.triangle.ravel()[lit.texel]
        material = prepared.surface.material_numbers[triangle]
        within = within_texels(prepared.surface, triangle, single, PLACES)
        more = capture_light_map(scratch, light, within, colour, material, spec.seed, folder, NO_STORE)
        light_map = finished(more)
        all_seconds = perf_counter() - started
    facing, neighbours = facing_of(light), Neighbours(lit)
    falloff = fit_falloffs(light, facing, material)[0]
    before = after = fit_irradiance(light, facing, falloff, material, colour, neighbours)
    if light_map is not None:
        falloff = light_map.falloff
        after = fit_irradiance(light, facing, falloff, material, colour, neighbours)
        after = light_map.onto(after, falloff, material)
    paths = float(lit.layout.bucket**2)
    more_paths = 0.0 if light_map is None else light_map.paths / len(lit.texel)
    return Ours(lit, before, after, (paths, paths + more_paths), (seconds, all_seconds))
