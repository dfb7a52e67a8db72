# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""KTX2 files: every field as the specification has it."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest
import zstandard

from radtex_addon.core.arrays import Floats
from radtex_addon.core.errors import InputError, ShapeError
from radtex_addon.formats.codecs.bc7 import Blocks
from radtex_addon.formats.containers.ktx2 import write_ktx2
from radtex_addon.formats.containers.texture import (
    ENCODED,
    PixelFormat,
    Texture,
    decode_texture,
    encode_texture,
    most_levels,
)
from radtex_addon.formats.containers.unit_blocks import CHANNELS, encode_units
from radtex_addon.version import VERSION
from tests.reference.textures import read_ktx2

VK_FORMATS = {PixelFormat.RGBA16F: 97, PixelFormat.RGB9E5: 123, PixelFormat.BC6H: 143}  # vulkan_core.h
UNIT_BLOCKS = {  # colour model, transfer function, bytes; the samples' first words, whose alpha is linear
    PixelFormat.BC3: (130, 1, 16, (15 << 24 | 63 << 16, 63 << 16 | 64)),
    PixelFormat.BC3_SRGB: (130, 2, 16, (0x1F << 24 | 63 << 16, 63 << 16 | 64)),
    PixelFormat.BC4: (131, 1, 8, (63 << 16,)),
    PixelFormat.BC7: (134, 1, 16, (127 << 16,)),
    PixelFormat.BC7_SRGB: (134, 2, 16, (127 << 16,)),
}
LEVELS, DESCRIPTOR = 80, 152  # where the level index of three levels and the descriptor begin


def images(layers: int = 1, height: int = 22, width: int = 33, levels: int = 3) -> list[Floats]:
    rng = np.random.default_rng(1)
    return [
        np.exp(rng.normal(0, 2, (layers, max(1, height >> k), max(1, width >> k), 4))).astype(np.float32)
        for k in range(levels)
    ]


def texture(kind: PixelFormat = PixelFormat.RGB9E5, layers: int = 2) -> Texture:
    return encode_texture(images(layers), kind, is_array=True)


def words(data: bytes, offset: int, count: int) -> tuple[int, ...]:
    return struct.unpack_from(f"<{count}I", data, offset)


@pytest.mark.parametrize("kind", ENCODED)
@pytest.mark.parametrize("zstd", [False, True])
@pytest.mark.parametrize(("layers", "is_array"), [(1, False), (1, True), (3, True)])
def test_a_texture_comes_back_as_it_was(
    tmp_path: Path, kind: PixelFormat, zstd: bool, layers: int, is_array: bool
) -> None:
    path = tmp_path / "new" / "a.ktx2"
    written = encode_texture(images(layers), kind, is_array)
    write_ktx2(path, written, zstd)
    read = read_ktx2(path)
    assert (read.format, read.width, read.height, read.is_array) == (kind, 33, 22, is_array)
    assert words(path.read_bytes(), 32, 1) == (layers if is_array else 0,)
    for ours, theirs in zip(written.levels, read.levels, strict=True):
        np.testing.assert_array_equal(theirs, ours)
    assert list(path.parent.iterdir()) == [path]


def test_half_floats_are_exact_and_the_others_near(tmp_path: Path) -> None:
    source = [image.astype(np.float16).astype(np.float32) for image in images(2)]
    for kind in ENCODED:
        write_ktx2(tmp_path / "a.ktx2", encode_texture(source, kind, is_array=True))
        for image, decoded in zip(source, decode_texture(read_ktx2(tmp_path / "a.ktx2")), strict=True):
            assert decoded.shape[:3] == image.shape[:3]
            if kind is PixelFormat.RGBA16F:
                np.testing.assert_array_equal(decoded, image)
            if kind is PixelFormat.RGB9E5:
                stops = np.log2(decoded.max(axis=3) / image[..., :3].max(axis=3))
                assert np.abs(stops).max() <= 0.005


@pytest.mark.parametrize("kind", ENCODED)
@pytest.mark.parametrize("zstd", [False, True])
def test_header_and_levels_are_as_the_specification_has_them(
    tmp_path: Path, kind: PixelFormat, zstd: bool
) -> None:
    """The levels lie from the smallest to the largest."""
    path, written = tmp_path / "a.ktx2", texture(kind)
    write_ktx2(path, written, zstd)
    data = path.read_bytes()
    assert data[:12] == bytes((0xAB, 0x4B, 0x54, 0x58, 0x20, 0x32, 0x30, 0xBB, 0x0D, 0x0A, 0x1A, 0x0A))
    type_size = {PixelFormat.RGBA16F: 2, PixelFormat.RGB9E5: 4, PixelFormat.BC6H: 1}[kind]
    assert words(data, 12, 9) == (VK_FORMATS[kind], type_size, 33, 22, 0, 2, 1, 3, 2 if zstd else 0)
    dfd, dfd_length, kvd, kvd_length = words(data, 48, 4)
    assert struct.unpack_from("<2Q", data, 64) == (0, 0)
    assert (dfd, words(data, dfd, 1), kvd) == (DESCRIPTOR, (dfd_length,), dfd + dfd_length)
    writer = b"KTXwriter\0RadTex " + VERSION.encode() + b"\0"
    pairs = struct.pack("<I", 18) + b"KTXorientation\0ru\0\0\0" + struct.pack("<I", len(writer)) + writer
    end = kvd + kvd_length
    assert data[kvd:end] == pairs + bytes(-len(pairs) % 4)
    align = 1 if zstd else kind.block_bytes
    for level in reversed(range(3)):
        offset, length, unpacked = struct.unpack_from("<3Q", data, LEVELS + 24 * level)
        assert 0 <= offset - end < align
        assert offset % align == 0
        assert not any(data[end:offset])
        assert unpacked == written.levels[level].nbytes
        stored = data[offset : offset + length]
        raw = zstandard.ZstdDecompressor().decompress(stored) if zstd else stored
        assert raw == written.levels[level].tobytes()
        end = offset + length
    assert end == len(data)


