# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Measure a small part of a bake in some seconds, to estimate how long all of it takes (`settings.estimate`).

The object is evaluated and unwrapped as in the bake. Then a small atlas on the same UV map is baked, as far
as its files, with as many paths for each texel as the bake has. Nothing is written.
"""

from __future__ import annotations

from collections.abc import Generator, Mapping
from dataclasses import asdict, dataclass, replace
from math import sqrt
from time import perf_counter
from typing import Any, cast

import bpy

from ..bake.piece_store import MemoryStore
from ..bake.progress import Progress, Stage, Stopwatch, finished
from ..formats.disk.temporary import temporary_folder
from ..forms import form_for
from ..forms.bake_job import BakeJob
from ..forms.outcome import Outcome
from ..prepare.prepared import Prepared
from ..scene.scratch import at_frame, new_data_removed
from ..settings.estimate import BakeWork, Measurement
from ..settings.spec import BakeSpec, Unwrap
from ..store.output_files import OutputFiles
from .baking import bake_unchecked
from .split_parts import check_part

_UNWRAP_SECONDS = 3.0  # at most; then the small atlas gets a quick unwrap, and the true one's time is guessed
_PATHS = 200_000  # of a probe
_LEAST_SIDE, _MOST_SIDE = 12, 64  # texels of the small atlas
_QUICK_SIDE = 1024  # texels at least for a quick unwrap
_SURROUNDINGS = 0.25  # width of the pictures of what surrounds the object
_PREPARED = frozenset(map(str, (Stage.EVALUATE, Stage.UNWRAP, Stage.RASTER)))


@dataclass(frozen=True)
class Probe:
    """What a probe found: the texels that the atlas will have, and cover, the `triangles`, and the times.

    `whole` are the seconds of the stages that were measured as they are in the bake, `part` those of the
    small atlas, whose work is `small`.
    """

    texels: int
    covered: int
    triangles: int
    whole: dict[str, float]
    small: BakeWork
    part: dict[str, float]

    def measurements(self, place: str, name: str, spec: BakeSpec) -> tuple[Measurement, ...]:
        """Both measurements, for `settings.estimate.estimate`."""
        work = self.work(spec, preview=False)
        return (
            Measurement(place, name, work, self.whole, finished=False),
            Measurement(place, name, self.small, self.part, finished=False),
        )

    def work(self, spec: BakeSpec, preview: bool) -> BakeWork:
        """The work of the whole bake."""
        return BakeWork.of(
            spec,
            self.triangles,
            covered=self.covered,
            texels=self.texels,
            preview=preview,
            device=self.small.device,
        )

    def told(self) -> dict[str, Any]:
        """The probe as JSON's types."""
        return asdict(self)

    @classmethod
    def of(cls, told: Mapping[str, Any]) -> Probe:
        """Inverse of `told`."""
        return cls(**{**told, "small": BakeWork(**told["small"])})


def probe_object(scene: bpy.types.Scene, name: str, spec: BakeSpec, view_layer: str | None = None) -> Probe:
    """Measure a bake; see `probe_steps`."""
    return finished(probe_steps(scene, name, spec, view_layer))


def probe_steps(
    scene: bpy.types.Scene, name: str, spec: BakeSpec, view_layer: str | None = None
) -> Generator[Progress, None, Probe]:
    """Measure a bake of the object `name`, or of `spec.objects`. Yields progress; the scene is unchanged.

    Of a bake that adds to an atlas, or changes some of its texels, the time of a whole one is measured.
    Raises InputError and BakeError as `bake_steps`.
    """
    spec = replace(spec, accumulate=False, refresh=False, where=None)
    check_part(name, spec)
    probing = _Probing(scene, name, spec, view_layer)
    try:
        yield from probing.steps(spec, _UNWRAP_SECONDS)
    except _SlowUnwrapError:
        yield from probing.steps(_quickly_unwrapped(spec), None)
        probing.whole.pop(str(Stage.UNWRAP), None)
        return probing.result(spec.texels)
    return probing.result()


def _quickly_unwrapped(spec: BakeSpec) -> BakeSpec:
    """The specification with a quick unwrap, whose many islands need many texels."""
    texels = max(spec.texels, min(_QUICK_SIDE, spec.most_texels))
    return replace(spec, unwrap=Unwrap.BLENDER, texels=texels, density=None, padding=0)


class _SlowUnwrapError(Exception):
    """The unwrap takes longer than a probe may."""


class _DoneError(Exception):
    """All that a probe measures was measured."""


