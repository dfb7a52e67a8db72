# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of a bake's UV map: the map itself, and a checker of its texels on the object."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..core.arrays import Floats
from ..core.uv_map import UvMap, draw_map, island_colours
from ..prepare.map_checks import why_wasteful
from .gbuffer import BakedSurface, GBuffer
from .views import TracedView, seen

_SQUARES = 32  # about so many along the atlas's longer side
_DARK = 0.4  # of a colour, in every other square
_SIDEWAYS = 0.5  # how bright a surface is that is seen edge-on; 1 if seen straight from above


@dataclass(frozen=True, eq=False)
class MapPictures:
    """A bake's UV map in figures and pictures of display values, the top row first.

    `picture` (H, W, 3) is the map. `checkers` (P, P, 4) show the object with `square` x `square` texels to a
    square, each island in its colour of the map; alpha is how much of a pixel it covers. `density` is in
    texels along a unit, `wasteful` why the map wastes its atlas, "" if it does not.
    """

    picture: Floats
    checkers: tuple[Floats, ...]
    square: int
    islands: int
    coverage: float
    density: float
    wasteful: str


def map_pictures(surface: BakedSurface, views: Sequence[TracedView], width: int, height: int) -> MapPictures:
    """Draw the map of a surface on an atlas of `width` x `height` texels, and its checker in each view."""
    uv_map = surface.uv_map(width, height)
    square = square_for(max(width, height))
    colours = island_colours(uv_map.island)
    return MapPictures(
        picture=draw_map(uv_map),
        checkers=tuple(_checker(seen(surface, _coarser(view)), uv_map, colours, square) for view in views),
        square=square,
        islands=uv_map.islands,
        coverage=uv_map.coverage,
        density=uv_map.density,
        wasteful=why_wasteful(uv_map),
    )


def square_for(texels: int) -> int:
    """The side of a checker's square, a power of two, for an atlas of so many texels along a side."""
    return int(2 ** max(round(np.log2(texels / _SQUARES)), 0))


def _coarser(view: TracedView) -> TracedView:
    """The view with a quarter of its rays, which are enough for squares, if it has several to a pixel."""
    rays = view.rays
    if rays.subsamples % 2:
        return view
    every = np.arange(len(rays.away)).reshape(-1, rays.subsamples, rays.subsamples)
    some = every[:, ::2, ::2].ravel()
    coarser = replace(rays, subsamples=rays.subsamples // 2, away=rays.away[some])
    return replace(view, rays=coarser, blocked=view.blocked[some])


def _checker(buffer: GBuffer, uv_map: UvMap, colours: Floats, square: int) -> Floats:
    texel = buffer.uv * [uv_map.width, uv_map.height]
    odd = np.floor(texel / square).sum(axis=1) % 2
    facing = np.abs(np.einsum("ki,ki->k", buffer.normal, buffer.incoming))
    bright = np.where(odd, _DARK, 1.0) * (_SIDEWAYS + (1 - _SIDEWAYS) * facing)
    shown = buffer.resolve(colours[buffer.triangle] * bright[:, None])
    alpha = buffer.hit.reshape(*shown.shape[:2], -1).mean(axis=2)
    return np.dstack([shown, alpha])
