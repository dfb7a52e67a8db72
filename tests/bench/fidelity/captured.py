# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A stage captured for baselines: its single paths, and what else they are made of."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter
from typing import cast

import bpy
import numpy as np

from radtex_addon.bake.plan import plan_capture
from radtex_addon.bake.progress import finished
from radtex_addon.core.arrays import Floats
from radtex_addon.core.sampler import bilinear
from radtex_addon.cycles.path_ends import Body
from radtex_addon.forms.layered.capture.opacity import find_alpha_map
from radtex_addon.forms.layered.capture.surface_alone import surface_alone
from radtex_addon.prepare.prepared import Prepared, prepare
from radtex_addon.prepare.unwrapping import Unwraps
from radtex_addon.report.gbuffer import Array, GBuffer
from radtex_addon.scene.objects import find_object
from radtex_addon.scene.scratch import scratch_scene
from radtex_addon.settings.rays import FINER
from radtex_addon.settings.spec import BakeSpec

from .engine_material import Inputs, read_inputs
from .lightmaps import texture_bytes
from .method import Baked
from .scenes import Stage
from .single_paths import Rays, SinglePaths, trace_paths


@dataclass(frozen=True, eq=False)
class Captured:
    """A capture of a stage's subject, the baked copy it is of, and the subject's matrix (4, 4).

    `inputs` are its materials' textures, with as many texels as the diffuse colour, where they were asked
    for; `paths` count all rays of these too. `alpha` (H', W', 1) has as many texels, None where it is 1
    everywhere: light and colour are premultiplied by it, inputs are not.
    """

    capture: SinglePaths
    prepared: Prepared
    matrix_world: Floats
    paths: int
    inputs: Inputs | None = None
    alpha: Floats | None = None

    @property
    def look_alpha(self) -> Callable[[GBuffer], Array] | None:
        """How much is hidden of what lies behind a G-buffer's hits, (N,); None where all of it is."""
        image = self.alpha
        if image is None:
            return None

        def look(buffer: GBuffer) -> Array:
            return buffer.spread(bilinear(image, buffer.uv[buffer.hit].astype(np.float32)))[:, 0]

        return look

    @property
    def alpha_bytes(self) -> int:
        """What a GPU holds of alpha: half a byte a texel (BC4)."""
        return 0 if self.alpha is None else texture_bytes(self.alpha) // 2

    def baked(self, radiance: Callable[[GBuffer], Array], texture_bytes: int) -> Baked:
        """What is made of this capture, its seconds left at 0; `texture_bytes` are those without alpha."""
        return Baked(
            paths=self.paths,
            seconds=0.0,
            bytes=texture_bytes + self.alpha_bytes,
            radiance=radiance,
            mesh=self.prepared.mesh,
            matrix_world=self.matrix_world,
            uv_layer=self.prepared.uv_layer,
            alpha=self.look_alpha,
        )


@dataclass(frozen=True)
class OfCapture:
    """A method that bakes by `of_capture`; with `inputs` the capture has the materials' textures, too."""

    name: str
    spec: BakeSpec
    of_capture: Callable[[Captured], Baked]
    inputs: bool = False

    def bake(self, stage: Stage, folder: Path) -> Baked:
        started = perf_counter()
        captured = capture_stage(stage, self.spec, folder, self.inputs)
        return replace(self.of_capture(captured), seconds=perf_counter() - started)


def capture_stage(
    stage: Stage, spec: BakeSpec, folder: Path, inputs: bool = False, unwraps: Unwraps | None = None
) -> Captured:
    """Capture the stage, which the open file must hold; `folder` takes temporary files.

    `unwraps` is a cache of unwraps, for several captures of one stage.

    Raises InputError where no texel is covered or, with `inputs`, a material is not of one Principled
    shader; BakeError where Cycles fails.
    """
    scene = cast(bpy.types.Scene, bpy.context.scene)
    kept: list[bpy.types.ID] = []
    with scratch_scene(scene, None, kept) as scratch, surface_alone([stage.subject]) as clear:
        item = find_object(scratch, stage.subject.name)
        prepared = finished(prepare(scratch, [item], spec, kept, unwraps=unwraps))
        texels, finer = prepared.texels(), prepared.texels(FINER)
        mesh, matrix = prepared.mesh, prepared.matrix_world
        steps = trace_paths(
            scratch, item, mesh, matrix, texels, finer, Rays.of(spec.samples), spec.seed, folder
        )
        capture = finished(steps)
        fine = plan_capture(finer, 1)
        found = read_inputs(scratch, item, fine, spec.seed, folder) if inputs else None
        alpha = find_alpha_map(scratch, [Body(item, mesh, matrix)], clear, fine, spec.seed, folder)
    paths = capture.paths + (found.rays if found is not None else 0)
    paths += len(fine.texel) if alpha is not None else 0
    return Captured(capture, prepared, np.array(stage.subject.matrix_world), paths, found, alpha)
