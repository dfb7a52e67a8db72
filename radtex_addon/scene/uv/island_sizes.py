# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Give islands texels by what they need: few where no camera can be, fewer where the surface is flat."""

from __future__ import annotations

import numpy as np

from ...core.arrays import Bools, Floats, Ints
from ...core.islands import areas_on_surface, weld
from ...core.surface import inner_edges
from ..mesh.evaluated import EvaluatedMesh
from ..mesh.flatten import FlatIslands, islands_of

_HIDDEN = 0.25  # times as many texels along a side where no camera can be: they colour what mirrors them
_USUAL = 40.0  # radians that the normal turns across a square as large as the surface, if it has its texels
_POWER = 0.25  # of what it turns more, or less
_LEAST, _MOST = 0.6, 1.3  # times as many texels along a side


def smaller_where_hidden(evaluated: EvaluatedMesh, flat: FlatIslands, seen: Bools) -> FlatIslands:
    """The islands cut where what is `seen` (F,) ends, and smaller beyond."""
    island = np.where(flat.island >= 0, 2 * flat.island + seen, -1)
    return islands_of(evaluated, flat.uv * np.where(seen, 1, _HIDDEN)[:, None, None], island)


def smaller_where_flat(evaluated: EvaluatedMesh, flat: FlatIslands) -> FlatIslands:
    """The islands scaled by how much the normal turns on them, in the mean over their area.

    What is seen on a curved surface changes from texel to texel, and much less on a flat one.
    """
    some = flat.island >= 0
    area = areas_on_surface(evaluated.world_position, evaluated.triangles)
    turned = _turned(evaluated, flat.island)
    whole = np.bincount(flat.island[some], area[some], flat.count)
    mean = np.bincount(flat.island[some], turned[some], flat.count) / np.maximum(whole, 1e-30)
    scale = np.clip((mean * np.sqrt(area.sum()) / _USUAL) ** _POWER, _LEAST, _MOST)
    each = np.where(some, scale[flat.island], 1).astype(np.float32)
    return islands_of(evaluated, flat.uv * each[:, None, None], flat.island)


def _turned(evaluated: EvaluatedMesh, island: Ints) -> Floats:
    """The angles that the normal turns by over edges within islands, times half of their lengths, (F,)."""
    position, triangles = evaluated.world_position, evaluated.triangles
    corners = position[triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-30)
    edges = inner_edges(weld(position)[triangles])
    first, second = edges.starts.T // 3
    place = corners.reshape(-1, 3)
    length = np.linalg.norm(place[edges.starts[:, 0]] - place[edges.ends[:, 0]], axis=1)
    cosine = np.clip((normal[first] * normal[second]).sum(axis=1), -1, 1)
    turned = np.where(island[first] == island[second], np.arccos(cosine) * length / 2, 0)
    found = np.zeros(len(triangles))
    for side in (first, second):
        np.add.at(found, side, turned)
    return found
