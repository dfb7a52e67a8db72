# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bake the layered layout: capture, fit, and write it as several images."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import replace

from ...bake.progress import Progress, Stage
from ...core.atlas import AtlasLayout
from ...formats.image_files import layer_path
from ..bake_job import BakeJob
from ..outcome import Outcome
from .accumulate import read_earlier
from .capture.capturing import capture_layered, material_count
from .files.layered_files import write_layered
from .fit.fitting import fit_layered


def bake_layered(job: BakeJob) -> Generator[Progress, None, Outcome]:
    """As `Form.bake`; every finished capture is stored."""
    spec, prepared = job.spec, job.prepared
    facts, earlier = prepared.facts(spec), None
    if spec.accumulate:
        earlier = read_earlier(job.sidecar, facts, material_count(prepared))
        facts = replace(facts, samples=earlier.samples + spec.samples)
    captured = yield from capture_layered(
        job.scratch,
        prepared,
        spec if earlier is None else earlier.again(spec),
        job.folder,
        job.store,
        job.thumbnail,
        None if earlier is None else earlier.atlas.around,
    )
    plan = captured.capture.light.plan
    known = None if earlier is None else earlier.known(spec)
    atlas = yield from fit_layered(captured.capture, known=known)
    if earlier is not None and known is not None:
        atlas = earlier.merged(atlas, known.share)
    yield Progress(Stage.WRITE, 0, 1)
    written = write_layered(job.place, atlas, facts, spec.half, spec.compression)
    return Outcome(
        images=tuple(layer_path(job.sidecar, layer) for layer in written.bake.layers),
        layout=AtlasLayout(plan.layout.width, plan.layout.height, written.bake.bucket),
        covered_texels=len(plan.texel),
        paths=captured.paths,
        clamped=written.bake.clamped,
    )
