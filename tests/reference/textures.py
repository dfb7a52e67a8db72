# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Readers of GPU textures' files, by the formats' specifications: RadTex itself only writes them."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import zstandard

from radtex_addon.formats.containers.dds import DXGI
from radtex_addon.formats.containers.ktx2 import VK_FORMATS
from radtex_addon.formats.containers.texture import Texture, blocks_shape


def read_ktx2(path: Path) -> Texture:
    """A file of `write_ktx2`: https://registry.khronos.org/KTX/specs/2.0/ktxspec.v2.html."""
    data = path.read_bytes()
    assert data.startswith(b"\xabKTX 20\xbb\r\n\x1a\n")
    vk_format, _, width, height, depth, layers, faces, count, scheme = struct.unpack_from("<9I", data, 12)
    keys, length = struct.unpack_from("<2I", data, 56)
    assert (depth, faces) == (0, 1)
    assert b"KTXorientation\0ru\0" in data[keys : keys + length]  # its first row is the bottom one
    kind = {number: kind for kind, number in VK_FORMATS.items()}[vk_format]
    levels, end = [], 0
    for level in range(count):
        begin, length, unpacked = struct.unpack_from("<3Q", data, 80 + 24 * level)
        raw = data[begin : begin + length]
        if scheme == 2:
            raw = zstandard.ZstdDecompressor().decompress(raw)
        assert len(raw) == unpacked
        shape = blocks_shape(kind, width, height, max(1, layers), level)
        levels.append(np.frombuffer(raw, np.uint8).reshape(shape))
        end = max(end, begin + length)
    assert end == len(data)
    return Texture(kind, width, height, tuple(levels), layers > 0)


def read_dds(path: Path) -> Texture:
    """A file of `write_texture`; a single layer is never read as an array.

    https://learn.microsoft.com/windows/win32/direct3ddds/dx-graphics-dds-pguide
    """
    data = path.read_bytes()
    height, width = struct.unpack_from("<2I", data, 12)
    (count,) = struct.unpack_from("<I", data, 28)
    dxgi, dimension, misc, layers = struct.unpack_from("<4I", data, 128)
    assert (data[:4], data[84:88], dimension, misc) == (b"DDS ", b"DX10", 3, 0)
    kind = {number: kind for kind, number in DXGI.items()}[dxgi]
    shapes = [blocks_shape(kind, width, height, layers, level) for level in range(count)]
    levels, place = [np.empty(shape, np.uint8) for shape in shapes], 148
    for layer in range(layers):
        for level in levels:
            found = np.frombuffer(data, np.uint8, level[layer].size, place)
            level[layer], place = found.reshape(level.shape[1:]), place + found.size
    assert place == len(data)
    return Texture(kind, width, height, tuple(levels), layers > 1)
