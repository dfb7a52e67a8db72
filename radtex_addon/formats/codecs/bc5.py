# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Unsigned BC5 (UNORM), in OpenGL RGTC2: two channels, each a block of BC4.

Format: Khronos Data Format Specification 1.3, chapter "RGTC Compressed Texture Image Formats", section "BC5
unsigned", https://registry.khronos.org/DataFormat/specs/1.3/dataformat.1.3.html#RGTC
"""

from __future__ import annotations

from ...core.arrays import Floats
from .bc4 import channel_values, channel_words
from .bc7 import Blocks, encoded, image_of, words_of


def encode_bc5(image: Floats) -> Blocks:
    """Encode an image (H, W, 2) in 0..1 as blocks (H/4, W/4, 16), each channel as `encode_bc4` does.

    Raises ShapeError for another shape or a size that is no multiple of 4, InputError for values that are not
    numbers.
    """
    return encoded(image, 2, 1.0, channel_words)


def decode_bc5(blocks: Blocks) -> Floats:
    """Decode any blocks (H/4, W/4, 16), each channel as `decode_bc4` does: an image (H, W, 2) float32.

    Raises ShapeError for another shape or type.
    """
    return image_of(channel_values(words_of(blocks)), blocks)
