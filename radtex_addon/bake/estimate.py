# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Estimate how long a bake will take, from two small bakes of the same object with few texels and few paths.

The two differ only in their number of paths, which separates the time per path from the time for set-up.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from .progress import Stage
from .spec import BakeSpec

_TEXELS = 96  # of a small bake, at most; many islands may not fit into fewer
_SAMPLES = (1, 3)
_ONCE = (Stage.EVALUATE, Stage.UNWRAP)  # take as long for few texels as for many
_BY_PATH = (Stage.CAPTURE, Stage.FIT)
_BY_TEXEL = (Stage.RASTER, Stage.PROBE, Stage.DENOISE, Stage.FILL, Stage.WRITE)


@dataclass(frozen=True)
class Probe:
    """Cost of a bake with `texels` on its longer side: covered texels, camera paths, seconds by stage."""

    texels: int
    covered: int
    paths: int
    seconds: Mapping[Stage, float]

    def spent(self, *stages: Stage) -> float:
        """The sum of the seconds of these stages."""
        return sum(self.seconds.get(stage, 0.0) for stage in stages)


def probe_specs(spec: BakeSpec) -> tuple[BakeSpec, BakeSpec]:
    """The two small bakes from which to estimate `spec`; the one with fewer paths comes first."""
    texels = min(spec.texels, _TEXELS)
    padding = spec.padding if texels == spec.texels else 0
    few, more = (
        replace(spec, texels=texels, density=None, padding=padding, samples=samples) for samples in _SAMPLES
    )
    return few, more


def paths_needed(spec: BakeSpec, probe: Probe) -> int:
    """Camera paths of a bake of `spec`, if the covered share of its atlas is the same as the probe's."""
    covered = round(probe.covered * _growth(spec, probe))
    if spec.form.by_paths:
        return spec.most_paths(covered)
    if not spec.kind.traits.samples:  # the rays per cell depend on the scene, and were measured by the probe
        return round(probe.paths * _growth(spec, probe))
    return covered * spec.bucket**2 * spec.samples


def seconds_needed(spec: BakeSpec, few: Probe, more: Probe) -> float:
    """How many seconds a bake of `spec` takes."""
    growth = _growth(spec, more)
    further = paths_needed(spec, more) - more.paths
    total = more.spent(*_ONCE) + growth * more.spent(*_BY_TEXEL)
    for stage in _BY_PATH:
        spent = more.spent(stage)
        pace = (spent - few.spent(stage)) / max(more.paths - few.paths, 1)
        if pace <= 0 or more.paths <= few.paths:  # too noisy, or kind shadow: count all the time as per path
            pace = spent / more.paths
        total += max(spent + pace * further, 0.0)
    return total


def _growth(spec: BakeSpec, probe: Probe) -> float:
    """How many times as many texels the bake has as the probe."""
    return (spec.texels / probe.texels) ** 2
