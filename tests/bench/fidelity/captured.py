# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A stage captured as for the shared layout: the paths that other ways to bake are fed as well."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import cast

import bpy
import numpy as np

from radtex_addon.bake.plan import plan_capture
from radtex_addon.bake.progress import finished
from radtex_addon.bake.rays import FINER
from radtex_addon.bake.spec import BakeSpec
from radtex_addon.core.arrays import Floats
from radtex_addon.cycles.shared_capture import SharedCapture, capture_shared
from radtex_addon.job.prepare import Prepared, prepare
from radtex_addon.scene.objects import find_object
from radtex_addon.scene.scratch import scratch_scene

from .engine_material import Inputs, read_inputs
from .scenes import Stage


@dataclass(frozen=True, eq=False)
class Captured:
    """A capture of a stage's subject, the baked copy it is of, and the subject's matrix (4, 4).

    `inputs` are its materials' textures, with as many texels as the diffuse colour, where they were asked
    for; `paths` count all rays of these too.
    """

    capture: SharedCapture
    prepared: Prepared
    matrix_world: Floats
    paths: int
    inputs: Inputs | None = None


def capture_stage(stage: Stage, spec: BakeSpec, folder: Path, inputs: bool = False) -> Captured:
    """Capture the stage, which the open file must hold; `folder` takes temporary files.

    Raises InputError where no texel is covered or, with `inputs`, a material is not of one Principled
    shader; BakeError where Cycles fails.
    """
    scene = cast(bpy.types.Scene, bpy.context.scene)
    kept: list[bpy.types.ID] = []
    with scratch_scene(scene, None, kept) as scratch:
        item = find_object(scratch, stage.subject.name)
        prepared = finished(prepare(scratch, [item], spec, kept))
        texels, finer = prepared.texels(), prepared.texels(FINER)
        mesh, matrix = prepared.mesh, prepared.matrix_world
        steps = capture_shared(scratch, item, mesh, matrix, texels, finer, spec.rays, spec.seed, folder)
        capture = finished(steps)
        found = read_inputs(scratch, item, plan_capture(finer, 1), spec.seed, folder) if inputs else None
    paths = capture.paths + (found.rays if found is not None else 0)
    return Captured(capture, prepared, np.array(stage.subject.matrix_world), paths, found)
