# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Estimate how long a bake takes, stage by stage, from measurements: finished bakes, and small probe bakes.

`typical_seconds` says how the time of each stage grows with the work, in seconds of a 2-core machine of 2026.
A measurement tells how much slower or faster this machine, scene and object are: the ratio of its seconds to
the typical ones of the same work. The estimate is the typical time multiplied by a weighted mean of such
ratios, in which the measurements that are most like the bake count most.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import lru_cache
from math import exp, log, sqrt

from ..bake.progress import Stage
from .forms import FORMS
from .kinds import Light
from .layered_times import LayeredTimes
from .rays import CLEAR_SAMPLES, PROBE_CELLS, PROBES, LayeredRays
from .spec import BakeSpec, Kind, Unwrap

START = "start"  # starting the worker, opening the scene, checks; a stage of no bake, but of its job
EXPORT = "exports"  # what is made of the bake for games and browsers; the same
STAGES = (START, *map(str, Stage), EXPORT)

_COVERAGE = 0.55  # the usual share of an atlas that islands cover
# stages whose pace does not depend on what is baked
_ALIKE = frozenset({START, EXPORT, *map(str, (Stage.EVALUATE, Stage.UNWRAP, Stage.RASTER, Stage.PREVIEW))})

# weights of measurements; a measurement of another bake counts 1
_PRIOR, _BAKED, _PROBED, _OTHER_KIND = 0.05, 1000.0, 100.0, 0.02
_OF_ITSELF = 50.0  # weight from which on a measurement of the same object is of the same kind of work
_FADING = 4.0  # how quickly the weight of a finished bake falls with the difference in size
_HALF_LIFE = 20  # so many bakes later a measurement counts half
_LEAST = 1e-3  # seconds: what is shorter says nothing of a pace

# How sure estimates are: standard deviations of the logarithm of a stage's time.
_UNSURE, _OF_OTHERS, _LEAST_OF_OTHERS, _OF_PROBE, _OF_SAME = 0.6, 0.5, 0.25, 0.3, 0.15
_BY_SIZE = 0.25  # and so much more where the same object was baked e times as large
_UNWRAPS = 2.0  # times as much of an unwrap, which depends on the mesh
# … and that of all stages together, which other work on the machine slows, or a machine unlike ours
_BUSY, _UNKNOWN_MACHINE = 0.3, 0.55
_ANY_WORK = 2.5  # of work of which nothing is known but how its stages share its time

_NO_UNWRAP = 0.1  # ratio: an unwrap so quick was none, as the object has a UV layer of its own


@dataclass(frozen=True)
class BakeWork:
    """The amount of work in a bake, or in a probe of it.

    `kind`, `device` and `unwrap` are as in a specification, `layout` is the form's name, and `unwrap` is ""
    with a UV layer that the specification names. Of the `texels` on the longer side `covered` in all are
    baked; the surface has so many `triangles`, and a cell so many `values`. `surroundings` is the width of
    the pictures of what surrounds the object, relative to that in a bake. So many `exports` are made of it.
    """

    kind: str
    layout: str
    device: str
    unwrap: str
    texels: int
    covered: int
    bucket: int
    samples: int
    triangles: int
    values: int = 4
    denoise: bool = False
    preview: bool = False
    surroundings: float = 1.0
    exports: int = 0

    @classmethod
    def of(
        cls,
        spec: BakeSpec,
        triangles: int,
        *,
        covered: int | None = None,
        texels: int | None = None,
        preview: bool = False,
        exports: int = 0,
        device: str,
    ) -> BakeWork:
        """The work of `spec`, with a usual coverage or the specification's texels where none are given."""
        side = spec.texels if texels is None else texels
        return cls(
            kind=str(spec.kind),
            layout=spec.form.name,
            device=device.lower(),
            unwrap=str(spec.unwrap) if spec.uv_layer is None else "",
            texels=side,
            covered=max(1, round(_COVERAGE * side**2)) if covered is None else covered,
            bucket=spec.bucket,
            samples=spec.samples,
            triangles=triangles,
            values=spec.channels,
            denoise=spec.denoise,
            preview=preview,
            exports=exports,
        )

    @property
    def cells(self) -> int:
        """Cells of all covered texels."""
        return self.covered * self.bucket**2

    @property
    def by_paths(self) -> bool:
        """Whether the layout's paths do not depend on its cells."""
        return any(form.by_paths for form in FORMS if form.name == self.layout)


