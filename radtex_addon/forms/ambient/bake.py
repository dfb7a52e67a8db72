# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Kind `ao`: how much of the sky each texel sees, and in which direction most of it lies."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import replace
from pathlib import Path

import numpy as np

from ...bake.progress import Progress
from ...bake.spec import BakeSpec
from ...core.atlas import AtlasLayout
from ...core.hemisphere import occlusion
from ...formats.bucket_files import write_buckets
from ...formats.sidecar import Sidecar
from ..bake_job import BakeJob
from ..occlusion_bake import Captured, capture_occlusion
from ..outcome import Outcome


def bake_ambient(job: BakeJob) -> Generator[Progress, None, Outcome]:
    """As `Form.bake`."""
    captured, spec = (yield from capture_occlusion(job)), job.spec
    facts = replace(job.prepared.facts(spec), bucket=1, samples=captured.rays, ao_distance=spec.ao_distance)
    _write(job.place, captured, facts, spec)
    layout = captured.plan.layout
    return Outcome(
        images=(job.sidecar.with_suffix(".exr"),),
        layout=AtlasLayout(layout.width, layout.height, 1),
        covered_texels=len(captured.plan.texel),
        paths=len(captured.plan.texel) * captured.rays,
        clamped=0,
    )


def _write(path: Path, captured: Captured, facts: Sidecar, spec: BakeSpec) -> None:
    """Write one value per texel: a bucket of one cell, the mean over all rays."""
    layout = captured.plan.layout
    pixels = np.empty((layout.height, layout.width, 4), dtype=np.float32)
    for band in captured.bands.downwards():
        bent, ambient = occlusion(band.buckets[..., 0])
        pixels[band.first : band.end, :, :3] = bent
        pixels[band.first : band.end, :, 3] = ambient
    write_buckets(path, pixels, {}, facts, spec.half, spec.compression)
