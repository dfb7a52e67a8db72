# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bake the shared layout: capture single paths, fit an atlas to them, and write it as several images."""

from __future__ import annotations

import logging
from collections.abc import Generator
from dataclasses import dataclass, replace

from ...bake.fit import fit_shared
from ...bake.plan import CapturePlan
from ...bake.progress import Progress, Stage
from ...bake.rays import FINER
from ...bake.spec import BakeSpec
from ...core.atlas import AtlasLayout
from ...core.shared import SharedAtlas
from ...cycles.shared_capture import capture_shared
from ...formats.image_files import layer_path
from ...formats.shared_files import write_shared
from ...formats.sidecar import Sidecar
from ..bake_job import BakeJob
from ..outcome import Outcome

_TOLD = 0.01  # share of the light: if more is lost, warn
_LOST = (
    "%.1f %% of the light of '%s' is lost as fireflies, which single paths brought and no others: "
    "take more samples, or a larger lamp"
)

_log = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class FittedBake:
    """A bake in the shared layout before it is written: the fitted `atlas` of the `plan`'s texels."""

    atlas: SharedAtlas
    plan: CapturePlan
    paths: int
    fireflies: float


def bake_shared(job: BakeJob) -> Generator[Progress, None, Outcome]:
    """As `Form.bake`; every finished render is stored."""
    fitted, spec = (yield from fit_bake(job)), job.spec
    yield Progress(Stage.WRITE, 0, 1)
    facts = facts_with_fireflies(fitted, job.prepared.facts(spec))
    written = write_shared(job.place, fitted.atlas, facts, spec.half, spec.compression)
    return Outcome(
        images=tuple(layer_path(job.sidecar, layer) for layer in written.bake.layers),
        layout=atlas_layout(fitted, spec),
        covered_texels=len(fitted.plan.texel),
        paths=fitted.paths,
        clamped=written.bake.clamped,
        fireflies=fitted.fireflies,
    )


def atlas_layout(fitted: FittedBake, spec: BakeSpec) -> AtlasLayout:
    """The atlas's size with the buckets of a specification."""
    return AtlasLayout(fitted.plan.layout.width, fitted.plan.layout.height, spec.bucket)


def facts_with_fireflies(fitted: FittedBake, facts: Sidecar) -> Sidecar:
    """The sidecar with the share of light that the fit lost; logs a warning if it is large."""
    if fitted.fireflies > _TOLD:
        _log.warning(_LOST, 100 * fitted.fireflies, facts.object_name)
    return replace(facts, fireflies=round(fitted.fireflies, 6))


def fit_bake(job: BakeJob) -> Generator[Progress, None, FittedBake]:
    """Capture the scratch scene's object and fit an atlas to it; errors as in `Form.bake`."""
    spec, prepared = job.spec, job.prepared
    texels = prepared.texels()
    capture = yield from capture_shared(
        job.scratch,
        prepared.original,
        prepared.mesh,
        prepared.matrix_world,
        texels,
        prepared.texels(FINER),
        spec.rays,
        spec.seed,
        job.folder,
        job.store,
        job.thumbnail,
    )
    fitted = yield from fit_shared(
        capture.light, capture.ends, capture.surroundings, capture.colour, cells=spec.bucket
    )
    return FittedBake(fitted.atlas, capture.plan, capture.paths, fitted.fireflies)