@dataclass(frozen=True)
class Measurement:
    """The `seconds` that stages of some `work` took, of the object `name` in the file and scene `place`.

    `finished`: of a finished bake, and not of a probe. Stages that were not measured are missing.
    `shown_triangles` are the object's in the viewport then, 0 if that is not known.
    """

    place: str
    name: str
    work: BakeWork
    seconds: Mapping[str, float]
    finished: bool = True
    shown_triangles: int = 0


class Basis(StrEnum):
    """What an estimate rests on, from the best to the worst."""

    BAKED = "baked"  # finished bakes of the same object and kind
    MEASURED = "measured"  # a probe bake of it
    OTHERS = "others"  # bakes of other objects on this machine
    NOTHING = "nothing"  # nothing was ever baked here


@dataclass(frozen=True)
class Estimate:
    """The expected `seconds` by stage, in their order, what they rest on, and how sure they are.

    `spread` has the standard deviation of the logarithm of each stage's time, `common` that of all together.
    """

    seconds: Mapping[str, float] = field(default_factory=dict)
    basis: Basis = Basis.NOTHING
    spread: Mapping[str, float] = field(default_factory=dict)
    common: float = _ANY_WORK

    def spread_of(self, stage: str) -> float:
        """The standard deviation of the logarithm of a stage's time."""
        return self.spread.get(stage, _UNSURE)

    def unsure(self) -> Estimate:
        """The same of a bake of which a part may be done already."""
        return replace(self, spread=dict.fromkeys(self.seconds, 2 * _UNSURE))

    @property
    def total(self) -> float:
        """Seconds from pressing the button to the job's end."""
        return sum(self.seconds.values())


@lru_cache(maxsize=1024)
def typical_seconds(work: BakeWork) -> Mapping[str, float]:
    """Seconds of each of the bake's stages on a machine with 2 cores, measured for the demo's scene."""
    kind, paths = Kind(work.kind), work.by_paths
    seconds = {
        START: 3.5,
        str(Stage.EVALUATE): 0.1 + (1.2e-5 if paths else 5e-6) * work.triangles,
        str(Stage.UNWRAP): _unwrap_seconds(work),
        str(Stage.RASTER): 0.1 + 5e-6 * work.texels**2,
        str(Stage.CAPTURE): _capture_seconds(work),
        str(Stage.WRITE): 1.4 + 1e-5 * work.texels**2 if paths else 0.05 + 1e-7 * work.values * work.cells,
    }
    if kind.traits.looks_at_surface:
        cells = work.covered * (PROBE_CELLS**2 * PROBES / 2 if paths else work.bucket**2)
        seconds[str(Stage.PROBE)] = 0.1 + 3e-6 * cells
    if paths:
        rays = LayeredRays.of(work.samples).of_texel
        times = LayeredTimes(work.covered, LayeredRays.of(work.samples), surroundings=work.surroundings)
        seconds[str(Stage.SURROUNDINGS)] = sum(times.around.values())
        seconds[str(Stage.FIT)] = 0.2 + work.covered * (3.4e-4 + 7e-7 * rays)
    else:
        seconds[str(Stage.FILL)] = 0.05 + 1.2e-6 * work.cells
    if work.denoise and not paths:
        seconds[str(Stage.DENOISE)] = 0.4 + 9e-6 * work.cells * work.values / 4
    if work.preview:
        seconds[str(Stage.PREVIEW)] = 0.3 + 1e-5 * work.triangles
    if work.exports:
        seconds[EXPORT] = (1.5 + 2e-4 * work.covered) * work.exports
    return {stage: seconds[stage] for stage in STAGES if stage in seconds}


def estimate(work: BakeWork, place: str, name: str, measured: Sequence[Measurement]) -> Estimate:
    """How long the `work` takes for the object `name` in the file and scene `place`.

    `measured` are all measurements of this machine, the latest last.
    """
    expected, spread = {}, {}
    for stage, typical in typical_seconds(work).items():
        ratio, spread[stage] = _ratio(stage, typical, work, place, name, measured)
        expected[stage] = typical * ratio
    basis = _basis(work, place, name, measured)
    common = _UNKNOWN_MACHINE if basis is Basis.NOTHING else _BUSY
    return Estimate(expected, basis, spread, common)


