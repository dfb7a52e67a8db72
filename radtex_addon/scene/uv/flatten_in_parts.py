# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Flatten large meshes part by part: uvunwrap's time and memory grow faster than the number of triangles."""

from __future__ import annotations

import numpy as np

from ...bake.progress import Steps
from ...core.arrays import Bools, Floats, Ints
from . import uvunwrap_job
from .uvunwrap_job import Charts

LARGE = 200_000  # triangles of a part; a mesh of more is cut
ALL_FLAT = 0.8  # of the time until islands are flat and measured: when they are flat


def flatten_in_parts(points: Floats, faces: Ints, seams: Bools) -> Steps[Charts]:
    """As `uvunwrap_job.flatten`, but no island of a large mesh goes over the border of two parts.

    Parts are cut across the longest side of their box, so that both halves have as many triangles.
    """
    if len(faces) <= LARGE:
        return (yield from uvunwrap_job.flatten(points, faces, seams, 0.0, ALL_FLAT))
    uv, owner, count = np.empty((len(faces), 3, 2)), np.empty(len(faces), dtype=np.int64), 0
    parts = _parts(points[faces].mean(axis=1, dtype=np.float32))
    for number, part in enumerate(parts):
        used, index = np.unique(faces[part], return_inverse=True)
        shares = ALL_FLAT * number / len(parts), ALL_FLAT * (number + 1) / len(parts)
        made = yield from uvunwrap_job.flatten(points[used], index.reshape(-1, 3), seams[part], *shares)
        uv[part] = made.uv
        owner[part] = np.where(made.owner >= 0, made.owner + count, -1)
        count += int(made.owner.max(initial=-1)) + 1
    return Charts(uv, owner)


def _parts(middle: Floats) -> list[Ints]:
    """Parts of triangles with these middles (F, 3): their numbers, ascending."""
    done: list[Ints] = []
    left: list[Ints] = [np.arange(len(middle), dtype=np.int32)]
    while left:
        part = left.pop()
        if len(part) <= LARGE:
            done.append(np.sort(part))
            continue
        along = middle[part, int(np.ptp(middle[part], axis=0).argmax())]
        order = np.argsort(along, kind="stable")
        left += np.array_split(part[order], 2)
    return done