@pytest.mark.parametrize("zstd", [False, True])
def test_the_descriptors_are_those_of_khronos(tmp_path: Path, zstd: bool) -> None:
    """Word by word what Khronos's dfdutils make of each VkFormat, but for the flag of associated alpha."""
    one, minus_one = 0x3F800000, 0xBF800000
    half = [(0 << 24, 0), (1 << 24, 16), (2 << 24, 32), (15 << 24, 48)]
    expected = {
        PixelFormat.RGBA16F: [92, 0, 88 << 16 | 2, 1 << 24 | 1 << 16 | 1 << 8 | 1, 0, 8, 0]
        + [
            word for channel, at in half for word in (0xC0 << 24 | channel | 15 << 16 | at, 0, minus_one, one)
        ],
        PixelFormat.RGB9E5: [124, 0, 120 << 16 | 2, 1 << 16 | 1 << 8 | 1, 0, 4, 0]
        + [
            word
            for channel in range(3)
            for word in (
                *(channel << 24 | 8 << 16 | 9 * channel, 0, 0, 8448),
                *((0x20 | channel) << 24 | 4 << 16 | 27, 0, 15, 31),
            )
        ],
        PixelFormat.BC6H: [
            *(44, 0, 40 << 16 | 2, 1 << 16 | 1 << 8 | 133, 3 << 8 | 3, 16, 0),
            *(0x80 << 24 | 127 << 16, 0, 0, one),
        ],
    }
    for kind, (model, transfer, size, samples) in UNIT_BLOCKS.items():
        length = 24 + 16 * len(samples)
        words_of = [4 + length, 0, length << 16 | 2, transfer << 16 | 1 << 8 | model, 3 << 8 | 3, size, 0]
        expected[kind] = words_of + [word for first in samples for word in (first, 0, 0, 2**32 - 1)]
    for kind, fields in expected.items():
        unit = encode_units([np.full((22, 33, CHANNELS[kind]), 0.5)], kind) if kind in CHANNELS else None
        write_ktx2(tmp_path / "a.ktx2", unit or texture(kind), zstd)
        data = (tmp_path / "a.ktx2").read_bytes()
        assert list(words(data, words(data, 48, 1)[0], len(fields))) == fields, kind
    write_ktx2(tmp_path / "a.ktx2", texture(PixelFormat.RGBA16F), zstd, premultiplied=False)
    assert (tmp_path / "a.ktx2").read_bytes()[DESCRIPTOR + 15] == 0
    read_ktx2(tmp_path / "a.ktx2")


def test_other_formats_are_not_written(tmp_path: Path) -> None:
    blocks: Blocks = np.zeros((1, 2, 2, 16), np.uint8)
    with pytest.raises(InputError, match=r"BC5 is not written to KTX2; choose RGBA16F, RGB9E5, BC3"):
        write_ktx2(tmp_path / "a.ktx2", Texture(PixelFormat.BC5, 8, 8, (blocks,)))
    assert not list(tmp_path.iterdir())


def test_levels_end_at_one_pixel_and_what_is_no_mip_chain_makes_no_texture() -> None:
    sizes = ((1, 1), (2, 1), (3, 2), (33, 22), (64, 9))
    assert [most_levels(*size) for size in sizes] == [1, 2, 2, 6, 7]
    with pytest.raises(ShapeError, match="level 1: expected"):
        encode_texture([np.ones((1, 8, 8, 3)), np.ones((1, 3, 4, 3))], PixelFormat.RGB9E5)
    with pytest.raises(ShapeError, match="2 layers make an array"):
        encode_texture([np.ones((2, 8, 8, 3))], PixelFormat.RGB9E5)
    with pytest.raises(ShapeError, match="5 mip levels, expected 1 to 4"):
        encode_texture([np.ones((1, max(1, 8 >> k), max(1, 8 >> k), 3)) for k in range(5)], ENCODED[0])
    with pytest.raises(ShapeError, match="expected shape"):
        encode_texture([np.ones((8, 8, 3))], PixelFormat.RGB9E5)
    with pytest.raises(InputError, match="BC7 does not hold light"):
        encode_texture([np.ones((1, 8, 8, 3))], PixelFormat.BC7)
    with pytest.raises(InputError, match="1 of its values are not numbers"):
        encode_texture([np.array([[[[0, np.nan, 1]]]])], PixelFormat.RGBA16F)
