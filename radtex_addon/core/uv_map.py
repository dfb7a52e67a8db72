# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A UV map on its atlas: its islands, how dense texels are, how much it wastes; and a picture of it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .arrays import Floats, Ints
from .islands import border_edges, signed_areas, surface_areas, triangle_islands, uv_corners, weld
from .surface import SurfaceMesh, stretches
from .texel_map import triangle_of_texels

SIDE = 512  # pixels of a picture's longer side, by default
_EMPTY = 0.08  # display value of texels that no island covers
_AT_MEAN = 0.75  # of a colour's full brightness, where texels are as dense as on average
_DARKEST = 0.25
_FINER = 2  # rows and columns that are drawn for each pixel
_GOLDEN = (5**0.5 - 1) / 2  # turns between two hues: any number of them differ as much as they can
_SATURATION = 0.8
_BRIGHT = 0.75  # the luma of all colours
_LUMA = np.array([0.2126, 0.7152, 0.0722])
_NOTHING = 1e-30  # areas below count as 0


@dataclass(frozen=True, eq=False)
class UvMap:
    """Triangles with corners (F, 3, 3) in space at `uv` (F, 3, 2) of an atlas of `width` x `height` texels.

    Vertices in the same place count as one.
    """

    corners: Floats
    uv: Floats
    width: int
    height: int

    @classmethod
    def of_surface(cls, surface: SurfaceMesh, width: int, height: int) -> UvMap:
        """The map of a baked surface, in world space."""
        return cls(surface.corner_position, surface.uv, width, height)

    @cached_property
    def in_texels(self) -> Floats:
        """The UV coordinates in texels: (F, 3, 2) float64."""
        scaled: Floats = self.uv.astype(np.float64) * [self.width, self.height]
        return scaled

    @cached_property
    def _joined(self) -> Ints:
        """Corner numbers (F, 3), equal where triangles are joined in the map."""
        return uv_corners(weld(self.corners.reshape(-1, 3)).reshape(-1, 3), self.uv)

    @cached_property
    def island(self) -> Ints:
        """The island of each triangle: (F,) labels 0, 1, … without gaps."""
        return triangle_islands(self._joined)

    @property
    def islands(self) -> int:
        """How many islands the map has."""
        return int(self.island.max(initial=-1)) + 1

    @property
    def area(self) -> float:
        """How many texels the islands cover."""
        return float(np.abs(signed_areas(self.in_texels)).sum())

    @property
    def coverage(self) -> float:
        """The share of the atlas that the islands cover."""
        return self.area / (self.width * self.height)

    @property
    def density(self) -> float:
        """Texels along a unit of the surface, as a mean: the root of texels over area."""
        return float(np.sqrt(self.area / max(float(surface_areas(self.corners).sum()), _NOTHING)))

    @property
    def relative_density(self) -> Floats:
        """How dense texels are in each triangle, along a unit of the surface, over the mean: (F,)."""
        scaled = self.in_texels / max(self.density, _NOTHING)
        found: Floats = np.sqrt(stretches(self.corners, scaled).prod(axis=1))
        return found

    @property
    def seams(self) -> float:
        """The share of the islands that lies within a texel of their borders, 0 to 1.

        It is the borders' length over the area, both in texels, so that of islands narrower than two texels
        it is 1.
        """
        triangle, edge = border_edges(self._joined).T
        along = self.in_texels[triangle, edge] - self.in_texels[triangle, (edge + 1) % 3]
        return min(float(np.linalg.norm(along, axis=1).sum()) / max(self.area, _NOTHING), 1.0)


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
