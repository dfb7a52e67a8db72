# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How long a bake will take, by two small ones of the same object: set-up apart from each path's cost."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from .progress import Stage
from .spec import BakeSpec, Layout

_TEXELS = (8, 32)  # of the small bakes: far enough apart to tell set-up from pace
_SAMPLES = 4


@dataclass(frozen=True)
class Probe:
    """What a small bake of `texels` on its longer side took: its covered texels, camera paths and seconds."""

    texels: int
    covered: int
    paths: int
    seconds: float


def probe_specs(spec: BakeSpec) -> tuple[BakeSpec, BakeSpec]:
    """The two small bakes that tell about `spec`, whose texels, samples and limits they leave aside."""
    samples = min(spec.samples, _SAMPLES)
    small, large = (
        replace(spec, texels=texels, samples=samples, budget=None, target=None) for texels in _TEXELS
    )
    return small, large


def probe_of(spec: BakeSpec, covered: int, paths: int, seconds: Mapping[Stage, float]) -> Probe:
    """What a bake of one of `probe_specs` took, by what the job says of it; saving a preview is left out."""
    spent = sum(value for stage, value in seconds.items() if stage != Stage.PREVIEW)
    return Probe(spec.texels, covered, paths, spent)


def paths_needed(spec: BakeSpec, large: Probe) -> int:
    """Camera paths of a bake of `spec`, if as much of its atlas is covered as of the larger probe's."""
    covered = round(spec.texels**2 * large.covered / large.texels**2)
    if spec.layout is Layout.SHARED:
        return spec.rays.most(covered)
    return covered * spec.bucket**2 * spec.samples


def seconds_needed(spec: BakeSpec, small: Probe, large: Probe) -> float:
    """How long a bake of `spec` takes: a line through both probes. Condensing comes on top."""
    pace = max(large.seconds - small.seconds, 0.0) / max(large.paths - small.paths, 1)
    return max(large.seconds + pace * (paths_needed(spec, large) - large.paths), small.seconds)
