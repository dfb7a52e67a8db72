# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shared by the forms of occlusion: capture which cells' rays are blocked."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass

from ..bake.bands import Bands
from ..bake.plan import CapturePlan
from ..bake.progress import Progress, Stage
from ..bake.session import capture_bands
from ..cycles.occlusion_capture import OcclusionCapture
from .bake_job import BakeJob


@dataclass(frozen=True, eq=False)
class OcclusionCaptured:
    """The share of open rays in each cell, in `bands` of the `plan`'s texels; `rays` were sent per texel."""

    plan: CapturePlan
    bands: Bands
    rays: int


def capture_occlusion(job: BakeJob) -> Generator[Progress, None, OcclusionCaptured]:
    """Capture the prepared objects; every finished tile is stored."""
    spec = job.spec
    plan = yield from job.prepared.plan_of_seen(spec.bucket, job.folder, job.store)
    capture = OcclusionCapture(
        job.scratch, plan, spec.kind, spec.samples, spec.seed, job.folder, spec.ao_distance
    )
    steps = capture_bands(plan, capture, spec.tile_mb, None, job.store, job.thumbnail, spec.channels)
    bands = yield from steps
    yield Progress(Stage.WRITE, 0, 1)
    return OcclusionCaptured(plan, bands, spec.bucket**2 * capture.rays)
