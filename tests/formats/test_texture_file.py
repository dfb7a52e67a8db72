# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A texture that is encoded in bands is the one that is encoded whole, and its files are the same."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from radtex_addon.core.errors import BakeError, FormatError
from radtex_addon.formats.containers import ktx2
from radtex_addon.formats.containers.dds import read_texture, write_texture
from radtex_addon.formats.containers.ktx2 import read_ktx2, write_ktx2
from radtex_addon.formats.containers.texture import ENCODED, Encoded, PixelFormat, encode_texture
from radtex_addon.formats.containers.texture_file import texture_file
from tests.reference.slices import mip_chain


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
def test_what_is_no_whole_file_is_refused_and_a_failed_write_leaves_nothing(
    zstd: bool | None, tmp_path: Path
) -> None:
    image = np.random.default_rng(3).random((2, 24, 36, 3), dtype=np.float32)
    texture, path = encode_texture([image], PixelFormat.BC6H, is_array=True), tmp_path / "a.bin"
    read = read_texture if zstd is None else read_ktx2

    def write() -> None:
        if zstd is None:
            write_texture(path, texture)
        else:
            write_ktx2(path, texture, zstd)

    write()
    whole = path.read_bytes()
    for length in (0, 3, 5, 12, 60, 79, 100, 147, 148, 200, len(whole) - 1):
        path.write_bytes(whole[:length])
        with pytest.raises(FormatError, match=r"a\.bin is (cut short|not a (DDS|KTX2) file)"):
            read(path)
    path.write_bytes(whole + b"x")
    with pytest.raises(FormatError, match=r"a\.bin has more in it"):
        read(path)
    path.unlink()
    for missing in (path, tmp_path):
        with pytest.raises(FormatError, match="cannot be read"):
            read(missing)
    path.mkdir()
    with pytest.raises(BakeError, match=r"a\.bin could not be written"):
        write()
    assert list(tmp_path.iterdir()) == [path]
