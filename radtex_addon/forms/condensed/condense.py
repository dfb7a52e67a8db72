# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Condense a bake to a budget in bytes, or to a target in dB."""

from __future__ import annotations

import logging
from collections.abc import Generator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeAlias, TypeVar

from ...bake.agreement import agreement
from ...bake.condense import condense
from ...bake.plan import CapturePlan
from ...bake.progress import Progress, Stage, relayed
from ...bake.spec import BakeSpec
from ...core.arrays import Floats
from ...core.errors import InputError
from ...core.shared import Axis, SharedAtlas, level_count
from ...formats.condensed_files import stored_colour
from ...formats.condensed_sizes import CondensedSizes, clusters_within, condensed_bytes, texture_bytes
from ...formats.disk.atomic import replacing_together
from ...formats.disk.memory import readable_size
from ...formats.shared_files import read_shared, writing_condensed
from ...formats.shared_sidecar import SharedSidecar
from ...formats.sidecar import Sidecar
from ..outcome import Condensed

_log = logging.getLogger(__name__)

_COLOUR_SHARE = 0.35  # largest share of a budget for the colour
_SURROUNDINGS_SHARE = 0.2
_LEAST_SURROUNDINGS = 64  # cells along their side
_FEWEST = 8  # clusters of a lobe: with fewer nothing can be recognised
_FIRST = 16  # clusters of the first try for a target; each further try doubles them


_Step = TypeVar("_Step")
_Steps: TypeAlias = Generator[_Step, None, tuple[SharedSidecar, Condensed]]


def check_budget(spec: BakeSpec, width: int, height: int) -> None:
    """Raise InputError for a budget too small for `width` x `height` texels, even if all have one colour."""
    if spec.budget is not None:
        check_bytes(spec.budget, spec.bucket, width, height)


def check_bytes(budget: int, bucket: int, width: int, height: int) -> None:
    """As `check_budget`, for a `budget` in bytes and `bucket` cells along a bucket's side."""
    side = _LEAST_SURROUNDINGS
    least = CondensedSizes(
        width=width,
        height=height,
        bucket=bucket,
        colour=(4, 4),
        surroundings=side,
        levels=level_count(side),
        clusters={Axis.MIRROR: _FEWEST},
    )
    needed = condensed_bytes(least)
    if needed > budget:
        raise InputError(
            f"budget {readable_size(budget)}: {width} x {height} texels take "
            f"{readable_size(needed)} at least; give more, or fewer texels"
        )


def condense_steps(
    path: Path, atlas: SharedAtlas, plan: CapturePlan, spec: BakeSpec, facts: Sidecar
) -> _Steps[Progress]:
    """Condense the atlas for the budget or target of `spec`; write the sidecar to `path`, textures beside it.

    Existing files are replaced only at the end; a generator closed before that leaves them unchanged.
    """
    with replacing_together(path) as beside:
        making = _Making(beside, atlas, plan, facts)
        if spec.budget is not None:
            return (yield from _within_budget(making, spec.budget))
        assert spec.target is not None  # either a budget or a target is given
        return (yield from _to_target(making, spec.target))


@dataclass(frozen=True, eq=False)
class _Making:
    """Tries to condense the `fitted` atlas; each try replaces the files at `path`."""

    path: Path
    fitted: SharedAtlas
    plan: CapturePlan
    facts: Sidecar

    def of(self, small: SharedAtlas, count: int, progress: Progress) -> _Steps[Progress]:
        """Write `small` in `count` clusters and compare it with the fitted atlas; yields only `progress`."""
        return relayed(self._steps(small, count), lambda _: progress)

    def _steps(self, small: SharedAtlas, count: int) -> _Steps[str | None]:
        yield None
        condensed = yield from condense(small, self.plan, count)
        yield from writing_condensed(self.path, condensed, self.facts)
        stored, sidecar = read_shared(self.path)
        assert sidecar.condensed is not None  # it was just written
        near = yield from agreement(stored, self.fitted, self.plan)
        return sidecar, Condensed(
            clusters=tuple(tiles.clusters for tiles in sidecar.condensed.lobes.values()),
            colour=sidecar.colour,
            surroundings=sidecar.surroundings,
            bytes=texture_bytes(sidecar.shapes),
            agreement=near,
        )


def _within_budget(making: _Making, budget: int) -> _Steps[Progress]:
    small = _reduced(making.fitted, budget)
    count = min(max(clusters_within(budget, _sizes(small)), _FEWEST), len(making.plan.texel))
    sidecar, found = yield from making.of(small, count, Progress(Stage.CONDENSE, 0, 1))
    if found.bytes > budget:
        _log.warning(
            "budget %s: the textures of object '%s' take %s at least; give more, or fewer texels",
            readable_size(budget),
            making.facts.object_name,
            readable_size(found.bytes),
        )
    return sidecar, found


def _to_target(making: _Making, target: float) -> _Steps[Progress]:
    atlas = making.fitted
    most = min(len(making.plan.texel), clusters_within(2**40, _sizes(atlas)))
    count, tries = min(_FIRST, most), 0
    while True:
        step = Progress(Stage.CONDENSE, tries, tries + 1)
        sidecar, found = yield from making.of(atlas, count, step)
        if found.agreement >= target or count == most or not atlas.lobes:
            break
        count, tries = min(2 * count, most), tries + 1
    if found.agreement < target:
        _log.warning(
            "target %g dB: condensed textures of object '%s' come to %.1f dB; bake it without a target "
            "for all of it",
            target,
            making.facts.object_name,
            found.agreement,
        )
    return sidecar, found


def _reduced(atlas: SharedAtlas, budget: int) -> SharedAtlas:
    """Reduce the atlas's colour and surroundings, so that most of the budget is left for the lobes."""
    width = atlas.irradiance.shape[1]
    while atlas.colour.shape[1] >= 2 * width and _cost_of(atlas, "colour") > _COLOUR_SHARE * budget:
        atlas = replace(atlas, colour=_halved(atlas.colour))
    while (
        len(atlas.surroundings[0]) >= 2 * _LEAST_SURROUNDINGS
        and _cost_of(atlas, "surroundings") > _SURROUNDINGS_SHARE * budget
    ):
        atlas = replace(atlas, surroundings=atlas.surroundings[1:], sharpest=4 * atlas.sharpest)
    return atlas


def _cost_of(atlas: SharedAtlas, layer: str) -> int:
    """Bytes on a GPU of a texture without clusters, such as "colour"."""
    sizes = _sizes(atlas)
    return texture_bytes({layer: sizes.shapes(sizes.columns)[layer]})


def _halved(image: Floats) -> Floats:
    """The means of 2 x 2 pixels; an odd last row or column is dropped."""
    height, width = image.shape[0] // 2, image.shape[1] // 2
    means: Floats = image[: 2 * height, : 2 * width].reshape(height, 2, width, 2, -1).mean(axis=(1, 3))
    return means


def _sizes(atlas: SharedAtlas) -> CondensedSizes:
    """Sizes of the stored atlas with one cluster per lobe; a colour that is the same everywhere is tiny."""
    height, width = atlas.irradiance.shape[:2]
    colour = stored_colour(atlas.colour)
    return CondensedSizes(
        width=width,
        height=height,
        bucket=atlas.lobes[0].ends.shape[2] if atlas.lobes else 1,
        colour=(colour.shape[1], colour.shape[0]),
        surroundings=len(atlas.surroundings[0]),
        levels=len(atlas.surroundings),
        clusters={lobe.axis: 1 for lobe in atlas.lobes},
    )
