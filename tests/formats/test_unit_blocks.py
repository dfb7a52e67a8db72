# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Values in 0..1 in blocks come back, through files and other programs' decoders as well."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from radtex_addon.core.arrays import Floats
from radtex_addon.core.errors import InputError, ShapeError
from radtex_addon.formats.codecs.srgb import to_srgb
from radtex_addon.formats.containers.dds import write_texture
from radtex_addon.formats.containers.ktx2 import write_ktx2
from radtex_addon.formats.containers.texture import PixelFormat
from radtex_addon.formats.containers.unit_blocks import CHANNELS, decode_units, encode_units
from tests.reference.textures import read_dds, read_ktx2

SRGB = (PixelFormat.BC3_SRGB, PixelFormat.BC7_SRGB)


def smooth(height: int, width: int, channels: int, levels: int = 1) -> tuple[Floats, ...]:
    """Mip levels (H, W, C) of a wave from 0.02 to 0.98 that all channels share, each weaker than the last."""
    made = []
    for level in range(levels):
        rows, columns = max(1, height >> level), max(1, width >> level)
        y, x = np.mgrid[:rows, :columns] / max(height, width) * 2.0**level
        wave = 0.5 + 0.48 * np.sin(5 * x) * np.cos(4 * y)
        made.append((wave[..., None] * np.linspace(1, 0.7, channels)).astype(np.float32))
    return tuple(made)


@pytest.mark.parametrize("kind", CHANNELS)
def test_levels_come_back_through_files(tmp_path: Path, kind: PixelFormat) -> None:
    """Also those that are smaller than a block."""
    levels = smooth(24, 32, CHANNELS[kind], 6)
    texture = encode_units(levels, kind)
    write_texture(tmp_path / "a.dds", texture)
    for zstd in (False, True):
        write_ktx2(tmp_path / f"{zstd}.ktx2", texture, zstd)
    read = [read_dds(tmp_path / "a.dds"), *map(read_ktx2, sorted(tmp_path.glob("*.ktx2")))]
    for found in read:
        assert (found.format, found.width, found.height) == (kind, 32, 24)
        for ours, theirs in zip(texture.levels, found.levels, strict=True):
            np.testing.assert_array_equal(theirs, ours)
        for image, decoded in zip(levels, decode_units(found), strict=True):
            assert decoded.shape == image.shape
            assert np.sqrt(np.mean((decoded - image) ** 2)) < 0.07


@pytest.mark.parametrize("kind", [PixelFormat.BC3, PixelFormat.BC7, PixelFormat.BC7_SRGB])
def test_pillow_finds_the_codes(tmp_path: Path, kind: PixelFormat) -> None:
    """It decodes no sRGB: what it finds are the codes; in BC3 it rounds what lies between colours."""
    texture = encode_units(smooth(16, 32, 4), kind)
    write_texture(tmp_path / "a.dds", texture)
    (decoded,) = decode_units(texture)
    if kind in SRGB:
        decoded = np.dstack([to_srgb(decoded[..., :3]), decoded[..., 3]])
    with Image.open(tmp_path / "a.dds") as image:
        theirs = np.asarray(image) / 255
    np.testing.assert_allclose(theirs, decoded, atol=2.5 / 255 if "BC3" in kind else 0.5 / 255)


def test_srgb_is_finer_in_the_dark() -> None:
    dark = (smooth(16, 16, 4)[0] * 0.004,)
    off = [
        np.abs(decode_units(encode_units(dark, kind))[0] - dark[0])[..., :3].max()
        for kind in (PixelFormat.BC7, PixelFormat.BC7_SRGB)
    ]
    assert off[1] < 0.3 * off[0]


def test_bands_are_encoded_as_the_whole_is() -> None:
    """An image of more pixels than are encoded at once, and its last, incomplete row of blocks."""
    image = smooth(1022, 512, 4)[0]
    (blocks,) = encode_units((image,), PixelFormat.BC3).levels
    assert blocks.shape == (1, 256, 128, 16)
    (last,) = encode_units((image[-2:],), PixelFormat.BC3).levels
    np.testing.assert_array_equal(blocks[:, -1:], last)
    (early,) = encode_units((image[508:516],), PixelFormat.BC3).levels
    np.testing.assert_array_equal(blocks[:, 127:129], early)


def test_what_does_not_fit_is_refused() -> None:
    with pytest.raises(InputError, match=r"BC6H does not hold values in 0\.\.1: choose BC3"):
        encode_units(smooth(4, 4, 3), PixelFormat.BC6H)
    with pytest.raises(ShapeError, match=r"expected shape \(H, W, 4\), got \(4, 4, 3\)"):
        encode_units(smooth(4, 4, 3), PixelFormat.BC7)
    wrong = smooth(4, 4, 4)[0].copy()
    wrong[0, 0, 0] = np.nan
    with pytest.raises(InputError, match="not numbers"):
        encode_units((wrong,), PixelFormat.BC7)
