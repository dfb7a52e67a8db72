# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Kind `shadow`: which directions are blocked, one bit per cell."""

from __future__ import annotations

from collections.abc import Generator
from pathlib import Path

import numpy as np

from ...bake.bands import Bands
from ...bake.progress import Progress
from ...bake.spec import BakeSpec
from ...core.atlas import AtlasLayout
from ...core.shadow import pack_bits
from ...formats.disk.atomic import replacing
from ...formats.shadow_files import write_shadow
from ...formats.sidecar import Sidecar
from ..bake_job import BakeJob
from ..occlusion_bake import capture_occlusion
from ..outcome import Outcome


def bake_bits(job: BakeJob) -> Generator[Progress, None, Outcome]:
    """As `Form.bake`."""
    captured, spec = (yield from capture_occlusion(job)), job.spec
    _write(job.place, captured.bands, job.prepared.facts(spec), spec)
    layout = captured.plan.layout
    return Outcome(
        images=(job.sidecar.with_suffix(".exr"),),
        layout=AtlasLayout(layout.width, layout.height, spec.bucket),
        covered_texels=len(captured.plan.texel),
        paths=len(captured.plan.texel) * captured.rays,
        clamped=0,
    )


def _write(path: Path, bands: Bands, facts: Sidecar, spec: BakeSpec) -> None:
    """Write the sidecar to `path` and the bits beside it, both or neither."""
    rows = [pack_bits(band.buckets[..., 0] < 0.5) for band in bands.downwards()]
    words = np.concatenate(rows[::-1])
    with replacing(path) as beside:  # left last: the sidecar is renamed after the image
        beside.write_text(facts.to_json(), encoding="utf-8", newline="\n")
        write_shadow(path.with_suffix(".exr"), words, facts, spec.compression)
