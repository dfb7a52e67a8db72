# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A stage captured and fitted in the shared layout, before anything is written, and how its atlases look."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import cast

import bpy
import numpy as np

from radtex_addon.bake.progress import finished
from radtex_addon.bake.spec import BakeSpec
from radtex_addon.core.shared import SharedAtlas
from radtex_addon.forms.bake_job import BakeJob
from radtex_addon.forms.shared.bake import FittedBake, fit_bake
from radtex_addon.prepare.prepared import prepare
from radtex_addon.report.gbuffer import Array, GBuffer
from radtex_addon.scene.objects import find_object
from radtex_addon.scene.scratch import scratch_scene

from .methods.shared import look
from .metrics import compare
from .references import View, gbuffer
from .report import Result, Seen
from .scenes import Stage


@dataclass(frozen=True, eq=False)
class Looked:
    """The views of a stage, and where their rays meet the baked mesh."""

    views: list[tuple[View, GBuffer]]

    def result(self, name: str, atlas: SharedAtlas, size: int = 0) -> Result:
        """The untuned views of an atlas of so many bytes."""
        return self.seen(name, [look(atlas, buffer) for view, buffer in self.views if view.held_out], size)

    def seen(self, name: str, light: list[Array], size: int = 0) -> Result:
        """The untuned views, of each of which `light` (N, 3) is what its rays see."""
        untuned = [(view, buffer) for view, buffer in self.views if view.held_out]
        seen = []
        for (view, buffer), rays in zip(untuned, light, strict=True):
            picture = buffer.resolve(rays)
            figures = compare(picture, view.reference, buffer.inside, buffer.eroded)
            seen.append(Seen(view, picture, buffer.inside, buffer.eroded, figures))
        return Result(name, 0, 0.0, size, tuple(seen))


def fit_stage(
    stage: Stage, looked_from: list[View], spec: BakeSpec, folder: Path
) -> tuple[FittedBake, Looked, str]:
    """The fitted bake of a stage's subject, its views, and the name of the layer that was baked."""
    scene = cast(bpy.types.Scene, bpy.context.scene)
    kept: list[bpy.types.ID] = []
    with scratch_scene(scene, None, kept) as scratch:
        item = find_object(scratch, stage.subject.name)
        prepared = finished(prepare(scratch, [item], spec, kept))
        fitted = finished(fit_bake(BakeJob(scratch, spec, folder / "unwritten.json", prepared, folder)))
    matrix = np.array(stage.subject.matrix_world)
    seen = [(view, gbuffer(view, prepared.mesh, matrix, prepared.uv_layer)) for view in looked_from]
    return fitted, Looked(seen), prepared.uv_layer


def quality(result: Result) -> str:
    """PSNR and energy of the untuned views, in words."""
    return f"{result.mean('psnr', True):.2f} dB, energy {result.mean('energy', True):.3f}"
