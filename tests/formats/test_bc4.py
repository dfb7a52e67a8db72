# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""BC4 is a channel of BC5, and other programs decode it as we do."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from radtex_addon.core.errors import ShapeError
from radtex_addon.formats.codecs.bc4 import decode_bc4, encode_bc4
from radtex_addon.formats.codecs.bc5 import decode_bc5, encode_bc5
from radtex_addon.formats.containers.dds import DdsFormat, write_dds


def test_it_is_a_channel_of_bc5() -> None:
    image = np.random.default_rng(1).random((16, 24, 2)).astype(np.float32)
    both = encode_bc5(image)
    for channel in range(2):
        blocks = encode_bc4(image[..., channel : channel + 1])
        np.testing.assert_array_equal(blocks, both[..., 8 * channel : 8 * channel + 8])
        np.testing.assert_array_equal(decode_bc4(blocks), decode_bc5(both)[..., channel : channel + 1])


def test_pillow_decodes_as_we_do_but_cuts_off_to_bytes(tmp_path: Path) -> None:
    blocks = np.random.default_rng(2).integers(0, 256, (6, 8, 8), np.uint8)
    write_dds(tmp_path / "a.dds", blocks, DdsFormat.BC4_UNORM)
    with Image.open(tmp_path / "a.dds") as image:
        theirs = np.asarray(image)
    np.testing.assert_array_equal(theirs, np.floor(decode_bc4(blocks)[..., 0] * 255 + 1e-4))


def test_other_shapes_are_refused() -> None:
    with pytest.raises(ShapeError, match=r"\(H, W, 1\) of floats, got \(4, 4, 2\) of float32"):
        encode_bc4(np.zeros((4, 4, 2), np.float32))
    with pytest.raises(ShapeError, match="4"):
        encode_bc4(np.zeros((6, 4, 1), np.float32))
    with pytest.raises(ShapeError, match=r"\(rows, columns, 8\)"):
        decode_bc4(np.zeros((1, 1, 16), np.uint8))