class _Probing:
    """A probe of one bake."""

    def __init__(self, scene: bpy.types.Scene, name: str, spec: BakeSpec, view_layer: str | None) -> None:
        self._scene, self._name, self._spec, self._layer = scene, name, spec, view_layer
        self.whole: dict[str, float] = {}
        self._part = Stopwatch()
        self._found: tuple[int, int, int] = (0, 0, 0)  # texels, covered ones, triangles
        self._small: BakeWork | None = None

    def result(self, texels: int | None = None) -> Probe:
        """What was found; with `texels` as for an atlas with so many along its longer side."""
        assert self._small is not None  # `steps` has run to its end
        self._part.seconds.pop(Stage.WRITE, None)
        part = {str(stage): seconds for stage, seconds in self._part.seconds.items()}
        side, covered, triangles = self._found
        if texels is not None:
            side, covered = texels, max(1, round(covered * (texels / side) ** 2))
        return Probe(side, covered, triangles, self.whole, self._small, part)

    def steps(self, spec: BakeSpec, limit: float | None) -> Generator[Progress, None, None]:
        """Prepare the object, in `limit` seconds, and bake the small atlas. Raises _SlowUnwrapError."""
        watch = Stopwatch()
        with temporary_folder() as folder, at_frame(self._scene, spec.frame), new_data_removed():
            files = OutputFiles.of(self._name, spec, folder, preview=False)
            steps = bake_unchecked(
                self._scene, self._name, spec, files, self._layer, watch, baker=self._bake, warns=False
            )
            since: float | None = None
            try:
                for step in steps:
                    if step.stage is Stage.UNWRAP and limit is not None:
                        since = perf_counter() if since is None else since
                        if perf_counter() - since > limit:
                            raise _SlowUnwrapError
                    yield step
            except _DoneError:
                pass
            finally:
                steps.close()
        watch.stop()
        self._part.stop()
        measured = {str(stage): seconds for stage, seconds in watch.seconds.items()}
        self.whole = {stage: seconds for stage, seconds in measured.items() if stage in _PREPARED}

    def _bake(self, job: BakeJob) -> Generator[Progress, None, Outcome]:
        """Bake a small atlas of the prepared objects, without its files. Raises _DoneError at the end."""
        yield Progress(Stage.RASTER, 0, 1)
        prepared, spec = job.prepared, job.spec
        covered = int(prepared.texels().covered.sum())
        side = max(prepared.width, prepared.height)
        self._found = side, max(covered, 1), len(prepared.surface.triangles)
        texels, small_spec = _small(spec, side)
        small = _resized(prepared, texels)
        small_covered = max(int(small.texels().covered.sum()), 1)
        work = BakeWork.of(
            small_spec, self._found[2], covered=small_covered, device=_device_of(job.scratch, spec.device)
        )
        self._small = replace(work, surroundings=_SURROUNDINGS)
        smaller = replace(
            job, spec=small_spec, prepared=small, store=MemoryStore(), surroundings=_SURROUNDINGS
        )
        yield Progress(Stage.PROBE, 0, 1)
        for step in self._part.over(form_for(spec).bake(smaller)):
            if step.stage is Stage.WRITE:
                break
            yield step
        raise _DoneError


def _small(spec: BakeSpec, side: int) -> tuple[int, BakeSpec]:
    """The small atlas's texels along its longer side, and its specification: each texel as in the bake.

    Where that would take too many paths, with fewer samples.
    """
    of_texel = _paths_of_texel(spec)
    texels = round(sqrt(_PATHS / of_texel))  # islands cover nearly all of a small atlas
    texels = min(side, max(_LEAST_SIDE, min(texels, _MOST_SIDE)))
    share = _PATHS / (of_texel * texels**2)
    samples = spec.samples if share >= 1 else max(1, round(spec.samples * share))
    padding = min(spec.padding, max(texels // 8, 0))
    return texels, replace(
        spec, texels=texels, density=None, padding=padding, samples=samples, memory_mb=None
    )


def _paths_of_texel(spec: BakeSpec) -> int:
    if spec.form.by_paths:
        return spec.layered_rays.of_texel
    return max(1, spec.path_count // spec.texels**2)


def _resized(prepared: Prepared, texels: int) -> Prepared:
    """The same objects and UV map on an atlas with so many `texels` along its longer side."""
    scale = texels / max(prepared.width, prepared.height)
    width, height = (max(1, round(scale * size)) for size in (prepared.width, prepared.height))
    small = replace(prepared, width=width, height=height)
    if prepared.source is None or prepared.detailed is None:
        return small
    own = replace(small, source=None, detailed=None).texels()
    return replace(small, source=finished(prepared.detailed.project(prepared.surface, own)))


def _device_of(scratch: bpy.types.Scene, asked: str) -> str:
    """The name of the device that renders, as `use_device` yields it."""
    if cast(Any, scratch).cycles.device == "CPU":
        return "cpu"
    preferences = bpy.context.preferences.addons["cycles"].preferences
    return str(preferences.compute_device_type).lower() if asked == "auto" else asked
