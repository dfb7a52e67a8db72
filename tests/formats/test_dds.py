# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""DDS files: every field as Microsoft has it, and blocks as other programs decode them."""

from __future__ import annotations

import ctypes
import struct
from collections.abc import Callable
from pathlib import Path

import moderngl
import numpy as np
import pytest
from PIL import Image

from radtex_addon.core.arrays import Floats
from radtex_addon.core.errors import InputError
from radtex_addon.formats.codecs.bc3 import decode_bc3
from radtex_addon.formats.codecs.bc4 import decode_bc4
from radtex_addon.formats.codecs.bc6h import decode_bc6h
from radtex_addon.formats.codecs.bc7 import Blocks, decode_bc7
from radtex_addon.formats.codecs.rgb9e5 import decode_rgb9e5
from radtex_addon.formats.containers.dds import DXGI, write_texture
from radtex_addon.formats.containers.texture import PixelFormat, Texture, encode_texture
from tests.reference.textures import read_dds

HEADER = 148
GL_RGB9_E5 = 0x8C3D


def random_blocks(kind: PixelFormat, rows: int = 6, columns: int = 9, seed: int = 1) -> Blocks:
    """Blocks of the modes that we write, all other bits free; or pixels."""
    blocks = np.random.default_rng(seed).integers(0, 256, (rows, columns, kind.block_bytes), np.uint8)
    if kind in (PixelFormat.BC7, PixelFormat.BC7_SRGB):
        blocks[..., 0] = (blocks[..., 0] & 0x80) | 0x40
    if kind is PixelFormat.BC6H:
        blocks[..., 0] = (blocks[..., 0] & 0xE0) | 0b00011
    return blocks


def whole(blocks: Blocks, kind: PixelFormat) -> Texture:
    return Texture(kind, blocks.shape[1] * kind.side, blocks.shape[0] * kind.side, (blocks[None],))


@pytest.mark.parametrize("kind", DXGI)
def test_blocks_come_back_as_they_were(tmp_path: Path, kind: PixelFormat) -> None:
    path, blocks = tmp_path / "new" / "a.dds", random_blocks(kind)
    write_texture(path, whole(blocks[::-1], kind))
    read = read_dds(path)
    np.testing.assert_array_equal(read.levels[0][0], blocks[::-1])
    assert (read.format, read.width, read.height) == (kind, 9 * kind.side, 6 * kind.side)
    assert list(path.parent.iterdir()) == [path]
    assert path.stat().st_size == HEADER + blocks.nbytes


@pytest.mark.parametrize(
    ("kind", "number", "flags", "pitch"),
    [
        (PixelFormat.RGBA8, 28, 0x100F, 36),
        (PixelFormat.BC4, 80, 0x81007, 432),
        (PixelFormat.BC6H, 95, 0x81007, 864),
        (PixelFormat.BC7, 98, 0x81007, 864),
        (PixelFormat.RGBA16F, 10, 0x100F, 72),
    ],
)
def test_the_header_is_as_microsoft_has_it(
    tmp_path: Path, kind: PixelFormat, number: int, flags: int, pitch: int
) -> None:
    blocks = random_blocks(kind)
    write_texture(tmp_path / "a.dds", whole(blocks, kind))
    width, height = 9 * kind.side, 6 * kind.side
    header = struct.pack("<4s7I44x", b"DDS ", 124, flags, height, width, pitch, 0, 1)
    header += struct.pack("<2I4s5I", 32, 4, b"DX10", 0, 0, 0, 0, 0)
    header += struct.pack("<5I5I", 0x1000, 0, 0, 0, 0, number, 3, 0, 1, 0)
    assert (tmp_path / "a.dds").read_bytes() == header + blocks.tobytes()


@pytest.mark.parametrize("kind", [PixelFormat.BC6H, PixelFormat.RGBA16F])
@pytest.mark.parametrize(("layers", "levels"), [(1, 1), (1, 3), (3, 1), (3, 6)])
def test_layers_and_levels_come_back(tmp_path: Path, kind: PixelFormat, layers: int, levels: int) -> None:
    """A layer has all its levels before the next."""
    written = mipmapped(kind, layers, levels)
    write_texture(tmp_path / "a.dds", written)
    read = read_dds(tmp_path / "a.dds")
    assert (read.format, read.width, read.height, read.is_array) == (kind, 32, 24, layers > 1)
    for ours, theirs in zip(written.levels, read.levels, strict=True):
        np.testing.assert_array_equal(theirs, ours)
    data = (tmp_path / "a.dds").read_bytes()
    flags, *_, count = struct.unpack_from("<6I", data, 8)
    assert flags == 0x1007 | (0x80000 if kind is PixelFormat.BC6H else 0x8) | (0x20000 if levels > 1 else 0)
    assert count == levels
    assert struct.unpack_from("<I", data, 108) == (0x1000 | (0x400008 if levels > 1 else 0),)
    assert struct.unpack_from("<3I", data, 132) == (3, 0, layers)
    parts = [level[layer].tobytes() for layer in range(layers) for level in written.levels]
    assert data[HEADER:] == b"".join(parts)


