# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A small picture of a running bake: each texel's mean light, encoded for a display."""

from __future__ import annotations

import logging
from collections.abc import Callable
from pathlib import Path
from time import monotonic

import numpy as np

from ..core.arrays import Floats, Ints
from ..core.atlas import AtlasLayout
from ..core.errors import BakeError
from ..formats.containers.png import encode_png
from ..formats.disk.atomic import replacing

log = logging.getLogger(__name__)

_SIDE = 256  # pixels at most, along the longer side
_EVERY = 1.0  # seconds between two pictures, at least
_GAMMA = 2.2
_NOT_YET = 0.05  # linear grey of texels that have no light, or not yet


class Thumbnail:
    """Writes the PNG `path` while light comes in, at most once a second, and calls `written` each time."""

    def __init__(self, path: Path, written: Callable[[Path], None]) -> None:
        self._path, self._written = path, written
        self._light: Floats | None = None
        self._next = 0.0
        self._works = True

    def add(self, layout: AtlasLayout, texel: Ints, light: Floats) -> None:
        """Add the scene-linear light (k, 3) of the texels with these flat indices (k,)."""
        if self._light is None:
            self._light = np.full((layout.height * layout.width, 3), _NOT_YET, dtype=np.float32)
        self._light[texel] = light
        if self._works and monotonic() >= self._next:
            self._write(self._light.reshape(layout.height, layout.width, 3))
            self._next = monotonic() + _EVERY

    def _write(self, light: Floats) -> None:
        picture = encode_png(np.clip(_smaller(light)[::-1], 0, 1) ** (1 / _GAMMA))
        try:
            with replacing(self._path, lasting=False) as beside:
                beside.write_bytes(picture)
        except BakeError as error:  # no reason to stop the bake
            log.warning(str(error))
            self._works = False
            return
        self._written(self._path)


def _smaller(light: Floats) -> Floats:
    """Average blocks of texels so that no side exceeds _SIDE; incomplete blocks at the end are dropped."""
    by = -(-max(light.shape[:2]) // _SIDE)
    height, width = (max(1, size // by) for size in light.shape[:2])
    down, across = (min(by, size) for size in light.shape[:2])
    blocks = light[: height * down, : width * across].reshape(height, down, width, across, 3)
    means: Floats = np.nan_to_num(np.minimum(blocks, 1.0)).mean(axis=(1, 3))
    return means
