# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A stage of the bench, captured for the layered layout."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import cast

import bpy
import numpy as np

from radtex_addon.bake.progress import finished
from radtex_addon.core.arrays import Floats
from radtex_addon.forms.layered.capture.capturing import Captured, capture_layered
from radtex_addon.prepare.prepared import Prepared, prepare
from radtex_addon.prepare.unwrapping import Unwraps
from radtex_addon.scene.objects import find_object
from radtex_addon.scene.scratch import scratch_scene
from radtex_addon.settings.spec import BakeSpec

from ..scenes import Stage


@dataclass(frozen=True, eq=False)
class Staged:
    """What was captured of a stage, the baked copy that it is of, and its matrix (4, 4)."""

    captured: Captured
    prepared: Prepared
    matrix_world: Floats


def capture_staged(stage: Stage, spec: BakeSpec, folder: Path, unwraps: Unwraps | None = None) -> Staged:
    """Capture the stage, which the open file must hold; `folder` takes temporary files.

    `unwraps` is a cache of unwraps, for several captures of one stage.

    Raises InputError where no texel is covered or the object is clear everywhere, BakeError where Cycles
    fails.
    """
    scene = cast(bpy.types.Scene, bpy.context.scene)
    kept: list[bpy.types.ID] = []
    with scratch_scene(scene, None, kept) as scratch:
        item = find_object(scratch, stage.subject.name)
        prepared = finished(prepare(scratch, [item], spec, kept, backs=True, unwraps=unwraps))
        captured = finished(capture_layered(scratch, prepared, spec, folder))
    return Staged(captured, prepared, np.array(stage.subject.matrix_world))