def _unwrap_seconds(work: BakeWork) -> float:
    if not work.unwrap:
        return 0.1
    if work.unwrap == Unwrap.XATLAS:
        return float(0.3 + 2.5 * (work.triangles / 16_000) ** 1.75)
    return 0.3 + (5e-5 if work.unwrap == Unwrap.BLENDER else 2.2e-4) * work.triangles


def _capture_seconds(work: BakeWork) -> float:
    kind = Kind(work.kind)
    light = kind.traits.light
    if work.by_paths:
        return 0.7 + sum(LayeredTimes(work.covered, LayeredRays.of(work.samples)).capture.values())
    if light is Light.RESPONSE:  # a render for each sun
        return 0.4 + work.bucket**2 * 0.03 + 4e-6 * work.cells * work.samples
    if light is Light.OCCLUSION:
        rays = work.samples if kind.traits.samples else CLEAR_SAMPLES
        return 0.4 + 1.6e-6 * work.cells * rays
    return 0.4 + 5e-6 * work.cells * work.samples


def _ratio(
    stage: str, typical: float, work: BakeWork, place: str, name: str, measured: Sequence[Measurement]
) -> tuple[float, float]:
    """How many times as long as typical the stage takes: a weighted geometric mean of what was measured.

    Returns the ratio, and the standard deviation of its logarithm.
    """
    logs, weights, nearest = [0.0], [_PRIOR], _UNSURE
    for age, one in enumerate(reversed(measured)):
        seconds = one.seconds.get(stage, 0.0)
        of_one = typical_seconds(one.work).get(stage, 0.0)
        if seconds < _LEAST or of_one < _LEAST:
            continue
        is_same = (one.place, one.name) == (place, name)
        if stage == Stage.UNWRAP and not is_same and seconds < _NO_UNWRAP * of_one:
            continue
        growth = typical / of_one
        weight = _weight(stage, growth, work, is_same, one)
        if weight >= _OF_ITSELF and is_same:
            certain = _OF_SAME + _BY_SIZE * abs(log(growth)) if one.finished else _OF_PROBE
            nearest = min(nearest, certain)
        logs.append(log(seconds / of_one))
        weights.append(weight * 0.5 ** (age / _HALF_LIFE))
    mean = sum(weight * value for weight, value in zip(weights, logs, strict=True)) / sum(weights)
    if nearest == _UNSURE:  # of other objects: what they differ by
        differ = sum(
            min(w, 1.0) * (value - mean) ** 2 for w, value in zip(weights[1:], logs[1:], strict=True)
        )
        count = sum(min(w, 1.0) for w in weights[1:])
        nearest = max(_LEAST_OF_OTHERS, sqrt((_OF_OTHERS**2 + differ) / (1.0 + count)) if count else _UNSURE)
        nearest *= _UNWRAPS if stage == Stage.UNWRAP else 1.0
    return exp(mean), nearest


def _weight(stage: str, growth: float, work: BakeWork, is_same: bool, one: Measurement) -> float:
    """How much a measurement counts, where the work's stage typically takes `growth` times as long.

    `is_same`: it is of the same object.
    """
    if not _same_device(work, one.work) and stage not in _ALIKE:
        return 0.0
    if stage == Stage.UNWRAP and work.unwrap != one.work.unwrap:
        return 0.0
    weight = 1.0 if _same_kind(work, one.work) or stage in _ALIKE else _OTHER_KIND
    if not one.finished:
        return weight * (_PROBED if is_same else 1.0)
    if is_same:
        weight *= _BAKED
    return weight / (1 + _FADING * log(growth) ** 2)


def _basis(work: BakeWork, place: str, name: str, measured: Iterable[Measurement]) -> Basis:
    found = Basis.NOTHING
    for one in measured:
        if not (_same_kind(work, one.work) and _same_device(work, one.work)):
            continue
        if (one.place, one.name) != (place, name):
            found = Basis.OTHERS if found is Basis.NOTHING else found
        elif one.finished:
            return Basis.BAKED
        else:
            found = Basis.MEASURED
    return found


def _same_kind(one: BakeWork, other: BakeWork) -> bool:
    return (one.kind, one.layout) == (other.kind, other.layout)


def _same_device(one: BakeWork, other: BakeWork) -> bool:
    return one.device == other.device
