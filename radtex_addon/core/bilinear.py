# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bilinear lookups in images by texture coordinates."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from .arrays import Floats, Ints


def bilinear(image: Floats, uv: Floats) -> Floats:
    """Bilinear lookup in an image (H, W, C) at uv (K, 2), clamped at the edges: (K, C) float32."""
    height, width = image.shape[:2]
    flat = image.reshape(height * width, -1)
    total = np.zeros((len(uv), flat.shape[1]), dtype=np.float32)
    for texel, weight in bilinear_texels(uv, width, height):
        total += weight[:, None] * flat[texel]
    return total


def bilinear_texels(uv: Floats, width: int, height: int) -> Iterator[tuple[Ints, Floats]]:
    """Yield the four texels around uv (K, 2), as flat indices clamped at the edge, and their weights."""
    position = uv * np.array([width, height], dtype=uv.dtype) - uv.dtype.type(0.5)
    corner = np.floor(position)
    fraction = position - corner
    for dy in (0, 1):
        for dx in (0, 1):
            i = np.clip(corner[:, 0].astype(np.int32) + dx, 0, width - 1)
            j = np.clip(corner[:, 1].astype(np.int32) + dy, 0, height - 1)
            yield j * width + i, np.prod(np.where(np.array([dx, dy]) == 1, fraction, 1 - fraction), axis=1)
