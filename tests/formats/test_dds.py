# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""DDS files: other programs read them as we do, and bad ones are refused by name."""

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
from radtex_addon.core.errors import FormatError, InputError, ShapeError
from radtex_addon.formats.codecs.bc3 import decode_bc3
from radtex_addon.formats.codecs.bc4 import decode_bc4
from radtex_addon.formats.codecs.bc5 import decode_bc5
from radtex_addon.formats.codecs.bc6h import decode_bc6h
from radtex_addon.formats.codecs.bc7 import Blocks, decode_bc7
from radtex_addon.formats.codecs.rgb9e5 import decode_rgb9e5
from radtex_addon.formats.containers.dds import DdsFormat, read_dds, read_texture, write_dds, write_texture
from radtex_addon.formats.containers.texture import PixelFormat, Texture, encode_texture

HEADER = 148
GL_RGB9_E5 = 0x8C3D


def random_blocks(kind: DdsFormat, rows: int = 6, columns: int = 9, seed: int = 1) -> Blocks:
    """Blocks of the modes that we write, all other bits free; or pixels."""
    blocks = np.random.default_rng(seed).integers(0, 256, (rows, columns, kind.block_bytes), np.uint8)
    if kind in (DdsFormat.BC7_UNORM, DdsFormat.BC7_UNORM_SRGB):
        blocks[..., 0] = (blocks[..., 0] & 0x80) | 0x40
    if kind is DdsFormat.BC6H_UF16:
        blocks[..., 0] = (blocks[..., 0] & 0xE0) | 0b00011
    return blocks


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "a.dds"
    write_dds(path, random_blocks(DdsFormat.BC7_UNORM), DdsFormat.BC7_UNORM)
    return path


def patched(path: Path, offset: int, value: int) -> None:
    data = bytearray(path.read_bytes())
    struct.pack_into("<I", data, offset, value)
    path.write_bytes(data)


@pytest.mark.parametrize("kind", list(DdsFormat))
def test_blocks_come_back_as_they_were(tmp_path: Path, kind: DdsFormat) -> None:
    path, blocks = tmp_path / "new" / "a.dds", random_blocks(kind)
    write_dds(path, blocks[::-1], kind)
    found, read, width, height = read_dds(path)
    np.testing.assert_array_equal(read, blocks[::-1])
    assert (found, width, height) == (kind, 9 * kind.side, 6 * kind.side)
    assert list(path.parent.iterdir()) == [path]
    assert path.stat().st_size == HEADER + blocks.nbytes


@pytest.mark.parametrize(
    ("kind", "flags", "pitch"),
    [
        (DdsFormat.R8G8B8A8_UNORM, 0x100F, 36),
        (DdsFormat.BC4_UNORM, 0x81007, 432),
        (DdsFormat.BC5_UNORM, 0x81007, 864),
        (DdsFormat.BC6H_UF16, 0x81007, 864),
        (DdsFormat.BC7_UNORM, 0x81007, 864),
        (DdsFormat.R16G16B16A16_FLOAT, 0x100F, 72),
    ],
)
def test_the_header_is_as_microsoft_has_it(tmp_path: Path, kind: DdsFormat, flags: int, pitch: int) -> None:
    blocks = random_blocks(kind)
    write_dds(tmp_path / "a.dds", blocks, kind)
    width, height = 9 * kind.side, 6 * kind.side
    header = struct.pack("<4s7I44x", b"DDS ", 124, flags, height, width, pitch, 0, 1)
    header += struct.pack("<2I4s5I", 32, 4, b"DX10", 0, 0, 0, 0, 0)
    header += struct.pack("<5I5I", 0x1000, 0, 0, 0, 0, int(kind), 3, 0, 1, 0)
    assert (tmp_path / "a.dds").read_bytes() == header + blocks.tobytes()


