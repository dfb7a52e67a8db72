# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Small pictures of a running bake: each texel's mean light, encoded for a display, and its UV map."""

from __future__ import annotations

import logging
from collections.abc import Callable
from pathlib import Path
from time import monotonic

import numpy as np

from ..core.arrays import Floats, Ints
from ..core.atlas import AtlasLayout
from ..core.errors import BakeError
from ..core.uv_map import UvMap, draw_map
from ..formats.containers.png import encode_png
from ..formats.disk.atomic import replacing

log = logging.getLogger(__name__)

_SIDE = 256  # pixels at most, along the longer side
_EVERY = 1.0  # seconds between two pictures, at least
_GAMMA = 2.2
_NOT_YET = 0.05  # linear grey of texels that have no light, or not yet


class Thumbnail:
    """Writes the PNG `path` while light comes in, at most once a second, and calls `written` each time.

    Before that it draws the UV map in the PNG `map_path`, if one is given, and calls `map_written`.
    """

    def __init__(
        self,
        path: Path,
        written: Callable[[Path], None],
        map_path: Path | None = None,
        map_written: Callable[[UvMap], None] = lambda _: None,
    ) -> None:
        self._path, self._written = path, written
        self._map_path, self._map_written = map_path, map_written
        self._light: Floats | None = None
        self._next = 0.0
        self._works = True

    def draw_map(self, uv_map: UvMap) -> None:
        """Draw the UV map that the light is captured on, if that is wanted."""
        if self._map_path is not None and _write(self._map_path, draw_map(uv_map, _SIDE)):
            self._map_written(uv_map)

    def add(self, layout: AtlasLayout, texel: Ints, light: Floats) -> None:
        """Add the scene-linear light (k, 3) of the texels with these flat indices (k,)."""
        if self._light is None:
            self._light = np.full((layout.height * layout.width, 3), _NOT_YET, dtype=np.float32)
        self._light[texel] = light
        if self._works and monotonic() >= self._next:
            small = _smaller(self._light.reshape(layout.height, layout.width, 3))
            self._works = _write(self._path, np.clip(small[::-1], 0, 1) ** (1 / _GAMMA))
            if self._works:
                self._written(self._path)
            self._next = monotonic() + _EVERY


def _write(path: Path, picture: Floats) -> bool:
    """Write a picture of display values as a PNG; if that fails, log why: no reason to stop the bake."""
    try:
        with replacing(path, lasting=False) as beside:
            beside.write_bytes(encode_png(picture))
    except BakeError as error:
        log.warning(str(error))
        return False
    return True


def _smaller(light: Floats) -> Floats:
    """Average blocks of texels so that no side exceeds _SIDE; incomplete blocks at the end are dropped."""
    by = -(-max(light.shape[:2]) // _SIDE)
    height, width = (max(1, size // by) for size in light.shape[:2])
    down, across = (min(by, size) for size in light.shape[:2])
    blocks = light[: height * down, : width * across].reshape(height, down, width, across, 3)
    means: Floats = np.nan_to_num(np.minimum(blocks, 1.0)).mean(axis=(1, 3))
    return means
