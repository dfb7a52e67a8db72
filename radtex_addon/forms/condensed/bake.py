# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bake the condensed form: fit the shared layout, then condense it for a size or quality."""

from __future__ import annotations

from collections.abc import Generator

from ...bake.progress import Progress
from ...formats.shared_files import texture_path
from ..bake_job import BakeJob
from ..outcome import Outcome
from ..shared.bake import atlas_layout, facts_with_fireflies, fit_bake
from .condense import check_budget, condense_steps


def bake_condensed(job: BakeJob) -> Generator[Progress, None, Outcome]:
    """As `Form.bake`. Raises InputError for a budget that is too small for its texels."""
    spec, prepared = job.spec, job.prepared
    check_budget(spec, prepared.width, prepared.height)
    fitted = yield from fit_bake(job)
    facts = facts_with_fireflies(fitted, prepared.facts(spec))
    steps = condense_steps(job.place, fitted.atlas, fitted.plan, spec, facts)
    written, condensed = yield from steps
    return Outcome(
        images=tuple(texture_path(job.sidecar, layer) for layer in written.bake.layers),
        layout=atlas_layout(fitted, spec),
        covered_texels=len(fitted.plan.texel),
        paths=fitted.paths,
        clamped=written.bake.clamped,
        fireflies=fitted.fireflies,
        condensed=condensed,
    )
