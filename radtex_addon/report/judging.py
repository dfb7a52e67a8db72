# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Compare a bake with its references: pictures, figures, and a verdict in words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ..core.arrays import Ints
from ..core.errors import InputError
from ..core.messages import Setting, do
from .finished_bake import Finished
from .gbuffer import Array, BakedSurface, eroded
from .metrics import Figures, Mask, Picture, compare
from .shared_atlas import Parts
from .through import Shown, light_along
from .views import TracedView, seen

_WORDS = (  # the least PSNR in decibels, and its verdict
    (40.0, "the eye finds no difference"),
    (35.0, "hard to tell apart, even side by side"),
    (30.0, "close: differences show where one looks for them"),
    (25.0, "near, but reflections or textures differ at first sight"),
    (20.0, "the right light, but clearly blurred or noisy"),
    (-np.inf, "far off, for it is too blurred or too noisy to stand in for the object"),
)
FEWEST = 30  # pixels of a part in a view, or it is not judged there
_AT_THE_FLOOR = 1.0  # decibels: a PSNR this close to the noise floor's cannot be told from it


@dataclass(frozen=True, eq=False)
class Judged:
    """A picture of the bake from one view, valid inside the masks only, and its figures.

    `parts` are the figures of those of several objects of which enough is seen.
    """

    view: TracedView
    picture: Picture
    inside: Mask
    eroded: Mask
    figures: Figures
    parts: Mapping[str, Figures] = field(default_factory=dict)


@dataclass(frozen=True)
class PartFigures:
    """The mean figures of one of several objects over the views that show it, and its `psnr` in each."""

    mean: Figures
    psnr: Mapping[str, float]


def judge(
    bake: Finished, surface: BakedSurface, views: Sequence[TracedView], parts: Parts | None = None
) -> list[Judged]:
    """Compare the bake with each view's reference, and the `parts` of several objects by themselves.

    Raises InputError if it is too small in a view.
    """
    judged = []
    for view in views:
        if parts is not None:
            judged.append(_judge_parts(bake, surface, view, parts))
            continue
        buffer = seen(surface, view)
        inside, inner = buffer.inside, buffer.eroded
        if not inner.any():
            raise _too_small()
        picture = buffer.resolve(bake.radiance(buffer))
        figures = compare(picture, view.reference, inside, inner)
        judged.append(Judged(view, picture, inside, inner, figures))
    return judged


def _judge_parts(bake: Finished, surface: BakedSurface, view: TracedView, parts: Parts) -> Judged:
    """As `judge`, with what clear parts show of others behind them."""
    found = light_along([Shown(surface, bake)], view.rays, view.blocked)
    met = np.where(found.first >= 0, parts.owner[found.triangle], -1)
    picture, owner = resolved(found.light, met, view.rays.pixels)
    inside = (owner >= 0).all(axis=2)
    whole = eroded(inside)
    if not whole.any():
        raise _too_small()
    masks = {name: (owner == number).all(axis=2) for number, name in enumerate(parts.names)}
    figures = {
        name: compare(picture, view.reference, mask, mask & whole)
        for name, mask in masks.items()
        if (mask & whole).sum() >= FEWEST
    }
    return Judged(view, picture, inside, whole, compare(picture, view.reference, inside, whole), figures)


def resolved(light: Array, owner: Ints, pixels: int) -> tuple[Picture, Ints]:
    """The picture (H, W, 3) of light (N, 3) along a view's rays, and the owners (H, W, S) of its subsamples.

    A pixel is the mean of those of its rays that have an owner: -1 is none.
    """
    whose: Ints = owner.reshape(pixels, pixels, -1)
    covered = (whose >= 0)[..., None]
    total = np.where(covered, light.reshape(pixels, pixels, -1, 3), 0).sum(axis=2)
    picture: Picture = total / np.maximum(covered.sum(axis=2), 1)
    return picture, whose


def part_figures(judged: Sequence[Judged]) -> dict[str, PartFigures]:
    """The figures of several objects, the worst first; none of a single one."""
    found: dict[str, dict[str, Figures]] = {}
    for one in judged:
        for name, figures in one.parts.items():
            found.setdefault(name, {})[one.view.name] = figures
    made = {
        name: PartFigures(_mean(list(each.values())), {view: one.psnr for view, one in each.items()})
        for name, each in found.items()
    }
    return dict(sorted(made.items(), key=lambda part: part[1].mean.psnr))


def _mean(figures: Sequence[Figures]) -> Figures:
    """The means of each figure, of those that have it."""

    def of(values: list[float | None]) -> float | None:
        known = [value for value in values if value is not None]
        return float(np.mean(known)) if known else None

    return Figures(
        psnr=float(np.mean([one.psnr for one in figures])),
        psnr_uneroded=float(np.mean([one.psnr_uneroded for one in figures])),
        flip=of([one.flip for one in figures]),
        energy=float(np.mean([one.energy for one in figures])),
        glints=of([one.glints for one in figures]),
    )


def _too_small() -> InputError:
    return InputError(
        "the object covers no whole pixel of a view", do("give the report more pixels", Setting.PIXELS)
    )


def noise_floor(judged: Sequence[Judged]) -> Figures:
    """The figures of the first view's reference, rendered again with another seed."""
    first = judged[0]
    assert first.view.repetition is not None  # the first view has one
    return compare(first.view.repetition, first.view.reference, first.inside, first.eroded)


def mean_psnr(judged: Sequence[Judged]) -> float:
    """The mean PSNR of the views, in decibels."""
    return float(np.mean([one.figures.psnr for one in judged]))


def mean_energy(judged: Sequence[Judged]) -> float:
    """The mean over the views of the radiance divided by the reference's."""
    return float(np.mean([one.figures.energy for one in judged]))


def mean_glints(judged: Sequence[Judged]) -> float | None:
    """The mean of `Figures.glints` over the views that have glints, None if none has."""
    found = [one.figures.glints for one in judged if one.figures.glints is not None]
    return float(np.mean(found)) if found else None


def mean_flip(judged: Sequence[Judged]) -> float | None:
    """The mean FLIP of the views, None if it is not available."""
    found = [one.figures.flip for one in judged if one.figures.flip is not None]
    return float(np.mean(found)) if found else None


def verdict(name: str, judged: Sequence[Judged], floor: Figures) -> str:
    """One sentence on how close the bake is to path tracing."""
    decibels = mean_psnr(judged)
    if decibels >= floor.psnr - _AT_THE_FLOOR:
        words = "as close as the path-traced pictures are to themselves"
    else:
        words = next(words for least, words in _WORDS if decibels >= least)
    return f"{name} as baked is {decibels:.1f} dB from path tracing: {words}."
