# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether a mesh encloses a volume: then viewers outside see back faces only through front faces."""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np

from ...core.arrays import Ints

_SAME = 1e-5  # times a mesh's size: vertices nearer than this count as one, since importers split vertices


def is_closed(mesh: bpy.types.Mesh) -> bool:
    """Whether each edge of a mesh has an even number of faces: true for a ball, not for a card or a bowl."""
    corner = _numbers(mesh.loops, "vertex_index")
    first, count = (_numbers(mesh.polygons, name) for name in ("loop_start", "loop_total"))
    following = np.arange(1, len(corner) + 1)
    following[first + count - 1] = first
    edges = _joined(mesh)[np.stack([corner, corner[following]], axis=1)]
    edges = np.sort(edges[edges[:, 0] != edges[:, 1]], axis=1)
    _, faces = np.unique(edges, axis=0, return_counts=True)
    return bool(len(faces)) and not (faces % 2).any()


def _joined(mesh: bpy.types.Mesh) -> Ints:
    """A number for each vertex, (V,), equal for vertices at the same position."""
    values = np.empty(len(mesh.vertices) * 3, dtype=np.float32)
    mesh.vertices.foreach_get("co", values)
    place = values.reshape(-1, 3)
    size = float(np.ptp(place, axis=0).max()) if len(place) else 0.0
    cell = np.rint(place / max(size * _SAME, 1e-30)).astype(np.int64)
    number: Ints = np.unique(cell, axis=0, return_inverse=True)[1].reshape(-1)
    return number


def _numbers(items: Any, name: str) -> Ints:
    values = np.empty(len(items), dtype=np.int32)
    items.foreach_get(name, values)
    return values
