# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The interface of renderers that fill buckets."""

from __future__ import annotations

from typing import Protocol

from ..core.arrays import Floats
from .plan import Tile


class Capture(Protocol):
    """A renderer, set up for one plan."""

    def render(self, tile: Tile) -> Floats:
        """Cells of the tile's texels: (k, n, n, C) float32, indexed [texel, q, p], scene-linear Rec.709.

        Channels are RGBA, then three for each layer that the renderer was set up for. Alpha is associated.
        Each value is the mean over its cell, uniform in B. Raises BakeError on failure.
        """
        ...
