# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Unsigned BC4 (UNORM), in OpenGL RGTC1: one channel, which is the first half of a block of BC5.

Format: Khronos Data Format Specification 1.3, chapter "RGTC Compressed Texture Image Formats", section "BC4
unsigned", https://registry.khronos.org/DataFormat/specs/1.3/dataformat.1.3.html#RGTC
"""

from __future__ import annotations

import numpy as np

from ...core.arrays import Floats
from ...core.errors import ShapeError
from .bc5 import decode_bc5, encode_bc5
from .bc7 import Blocks, described

BYTES = 8  # of a block


def encode_bc4(image: Floats) -> Blocks:
    """Encode an image (H, W, 1) in 0..1 as blocks (H/4, W/4, 8), each as a channel of `encode_bc5`.

    Raises ShapeError for another shape or a size that is no multiple of 4, InputError for values that are not
    numbers.
    """
    if image.ndim != 3 or image.shape[2] != 1:
        raise ShapeError(f"image: expected shape (H, W, 1), got {image.shape}")
    return np.ascontiguousarray(encode_bc5(np.repeat(image, 2, axis=2))[..., :BYTES])


def decode_bc4(blocks: Blocks) -> Floats:
    """Decode blocks (H/4, W/4, 8) as `decode_bc5` does a channel: an image (H, W, 1) float32 in 0..1.

    Raises ShapeError for another shape or type.
    """
    if blocks.ndim != 3 or blocks.shape[2] != BYTES:
        raise ShapeError(f"blocks: expected shape (rows, columns, 8) of uint8, got {described(blocks)}")
    return decode_bc5(np.concatenate([blocks, blocks], axis=2))[..., :1]
