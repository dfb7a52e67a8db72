# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bake the layered layout: capture, fit, and write it as several images."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import replace

from ...bake.progress import Progress, Stage
from ...core.atlas import AtlasLayout
from ...core.errors import InputError
from ...core.messages import Setting, do
from ...formats.image_files import layer_path
from ..bake_job import BakeJob
from ..outcome import Outcome
from .accumulate import merged, read_earlier, seeded_anew
from .capture.capturing import capture_layered, material_count
from .files.layered_files import write_layered
from .files.sidecar import MOST_MATERIALS
from .fit.fitting import fit_layered
from .fit.known import Known


def bake_layered(job: BakeJob) -> Generator[Progress, None, Outcome]:
    """As `Form.bake`; every finished capture is stored."""
    spec, prepared = job.spec, job.prepared
    facts, known = prepared.facts(spec), None
    _check_materials(prepared.name, material_count(prepared))
    if spec.accumulate:
        atlas, samples = read_earlier(job.sidecar, facts, material_count(prepared))
        facts = replace(facts, samples=samples + spec.samples)
        known = Known(atlas, spec.samples / facts.samples)
        spec = seeded_anew(spec, samples)
    around = None if known is None else known.atlas.around
    captured = yield from capture_layered(
        job.scratch, prepared, spec, job.folder, job.store, job.thumbnail, around, job.surroundings
    )
    plan = captured.capture.light.plan
    atlas = yield from fit_layered(captured.capture, known=known)
    if known is not None:
        atlas = merged(known, atlas)
    yield Progress(Stage.WRITE, 0, 1)
    written = write_layered(job.place, atlas, facts, spec.half, spec.compression)
    return Outcome(
        images=tuple(layer_path(job.sidecar, layer) for layer in written.bake.layers),
        layout=AtlasLayout(plan.layout.width, plan.layout.height, written.bake.bucket),
        covered_texels=len(plan.texel),
        paths=captured.paths,
        clamped=written.bake.clamped,
    )


def _check_materials(name: str, count: int) -> None:
    """Raise InputError for an atlas of more materials than a sidecar holds."""
    if count > MOST_MATERIALS:
        raise InputError(
            f"'{name}' has {count} materials, the layered layout holds {MOST_MATERIALS} in one atlas",
            do("choose layout buckets", Setting.LAYOUT, value="buckets"),
            do("give each material its own atlas", Setting.SPLIT, value="material"),
        )
