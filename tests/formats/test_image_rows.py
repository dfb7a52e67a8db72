# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Images read in bands hold what they hold as a whole; damaged ones are refused by name."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import OpenEXR
import pytest

from radtex_addon.core.errors import FormatError
from radtex_addon.formats.bucket_rows import open_buckets, open_layer
from radtex_addon.formats.containers import image_rows
from radtex_addon.formats.containers.exr import Compression, read_atlas, write_atlas
from radtex_addon.formats.containers.image_rows import open_rows
from radtex_addon.formats.sidecar import Sidecar, write_sidecar

SIDECAR = Sidecar("Cube", "radiance", 24, 10, 6, "RadTex", 16, 0, "portal", "RadTex 0.1.0", "5.2.3")
HEIGHT, WIDTH = 60, 144


def written(path: Path, channels: int, half: bool = True, packing: Compression = Compression.ZIP) -> None:
    pixels = np.random.default_rng(1).random((HEIGHT, WIDTH, channels), dtype=np.float32)
    write_sidecar(path.with_suffix(".json"), write_atlas(path, pixels, SIDECAR, half, packing))


@pytest.mark.parametrize("packing", list(Compression))
@pytest.mark.parametrize(("channels", "half"), [(1, True), (3, False), (4, True), (4, False)])
def test_bands_are_the_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, packing: Compression, channels: int, half: bool
) -> None:
    path = tmp_path / "a.exr"
    written(path, channels, half, packing)
    whole, sidecar = read_atlas(path)
    image, facts = open_buckets(path.with_suffix(".json"))
    assert (facts, image.channels) == (sidecar, channels)
    for band_bytes in (1, WIDTH * channels * 4 * 13, 1 << 24):
        monkeypatch.setattr(image_rows, "_BAND_BYTES", band_bytes)
        bands = list(image.bands(SIDECAR.bucket))
        assert [first for first, _ in bands] == list(np.cumsum([0, *(len(rows) for _, rows in bands[:-1])]))
        assert all(first % SIDECAR.bucket == 0 for first, _ in bands)
        joined = np.concatenate([rows for _, rows in bands])
        assert joined.dtype == whole.dtype
        np.testing.assert_array_equal(joined, whole)


def test_a_file_that_is_cut_short_or_damaged_is_refused(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "a.exr"
    written(path, 4)
    data = path.read_bytes()
    for broken in (data[: len(data) * 3 // 4], data[:-4000] + bytes(2000) + data[-2000:]):
        path.write_bytes(broken)
        with pytest.raises(FormatError, match=r"a\.exr is damaged: ") as caught:
            list(open_rows(path, WIDTH, HEIGHT).bands())
        assert "\n" not in str(caught.value)
    assert capfd.readouterr() == ("", "")


def test_an_image_of_another_size_or_make_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.exr"
    written(path, 4)
    with pytest.raises(FormatError, match=r"a\.exr has 144 x 60 pixels, .* 144 x 66 floats"):
        open_rows(path, WIDTH, HEIGHT + 6)
    with pytest.raises(FormatError, match="has the channels A, B, G, R, expected RGB"):
        open_rows(path, WIDTH, HEIGHT, [3])
    pixels = np.zeros((HEIGHT, WIDTH), np.uint32)
    OpenEXR.File({"type": OpenEXR.scanlineimage}, {"Y": pixels}).write(str(path))
    with pytest.raises(FormatError, match=r"its channels are not all half floats, or all floats"):
        open_rows(path, WIDTH, HEIGHT)


def test_files_of_two_bakes_and_unknown_layers_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    written(path.with_suffix(".exr"), 4)
    write_sidecar(path, replace(SIDECAR, seed=7))
    with pytest.raises(FormatError, match=r"a\.exr is of another bake than .*a\.json"):
        open_buckets(path)
    with pytest.raises(FormatError, match=r"a\.json has no layer rest: its layers are none"):
        open_layer(path, "rest")
