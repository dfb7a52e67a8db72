# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Texels per metre of surface: read them from text, and estimate how many texels an atlas then needs.

Also how many an atlas gets that several objects share.
"""

from __future__ import annotations

from math import ceil, inf, sqrt

from ..core.errors import InputError
from ..core.messages import Message, Setting, do

MOST_TEXELS = 4096  # along a side of an atlas whose size follows from a density
STEP = 4  # sides are multiples of it: blocks of compressed textures, and two mip levels, fit exactly

LEAST_DENSITY, MOST_DENSITY = 1e-9, 1e12  # texels per metre; what is beyond is a slip, and overflows

_PER_METRE = {"": 1.0, "m": 1.0, "cm": 100.0, "mm": 1000.0}
_BEYOND = 2**31  # texels: all that is larger is too large alike
MOST_SHARED, _SHARED_STEP = 512, 64  # texels along a side of an atlas that objects share, by default
_OF_ISLAND = 13.5 / 128  # of each object's side: the side of a square that each island needs, with padding
_USED, _APART = 0.7, 16  # what an unwrap covers of an atlas, but for the texels between islands: measured


def parse_density(text: str, called: str = "density") -> float:
    """Texels per metre in a text such as "64", "64/m", "64/cm" or "1.5/mm".

    `called` names the setting in errors. Raises InputError for what is no number above 0, and another unit.
    """
    number, slash, unit = (part.strip() for part in text.partition("/"))
    try:
        value = float(number)
    except ValueError:
        raise InputError(f"{called} {text}: give texels per metre, such as 64/m") from None
    if unit not in _PER_METRE or (slash and not unit):
        raise InputError(f"{called} {text}: give texels per m, cm or mm, such as 64/m or 1.5/mm")
    return checked_density(value * _PER_METRE[unit], f"{called} {text}")


def checked_density(density: float, said: str) -> float:
    """The density, if atlases can have it; else raises InputError, whose text begins with `said`."""
    if not 0 < density < inf:
        raise InputError(f"{said}: give texels per metre above 0, such as 64/m")
    if not LEAST_DENSITY <= density <= MOST_DENSITY:
        raise InputError(
            f"{said}: give from {LEAST_DENSITY:g} to {MOST_DENSITY:g} texels per metre, such as 64/m"
        )
    return density


def told_density(density: float) -> str:
    """A density in words, such as "64 texels per metre"."""
    return f"{density:.4g} texels per metre"


def capped_warning(
    whose: str, density: float, needed: int, most: int, reached: float | None = None
) -> Message:
    """The warning about an atlas that would need about `needed` texels along a side, and has the `most`.

    `reached` is the density that it has; None before the bake.
    """
    got = told_density(reached or density * most / needed)
    return Message(
        f"{whose} would need about {needed} texels along a side for {told_density(density)}; {most} is the "
        f"most, which gives it {got if reached else f'about {got}'}",
        (do("ask for fewer", Setting.DENSITY),),
    )


def side_for(area: float, density: float, covered: float) -> int:
    """Texels along the side of a square atlas in which `area` square metres cover a share of `covered`."""
    side = density * sqrt(area / covered)
    return max(round(side), 1) if side < _BEYOND else _BEYOND


def about_side(area: float, density: float) -> int:
    """About how many texels are along the longer side of an atlas of `area` square metres, not yet unwrapped.

    Within 12 % for most meshes; hundreds of small sheets need up to twice as many: see docs/unwrap.md.
    """
    return rounded(min(side_for(area, density, _USED) + _APART, _BEYOND))


def side_for_several(side: int, count: int, islands: int = 0) -> int:
    """Texels along the side of an atlas that `count` objects share, of which each had `side` by itself.

    About as many in all, and more where their own UV layers have hundreds of `islands`, or the room between
    these takes most of the atlas: a multiple of 64, and at most 512 if `side` is not larger.
    """
    needed = max(side * sqrt(count), side_for_islands(islands, side))
    return max(side, min(_SHARED_STEP * ceil(needed / _SHARED_STEP), MOST_SHARED))


def side_for_islands(islands: int, side: int = 128) -> float:
    """Texels along the side of an atlas with room for so many islands of objects of `side` texels each."""
    return side * _OF_ISLAND * sqrt(islands)


def density_of_side(area: float, side: int) -> float:
    """About which density an atlas of `side` texels has for a surface of `area`: inverse of `about_side`."""
    return max(side - _APART, side / 2) * sqrt(_USED / area)


def grown_side(side: int, factor: float) -> int:
    """About how many texels a side of so many needs for a density that is `factor` times as high."""
    apart = min(_APART, side // 2)
    return ceil(min(apart + (side - apart) * factor, _BEYOND))


def rounded(side: int) -> int:
    """The next multiple of `STEP` that is not less."""
    return -(-max(side, 1) // STEP) * STEP
