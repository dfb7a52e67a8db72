# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Check that an object has a size and a place at which Cycles can trace rays: it computes in float32."""

from __future__ import annotations

import logging

import numpy as np

from ...core.arrays import Floats
from ...core.errors import InputError
from ...core.ray_offset import ray_offset

log = logging.getLogger(__name__)

_LEAST, _MOST = (
    1e-6,
    1e9,
)  # scene units; a tenth of the least or 4 times the most bakes black or clear
_OFF = 0.05  # times the diagonal: rays that start farther from the surface may start behind another object
_LOST = 5.0  # times the diagonal: beyond this, float32 has too few different values across the object


def check_extent(name: str, position: Floats, *, warns: bool = True) -> None:
    """Check that rays can start at an object's vertices (V, 3), in world space.

    Raises InputError if the object is too small, too large, or much too far from the origin for its size; if
    it is somewhat too far, logs a warning, if `warns`.
    """
    diagonal = float(np.linalg.norm(position.max(axis=0) - position.min(axis=0)))
    if diagonal == 0:
        return  # the checks of the surface's area report this
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
        raise InputError(
            f"{place}: Cycles rounds coordinates too much there; move the scene nearer to the origin"
        )
    if not warns:
        return
    log.warning(
        "%s: Cycles rounds coordinates there, rays start %.2g from the surface; move the scene to the origin",
        place,
        off,
    )