@pytest.mark.parametrize("kind", [PixelFormat.BC6H, PixelFormat.RGBA16F])
@pytest.mark.parametrize(("layers", "levels"), [(1, 1), (1, 3), (3, 1), (3, 6)])
def test_layers_and_levels_come_back(tmp_path: Path, kind: PixelFormat, layers: int, levels: int) -> None:
    """A layer has all its levels before the next."""
    written = mipmapped(kind, layers, levels)
    write_texture(tmp_path / "a.dds", written)
    read = read_texture(tmp_path / "a.dds")
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
    pixels = random_blocks(DdsFormat.R8G8B8A8_UNORM)
    write_dds(tmp_path / "a.dds", pixels, DdsFormat.R8G8B8A8_UNORM)
    with Image.open(tmp_path / "a.dds") as image:
        np.testing.assert_array_equal(np.asarray(image), pixels)


@pytest.mark.parametrize(
    ("kind", "gl_format", "decode", "tolerance"),
    [
        (DdsFormat.BC7_UNORM, 0x8E8C, decode_bc7, 0),
        (DdsFormat.BC6H_UF16, 0x8E8F, decode_bc6h, 0),
        (DdsFormat.BC5_UNORM, 0x8DBD, decode_bc5, 2.01 / 255),  # Mesa's llvmpipe mixes in eight bits
        (DdsFormat.BC4_UNORM, 0x8DBB, decode_bc4, 2.01 / 255),
        (DdsFormat.BC3_UNORM, 0x83F3, decode_bc3, 2.01 / 255),
        (DdsFormat.R8G8B8A8_UNORM, GL_RGB9_E5, decode_rgb9e5, 0),
    ],
)
def test_opengl_decodes_as_we_do(
    kind: DdsFormat, gl_format: int, decode: Callable[[Blocks], Floats], tolerance: float
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


def test_a_size_that_is_no_multiple_of_four_has_whole_blocks(file: Path) -> None:
    patched(file, 12, 22)  # height
    patched(file, 16, 33)  # width
    _, blocks, width, height = read_dds(file)
    assert (width, height, blocks.shape) == (33, 22, (6, 9, 16))


@pytest.mark.parametrize(
    ("offset", "value", "message"),
    [
        (0, 0x20534444 + 1, "not a DDS file"),
        (4, 100, "header cannot be read"),
        (12, 0, "36 x 0 pixels"),
        (12, 16384, "its header says 589972"),  # and no memory is taken
        (16, 16388, "16388 x 24 pixels"),
        (28, 3, "no single 2D texture"),
        (76, 0, "header cannot be read"),
        (80, 0x41, "an older DDS format"),
        (84, 0x35545844, '"DXT5"'),
        (112, 0xFE00, "no single 2D texture"),
        (128, 71, "DXGI format 71: save it as R8G8B8A8_UNORM, BC3_UNORM, BC3_UNORM_SRGB, BC4_UNORM"),
        (132, 4, "no single 2D texture"),
        (136, 4, "no single 2D texture"),
        (140, 6, "no single 2D texture"),
    ],
)
def test_other_files_are_refused_by_name(file: Path, offset: int, value: int, message: str) -> None:
    patched(file, offset, value)
    with pytest.raises(FormatError, match=message) as caught:
        read_dds(file)
    assert str(file) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_impossible_layers_and_levels_are_refused(file: Path) -> None:
    for offset, value, message in (
        *((28, 7, "7 mip levels, expected 1 to 6"), (140, 0, "0 layers")),
        *((140, 9999, "9999 layers"), (140, 3, "cut")),
    ):
        write_texture(file, mipmapped(PixelFormat.BC6H, 2, 6))
        patched(file, offset, value)
        with pytest.raises(FormatError, match=message):
            read_texture(file)


@pytest.mark.parametrize(
    ("shape", "kind"),
    [
        ((4, 4, 4), DdsFormat.BC7_UNORM),
        ((4, 4, 16), DdsFormat.R8G8B8A8_UNORM),
        ((4, 16), DdsFormat.BC6H_UF16),
        ((0, 4, 16), DdsFormat.BC6H_UF16),
        ((1, 4097, 16), DdsFormat.BC6H_UF16),
        ((16385, 1, 4), DdsFormat.R8G8B8A8_UNORM),
    ],
)
def test_blocks_that_cannot_be_stored_are_refused(
    tmp_path: Path, shape: tuple[int, ...], kind: DdsFormat
) -> None:
    with pytest.raises(ShapeError, match=r"a\.dds"):
        write_dds(tmp_path / "a.dds", np.zeros(shape, np.uint8), kind)
    assert not list(tmp_path.iterdir())
