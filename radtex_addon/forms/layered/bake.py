# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bake the layered layout: capture, fit, and write it as several images; or add samples to such a bake.

Then what is known of materials and surroundings stays as it is. Light is captured anew, in other directions,
and fitted to the same lobes; the light that is kept is the mean of both fits, by their samples.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np

from ...bake.progress import Progress, Stage
from ...core.arrays import Floats
from ...core.atlas import AtlasLayout
from ...core.errors import BakeError, InputError
from ...core.large_arrays import arrays_in_files
from ...core.messages import Setting, do
from ...formats.disk.atomic import refusal
from ...formats.disk.temporary import hidden_folder
from ...formats.image_files import layer_path
from ...formats.sidecar import Sidecar
from ...settings.spec import BakeSpec
from ..bake_job import BakeJob
from ..buckets.previous_atlas import difference
from ..outcome import Outcome
from .capture.capturing import capture_layered, material_count
from .capture.image_looks import image_looks
from .files.layered_files import read_layered, write_layered
from .files.sidecar import MOST_MATERIALS
from .fit.fitting import fit_layered
from .fit.known import Known
from .lookup.atlas import LayeredAtlas

_SEEDS = 2**31
_HIDDEN = 1e-3  # of what lies around, below which own light counts as none
_SEED_STEP = 7919  # for each sample that is there


def seeded_anew(spec: BakeSpec, samples: int) -> BakeSpec:
    """The same with a seed of its own, for paths other than those of a bake of so many `samples`."""
    return replace(spec, seed=(spec.seed + _SEED_STEP * samples) % _SEEDS)


def merged(known: Known, more: LayeredAtlas) -> LayeredAtlas:
    """The atlas that is there with the mean of its light and that of `more` samples, by their number."""
    atlas = known.atlas

    def mean(earlier: Floats, new: Floats) -> Floats:
        return earlier + known.share * (new - earlier)

    own = mean(atlas.own, more.own)
    hidden = mean(1 - atlas.own[..., 3:], 1 - more.own[..., 3:])  # own light is not premultiplied by that
    seen = mean(*(one[..., :3] * (1 - one[..., 3:]) for one in (atlas.own, more.own)))
    np.divide(seen, hidden, out=own[..., :3], where=hidden > _HIDDEN)
    through = atlas.through
    if through is not None and more.through is not None:
        through = replace(through, rest=mean(through.rest, more.through.rest))
    return replace(
        atlas,
        irradiance=mean(atlas.irradiance, more.irradiance),
        own=own,
        rest=mean(atlas.rest, more.rest),
        through=through,
    )


def read_earlier(sidecar: Path, bake: Sidecar, materials: int) -> tuple[LayeredAtlas, int]:
    """Read the bake with this `sidecar`, to which a `bake` of an object of so many `materials` adds samples.

    Returns its atlas and the number of its samples. Raises InputError if it is of another mesh or size, or
    has other materials, FormatError as `read_layered`.
    """
    atlas, facts = read_layered(sidecar)
    differs = difference(replace(facts.bake, layers=()), bake)
    if differs is None and len(atlas.materials) < materials:
        differs = f"has {len(atlas.materials)} materials, the object {materials}"
    if differs is not None:
        raise InputError(f"{sidecar} {differs}: accumulate onto a bake of its own, or bake anew")
    return atlas, facts.bake.samples


def bake_layered(job: BakeJob) -> Generator[Progress, None, Outcome]:
    """As `Form.bake`; every finished capture is stored."""
    with arrays_kept(job):
        return (yield from _bake(job))


@contextmanager
def arrays_kept(job: BakeJob) -> Iterator[None]:
    """Keep large arrays in files in the job's folder for them, where not all fits into memory.

    Raises BakeError where the disk refuses.
    """
    if not job.spec.array_bytes:
        yield
        return
    with ExitStack() as files:
        try:
            folder = files.enter_context(hidden_folder(job.arrays or job.sidecar.parent))
        except OSError as error:
            raise BakeError(refusal(job.sidecar, error)) from error
        files.enter_context(arrays_in_files(folder))
        yield


def _bake(job: BakeJob) -> Generator[Progress, None, Outcome]:
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
    looks = image_looks(prepared, captured.capture, captured.triangle)
    atlas = yield from fit_layered(captured.capture, known=known, imaged=[look is not None for look in looks])
    if known is not None:
        atlas = merged(known, atlas)
    atlas = replace(atlas, looks=looks)
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
