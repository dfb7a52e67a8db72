# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Compare a bake with its references: pictures, figures, and a verdict in words."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..core.errors import InputError
from ..core.messages import Setting, do
from .finished_bake import Finished
from .gbuffer import BakedSurface
from .metrics import Figures, Mask, Picture, compare
from .views import TracedView, seen

_WORDS = (  # the least PSNR in decibels, and its verdict
    (40.0, "the eye finds no difference"),
    (35.0, "hard to tell apart, even side by side"),
    (30.0, "close: differences show where one looks for them"),
    (25.0, "near, but reflections or textures differ at first sight"),
    (20.0, "the right light, but clearly blurred or noisy"),
    (-np.inf, "far off, for it is too blurred or too noisy to stand in for the object"),
)
_AT_THE_FLOOR = 1.0  # decibels: a PSNR this close to the noise floor's cannot be told from it


@dataclass(frozen=True, eq=False)
class Judged:
    """A picture of the bake from one view, valid inside the masks only, and its figures."""

    view: TracedView
    picture: Picture
    inside: Mask
    eroded: Mask
    figures: Figures


def judge(bake: Finished, surface: BakedSurface, views: Sequence[TracedView]) -> list[Judged]:
    """Compare the bake with each view's reference. Raises InputError if it is too small in a view."""
    judged = []
    for view in views:
        buffer = seen(surface, view)
        inside, eroded = buffer.inside, buffer.eroded
        if not eroded.any():
            raise InputError(
                "the object covers no whole pixel of a view",
                do("give the report more pixels", Setting.PIXELS),
            )
        picture = buffer.resolve(bake.radiance(buffer))
        figures = compare(picture, view.reference, inside, eroded)
        judged.append(Judged(view, picture, inside, eroded, figures))
    return judged


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
