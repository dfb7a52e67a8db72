# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""More samples for a layered bake that is there.

What is known of materials and surroundings stays as it is. Light is captured anew, in other directions, and
fitted to the same lobes; the light that is kept is then the mean of both fits, by their samples.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from ...bake.spec import BakeSpec
from ...core.arrays import Floats
from ...core.errors import InputError
from ...formats.sidecar import Sidecar
from ..buckets.previous_atlas import difference
from .files.layered_files import read_layered
from .fit.known import Known
from .lookup.atlas import LayeredAtlas

_SEEDS = 2**31
_SEED_STEP = 7919  # for each sample that is there


def seeded_anew(spec: BakeSpec, samples: int) -> BakeSpec:
    """The same with a seed of its own, for paths other than those of a bake of so many `samples`."""
    return replace(spec, seed=(spec.seed + _SEED_STEP * samples) % _SEEDS)


def merged(known: Known, more: LayeredAtlas) -> LayeredAtlas:
    """The atlas that is there with the mean of its light and that of `more` samples, by their number."""
    atlas = known.atlas

    def mean(earlier: Floats, new: Floats) -> Floats:
        return earlier + known.share * (new - earlier)

    through = atlas.through
    if through is not None and more.through is not None:
        through = replace(through, rest=mean(through.rest, more.through.rest))
    return replace(
        atlas,
        irradiance=mean(atlas.irradiance, more.irradiance),
        own=mean(atlas.own, more.own),
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
