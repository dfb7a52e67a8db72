# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How buckets lie in the atlas: the bucket matrix of the paper, version 1 of our contract.

Images here have row 0 at the bottom (v = 0); only `formats` flips rows.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .arrays import Floats
from .errors import ShapeError


@dataclass(frozen=True)
class AtlasLayout:
    """width x height texels of bucket x bucket cells each."""

    width: int
    height: int
    bucket: int

    def __post_init__(self) -> None:
        if min(self.width, self.height, self.bucket) < 1:
            raise ShapeError(
                f"atlas: {self.width} x {self.height} texels of {self.bucket} cells has no pixels"
            )

    @property
    def pixel_width(self) -> int:
        return self.width * self.bucket

    @property
    def pixel_height(self) -> int:
        return self.height * self.bucket

    def to_buckets(self, image: Floats) -> Floats:
        """Cut an image (H*n, W*n, C) into buckets (H, W, n, n, C), [j, i, q, p]; a view where numpy can."""
        if image.ndim != 3 or image.shape[:2] != (self.pixel_height, self.pixel_width):
            expected = f"({self.pixel_height}, {self.pixel_width}, C)"
            raise ShapeError(f"atlas image: expected shape {expected}, got {image.shape}")
        n = self.bucket
        cut = image.reshape(self.height, n, self.width, n, image.shape[2])
        return cut.transpose(0, 2, 1, 3, 4)

    def some_cells(self, image: Floats) -> Floats:
        """Five cells of each bucket of an image, the middle one and four around it: (H, W, 5, C), a copy."""
        low, middle, high = self.bucket // 4, self.bucket // 2, 3 * self.bucket // 4
        q, p = np.array([(middle, middle), (low, low), (low, high), (high, low), (high, high)]).T
        return self.to_buckets(image)[:, :, q, p]

    def from_buckets(self, buckets: Floats) -> Floats:
        """Join buckets (H, W, n, n, C) to an image (H*n, W*n, C)."""
        n = self.bucket
        if buckets.ndim != 5 or buckets.shape[:4] != (self.height, self.width, n, n):
            expected = f"({self.height}, {self.width}, {n}, {n}, C)"
            raise ShapeError(f"buckets: expected shape {expected}, got {buckets.shape}")
        return buckets.transpose(0, 2, 1, 3, 4).reshape(self.pixel_height, self.pixel_width, buckets.shape[4])