def mipmapped(kind: PixelFormat, layers: int, levels: int) -> Texture:
    """32 x 24 pixels of light."""
    rng = np.random.default_rng(1)
    sizes = [(layers, max(1, 24 >> level), max(1, 32 >> level), 4) for level in range(levels)]
    return encode_texture([np.exp(rng.normal(0, 2, size)) for size in sizes], kind, layers > 1)


def test_what_dds_cannot_hold_is_refused(tmp_path: Path) -> None:
    light = np.ones((1, 6, 8, 3))
    with pytest.raises(InputError, match="RGB9E5 is not written to DDS"):
        write_texture(tmp_path / "a.dds", encode_texture([light], PixelFormat.RGB9E5))
    with pytest.raises(InputError, match="8 x 6 pixels are no whole blocks of 4 x 4"):
        write_texture(tmp_path / "a.dds", encode_texture([light], PixelFormat.BC6H))
    assert not list(tmp_path.iterdir())


def test_pillow_reads_rgba_as_we_do(tmp_path: Path) -> None:
    pixels = random_blocks(PixelFormat.RGBA8)
    write_texture(tmp_path / "a.dds", whole(pixels, PixelFormat.RGBA8))
    with Image.open(tmp_path / "a.dds") as image:
        np.testing.assert_array_equal(np.asarray(image), pixels)


@pytest.mark.parametrize(
    ("kind", "gl_format", "decode", "tolerance"),
    [
        (PixelFormat.BC7, 0x8E8C, decode_bc7, 0),
        (PixelFormat.BC6H, 0x8E8F, decode_bc6h, 0),
        (PixelFormat.BC4, 0x8DBB, decode_bc4, 2.01 / 255),  # Mesa's llvmpipe mixes in eight bits
        (PixelFormat.BC3, 0x83F3, decode_bc3, 2.01 / 255),
        (PixelFormat.RGBA8, GL_RGB9_E5, decode_rgb9e5, 0),
    ],
)
def test_opengl_decodes_as_we_do(
    kind: PixelFormat, gl_format: int, decode: Callable[[Blocks], Floats], tolerance: float
) -> None:
    blocks = random_blocks(kind, 16, 24)
    ours = decode(blocks)
    with moderngl.create_context(standalone=True, backend="egl"):  # type: ignore[arg-type]  # wrong stub
        theirs = drawn_by_opengl(blocks, gl_format)[..., : ours.shape[2]]
    print(f"{kind.name}: {np.mean(theirs == ours):.2%} of the values are the same")
    np.testing.assert_allclose(theirs, ours, rtol=1e-6, atol=tolerance)


def drawn_by_opengl(data: Blocks, gl_format: int) -> Floats:
    """The image (H, W, 4) float32 of blocks, or of packed pixels, given to the context as they are."""
    texture_2d, rgb, rgba, floats, packed = 0x0DE1, 0x1907, 0x1908, 0x1406, 0x8C3E
    opengl = ctypes.CDLL("libGL.so.1")
    side = 1 if gl_format == GL_RGB9_E5 else 4
    height, width = side * data.shape[0], side * data.shape[1]
    bytes_, image = data.tobytes(), np.full((height, width, 4), np.nan, np.float32)
    name = ctypes.c_uint()
    opengl.glGenTextures(1, ctypes.byref(name))
    opengl.glBindTexture(texture_2d, name)
    if gl_format == GL_RGB9_E5:
        opengl.glTexImage2D(texture_2d, 0, gl_format, width, height, 0, rgb, packed, bytes_)
    else:
        opengl.glCompressedTexImage2D(texture_2d, 0, gl_format, width, height, 0, len(bytes_), bytes_)
    opengl.glGetTexImage(texture_2d, 0, rgba, floats, image.ctypes.data_as(ctypes.c_void_p))
    assert opengl.glGetError() == 0
    return image
