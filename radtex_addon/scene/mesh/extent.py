# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sizes and places of objects that Cycles, which counts in float32, can trace rays from."""

from __future__ import annotations

import logging

import numpy as np

from ...core.arrays import Floats
from ...core.errors import InputError
from ...core.ray_offset import ray_offset

log = logging.getLogger(__name__)

_LEAST, _MOST = 1e-6, 1e9  # scene units; a tenth, or four times as much, bakes black or clear without a word
_OFF = 0.05  # of the diagonal: a ray that starts that far from the surface may start behind something else
_LOST = 5.0  # of the diagonal: float32 tells too few places of the object apart


def check_extent(name: str, position: Floats) -> None:
    """Make sure that rays can start at an object's vertices (V, 3), in world space.

    Raises InputError for one that is too small, too large, or much too far from the origin for its size. A
    warning is for one that is somewhat too far.
    """
    diagonal = float(np.linalg.norm(position.max(axis=0) - position.min(axis=0)))
    if diagonal == 0:
        return  # the surface's area is what others look at
    if not _LEAST <= diagonal <= _MOST:
        raise InputError(
            f"object '{name}' is {diagonal:.3g} scene units across, Cycles traces {_LEAST:g} to {_MOST:g}: "
            "scale the scene"
        )
    off = ray_offset(position)
    if off <= _OFF * diagonal:
        return
    far = float(np.abs(position).max())
    place = f"object '{name}' stands {far:.3g} scene units from the origin and is {diagonal:.3g} across"
    if off > _LOST * diagonal:
        raise InputError(f"{place}: Cycles counts too coarsely there; move the scene nearer to the origin")
    log.warning(
        "%s: Cycles counts coarsely there, rays start %.2g from the surface; move the scene to the origin",
        place,
        off,
    )
