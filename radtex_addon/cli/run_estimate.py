# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Measure small parts of bakes, for the panel's estimate of their time."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from ..job.probes import probe_steps
from ..job.variants import Bake
from ..worker.orders import MEASURING
from .interruption import Interruption
from .opening import open_asked
from .options import ProgressStyle
from .reporting import Report


@dataclass(frozen=True)
class EstimateRequest:
    """The `bakes` to measure, and the scene as for a bake."""

    bakes: tuple[Bake, ...]
    scene: Path | None
    demo: bool
    progress: ProgressStyle
    verbose: bool
    in_scene: str | None
    unsaved_images: Path | None
    parent_pipe: bool


def run_estimate(request: EstimateRequest, report: Report, interruption: Interruption) -> None:
    """Measure each bake, and report what was found, all at the end. Raises RadTexError."""
    scene = open_asked(request, interruption)
    total, probes = len(request.bakes), []
    for number, (name, spec) in enumerate(request.bakes):
        report.event("progress", object=name, stage=MEASURING, done=number, total=total, seconds_left=None)
        steps = probe_steps(scene, name, spec)
        probes.append(interruption.between(steps, lambda _: None).told())
    report.event("done", object="", summary=f"{total} bakes were measured", files=[], probes=probes)
