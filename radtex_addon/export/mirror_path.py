# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a mirror ball moves by itself: an ellipse that keeps clear of the surface and is before its front."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..core.arrays import Floats
from ..core.surface import SurfaceMesh
from ..formats.json_reader import Facts

_SAMPLES = 6000  # points of the surface that distances are taken to
_PLACES = 24  # of an ellipse that are tried
_SIZE = 0.14  # radius, in shares of half the surface's greatest extent
_SCALES = (0.5, 0.35, 0.7, 0.9, 1.2, 1.5, 1.9)  # of ellipses, in shares of half the extents
_HEIGHTS = (0.5, 0.65, 0.8, 0.35, 1.2)  # in shares of the extent, from below
_CLEAR = 1.15  # radii


@dataclass(frozen=True)
class BallPath:
    """A level ellipse about `middle`, with half axes `across` along x and y, and the ball's `radius`.

    In Blender's world space of the bake.
    """

    middle: tuple[float, float, float]
    across: tuple[float, float]
    radius: float

    def facts(self) -> dict[str, Any]:
        """The JSON's keys and values."""
        return {"middle": list(self.middle), "across": list(self.across), "radius": self.radius}

    @classmethod
    def from_facts(cls, facts: Facts) -> BallPath:
        """Inverse of `facts`. Raises FormatError for a missing or mistyped key."""
        x, y, z = facts.numbers("middle", 3)
        a, b = facts.numbers("across", 2)
        return cls((x, y, z), (a, b), facts.positive("radius"))


def path_over(surface: SurfaceMesh, mirrored: bool, culled: bool) -> BallPath:
    """The first of some ellipses on which the ball touches nothing and is not inside; else the widest one.

    With `culled`, faces have twins, so that the front of one is the back of another: no side is the inside.
    """
    points, normals = _points(surface, mirrored)
    low, high = surface.position.min(axis=0), surface.position.max(axis=0)
    half = np.maximum((high - low) / 2, 1e-6 * float(np.ptp(surface.position)) + 1e-9)
    middle, radius = (low + high) / 2, _SIZE * float(half.max())
    found = None
    for scale in _SCALES:
        across = np.maximum(scale * half[:2], radius)
        for height in _HEIGHTS:
            place = np.array([middle[0], middle[1], low[2] + height * (high[2] - low[2])])
            if height > 1 or high[2] - low[2] < 3 * radius:
                place[2] = max(place[2], low[2] + 2 * radius)
            found = BallPath(_three(place), (float(across[0]), float(across[1])), radius)
            if _is_clear(found, points, normals, culled):
                return found
    assert found is not None
    return found


def _is_clear(path: BallPath, points: Floats, normals: Floats, culled: bool) -> bool:
    angles = np.linspace(0, 2 * np.pi, _PLACES, endpoint=False)
    circle = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(_PLACES)])
    for place in np.array(path.middle) + circle * np.array([*path.across, 0.0]):
        away = place - points
        squared = np.sum(away * away, axis=1)
        nearest = int(np.argmin(squared))
        if squared[nearest] < (_CLEAR * path.radius) ** 2:
            return False
        if not culled and float(away[nearest] @ normals[nearest]) < 0:
            return False
    return True


def _points(surface: SurfaceMesh, mirrored: bool) -> tuple[Floats, Floats]:
    """Points of the surface (N, 3), in proportion to area, and their triangles' normals."""
    corners = surface.corner_position.astype(np.float64)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal *= -1.0 if mirrored else 1.0
    area = np.linalg.norm(normal, axis=1)
    chance = area / area.sum() if area.sum() > 0 else np.full(len(area), 1 / len(area))
    random = np.random.default_rng(0)
    chosen = random.choice(len(corners), _SAMPLES, p=chance)
    weight = random.dirichlet((1.0, 1.0, 1.0), _SAMPLES)
    points: Floats = np.einsum("nk,nkc->nc", weight, corners[chosen])
    return points, normal[chosen]


def _three(place: Floats) -> tuple[float, float, float]:
    return float(place[0]), float(place[1]), float(place[2])
