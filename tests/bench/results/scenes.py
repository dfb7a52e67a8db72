# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The scenes of the Results, and their views."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import bpy

from ..fidelity.lottery import lottery, lottery_name
from ..fidelity.references import View, view_of
from ..fidelity.scenes import Stage

DRAWN_WITH = 20261126  # the lottery's seed: chosen once, after the code was frozen, before the first bake
_COUNT = 5
REFERENCE_SAMPLES = 256  # of a pixel, before it is denoised
SUBSAMPLES = 2  # lookups along a pixel's side

SCENES: dict[str, Callable[[], Stage]] = {
    lottery_name(DRAWN_WITH, number): partial(lottery, DRAWN_WITH, number) for number in range(_COUNT)
}


def cameras_of(stage: Stage) -> tuple[bpy.types.Object, ...]:
    """Three cameras of a stage: nothing is tuned on scenes that are drawn anew, so any of its own will do."""
    return (*stage.held_out, stage.tuning[0])


def looked_from(stage: Stage) -> list[View]:
    """The stage's views with their references; the open file must hold the stage."""
    return [view_of(stage, camera, REFERENCE_SAMPLES, SUBSAMPLES) for camera in cameras_of(stage)]
