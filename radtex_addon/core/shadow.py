# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shadows with one bit per cell: packing them, and looking up the visibility of lights.

A bit is 1 where the direction of its cell's centre is blocked. A visibility is 1 where nothing blocks.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from .arrays import Bools, Ints
from .errors import ShapeError

WORD = 32  # bits


def word_count(bucket: int) -> int:
    """Number of 32-bit words for a texel's bits."""
    return -(-bucket * bucket // WORD)


def pack_bits(blocked: Bools) -> npt.NDArray[np.uint32]:
    """Pack cells (..., n, n), [q, p], into words (..., `word_count`(n)): bit q * n + p, lowest bit first.

    Bits beyond the last cell are 0. Raises ShapeError for another shape.
    """
    if blocked.ndim < 2 or blocked.shape[-1] != blocked.shape[-2]:
        raise ShapeError(f"blocked: expected shape (..., n, n), got {blocked.shape}")
    n = blocked.shape[-1]
    bits = np.zeros((*blocked.shape[:-2], word_count(n) * WORD), dtype=bool)
    bits[..., : n * n] = blocked.reshape(*blocked.shape[:-2], n * n)
    packed = np.packbits(bits, axis=-1, bitorder="little")
    return packed.view("<u4").astype(np.uint32, copy=False)


def unpack_bits(words: Ints, bucket: int) -> Bools:
    """Inverse of `pack_bits`: cells (..., n, n). Raises ShapeError for another number of words."""
    count = word_count(bucket)
    if words.ndim < 1 or words.shape[-1] != count or words.dtype.kind not in "iu":
        raise ShapeError(f"words: expected whole numbers of shape (..., {count}), got {words.shape}")
    stored = np.ascontiguousarray(words, dtype="<u4").view(np.uint8)
    bits = np.unpackbits(stored, axis=-1, count=bucket * bucket, bitorder="little")
    cells: Bools = bits.reshape(*words.shape[:-1], bucket, bucket).astype(bool)
    return cells
