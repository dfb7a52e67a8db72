# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A picture of a UV map: islands in colours, darker where texels are denser."""

from __future__ import annotations

import numpy as np

from .arrays import Floats, Ints
from .texel_map import triangle_of_texels
from .uv_map import UvMap

SIDE = 512  # pixels of a picture's longer side, by default
_EMPTY = 0.08  # display value of texels that no island covers
_AT_MEAN = 0.75  # of a colour's full brightness, where texels are as dense as on average
_DARKEST = 0.25
_FINER = 2  # rows and columns that are drawn for each pixel
_GOLDEN = (5**0.5 - 1) / 2  # turns between two hues: any number of them differ as much as they can
_SATURATION = 0.8
_BRIGHT = 0.75  # the luma of all colours
_LUMA = np.array([0.2126, 0.7152, 0.0722])


def draw_map(uv_map: UvMap, side: int = SIDE) -> Floats:
    """The atlas, its longer side `side` pixels: (H, W, 3) display values in 0..1, the top row (v = 1) first.

    Each island has one of `island_colours`, times 0.75 over how much denser texels are than on average (along
    a unit of the surface), at most 1. All hues are equally bright, so that brightness tells density alone.
    """
    longer = max(uv_map.width, uv_map.height)
    width, height = (max(round(side * size / longer), 1) for size in (uv_map.width, uv_map.height))
    triangle = triangle_of_texels(uv_map.uv, _FINER * width, _FINER * height)
    shade = np.clip(_AT_MEAN / np.maximum(uv_map.relative_density, 1e-6), _DARKEST, 1.0)
    colour = island_colours(uv_map.island) * shade[:, None]
    fine = np.where(triangle[..., None] >= 0, colour[triangle], _EMPTY)
    picture: Floats = fine.reshape(height, _FINER, width, _FINER, 3).mean(axis=(1, 3))[::-1]
    return picture


def island_colours(island: Ints) -> Floats:
    """A display colour (N, 3) in 0..1 for each of the islands' numbers (N,): hues of equal brightness."""
    hue = (np.asarray(island)[:, None] * _GOLDEN + np.array([0, 1 / 3, 2 / 3])) % 1
    colour = 1 - _SATURATION * np.clip(np.minimum(hue, 1 - hue) * 6 - 1, 0, 1)
    luma = (colour @ _LUMA)[:, None]
    white = np.clip((_BRIGHT - luma) / (1 - luma), 0, 1)
    found: Floats = (colour + white * (1 - colour)) * np.minimum(_BRIGHT / luma, 1)
    return found
