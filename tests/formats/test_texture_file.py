# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A texture that is encoded in bands is the one that is encoded whole, and its files are the same."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
import pytest

from radtex_addon.core.errors import BakeError
from radtex_addon.formats.containers import ktx2
from radtex_addon.formats.containers.dds import write_texture
from radtex_addon.formats.containers.ktx2 import write_ktx2
from radtex_addon.formats.containers.texture import ENCODED, Encoded, PixelFormat, encode_texture
from radtex_addon.formats.containers.texture_file import texture_file
from tests.reference.slices import mip_chain
from tests.reference.textures import read_ktx2


@pytest.mark.parametrize("step", [1, 3, 64])
@pytest.mark.parametrize("kind", ENCODED)
def test_bands_make_the_texture_of_the_whole(tmp_path: Path, kind: PixelFormat, step: int) -> None:
    images = mip_chain(np.random.default_rng(1).random((3, 20, 36, 4), dtype=np.float32))
    whole = encode_texture(images, kind, is_array=True)
    with texture_file(whole.form, tmp_path) as texture:
        for level, image in enumerate(images):
            for first in range(0, image.shape[1], step):
                for layer, rows in enumerate(image[:, first : first + step]):
                    texture.put(level, layer, first, rows)
        assert same_files(whole, texture, tmp_path)
    assert list(tmp_path.iterdir()) == []


def same_files(ours: Encoded, theirs: Encoded, folder: Path) -> bool:
    """Whether two textures make the same files, which are removed."""
    found = []
    for texture in (ours, theirs):
        paths = [folder / "a.ktx2", folder / "b.ktx2", folder / "c.dds"]
        write_ktx2(paths[0], texture)
        write_ktx2(paths[1], texture, zstd=False)
        if texture.form.format is not PixelFormat.RGB9E5:  # which DDS does not know
            write_texture(paths[2], texture)
        found.append([path.read_bytes() for path in paths if path.exists()])
        for path in paths:
            path.unlink(missing_ok=True)
    return found[0] == found[1]


def test_a_large_level_is_packed_as_it_comes_and_unpacks_to_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    image = np.random.default_rng(2).random((2, 300, 500, 3), dtype=np.float32)
    texture = encode_texture([image], PixelFormat.RGB9E5, is_array=True)
    monkeypatch.setattr(ktx2, "_AT_ONCE", 1000)
    write_ktx2(tmp_path / "a.ktx2", texture)
    read = read_ktx2(tmp_path / "a.ktx2")
    np.testing.assert_array_equal(read.levels[0], texture.levels[0])


@pytest.mark.parametrize("zstd", [None, False, True], ids=["DDS", "KTX2", "KTX2, zstd"])
def test_a_failed_write_leaves_nothing(zstd: bool | None, tmp_path: Path) -> None:
    image = np.random.default_rng(3).random((2, 24, 36, 3), dtype=np.float32)
    texture, path = encode_texture([image], PixelFormat.BC6H, is_array=True), tmp_path / "a.bin"
    path.mkdir()
    write = write_texture if zstd is None else partial(write_ktx2, zstd=zstd)
    with pytest.raises(BakeError, match=r"a\.bin could not be written"):
        write(path, texture)
    assert list(tmp_path.iterdir()) == [path]
