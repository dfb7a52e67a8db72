# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Give islands texels by what an artist has painted."""

from __future__ import annotations

import numpy as np

from ...core.arrays import Floats, Ints
from ...core.islands import areas_on_surface, weld
from ...core.surface import inner_edges
from ..mesh.evaluated import EvaluatedMesh
from ..mesh.face_rays import small_regions
from ..mesh.flatten import FlatIslands, islands_of

_LEAST, _MOST = 0.25, 2.0  # times as many texels along a side, of weights 0 and 1
_BANDS = (0.25, 0.75)  # weights between which an island ends
_CRUMB = 5e-4  # times the whole area: painted regions that are smaller are no islands of their own


def times_as_many(weight: Floats) -> Floats:
    """How many times as many texels along a side weights stand for: geometric between 0, a half and 1."""
    apart = 2 * weight - 1
    return np.where(apart < 0, _LEAST**-apart, _MOST**apart)


def sized_as_painted(evaluated: EvaluatedMesh, flat: FlatIslands, weight: Floats) -> FlatIslands:
    """The islands cut where the `weight` (F,), 0 to 1, changes much, and scaled by its mean over each."""
    area = areas_on_surface(evaluated.world_position, evaluated.triangles)
    cut = np.where(flat.island >= 0, 3 * flat.island + _bands(evaluated, weight, area), -1)
    parts = islands_of(evaluated, flat.uv, cut)
    some = parts.island >= 0
    whole = np.bincount(parts.island[some], area[some], parts.count)
    total = np.bincount(parts.island[some], (area * weight)[some], parts.count)
    times = times_as_many(total / np.maximum(whole, 1e-30))
    each = np.where(some, times[parts.island], 1)
    return islands_of(evaluated, parts.uv * each[:, None, None], parts.island)


def _bands(evaluated: EvaluatedMesh, weight: Floats, area: Floats) -> Ints:
    """Which triangles (F,) get fewer texels, 0, about as many, 1, or more, 2; crumbs get about as many."""
    band = np.digitize(weight, _BANDS)
    first, second = inner_edges(weld(evaluated.position)[evaluated.triangles]).starts.T // 3
    least = np.full(len(area), _CRUMB * area.sum())
    for painted in (0, 2):
        band[small_regions(band == painted, first, second, area, least)] = 1
    return band
