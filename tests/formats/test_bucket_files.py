# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake's files in buckets belong together, and hold in bands of rows what they hold as a whole."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import OpenEXR
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.core.errors import BakeError, FormatError, ShapeError
from radtex_addon.formats.bucket_files import open_buckets, open_layer, read_layer, write_buckets
from radtex_addon.formats.containers import exr_rows
from radtex_addon.formats.containers.exr import Compression, read_atlas, read_buckets, write_atlas
from radtex_addon.formats.containers.exr_rows import open_rows
from radtex_addon.formats.sidecar import Sidecar, read_sidecar, write_sidecar

FACTS = Sidecar("Vase", "radiance", 3, 2, 4, "UVMap", 1, 0, "portal", "RadTex", "5.2.0")


def noise(*shape: int) -> Floats:
    values: Floats = np.random.default_rng(2).normal(size=shape).astype(np.float16)
    return values


def layers() -> dict[str, Floats]:
    return {"rest": noise(8, 12, 3), "base": noise(2, 3, 3)}


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "Vase.radiance.json"


@pytest.mark.parametrize("compression", list(Compression))
def test_what_is_written_is_read(path: Path, compression: Compression) -> None:
    atlas = np.ones((8, 12, 4))
    written = write_buckets(path, atlas, layers(), FACTS, compression=compression)
    assert written.layers == ("rest", "base")
    assert written == read_sidecar(path)
    np.testing.assert_allclose(read_buckets(path)[0], atlas, atol=1e-3)
    assert np.array_equal(read_layer(path, "rest"), layers()["rest"])  # dwaa too: it is signed
    np.testing.assert_allclose(read_layer(path, "base"), layers()["base"], atol=5e-2)


def test_without_layers_there_are_two_files_and_every_files_clamped_values_are_counted(path: Path) -> None:
    assert write_buckets(path, np.ones((8, 12, 4)), {}, FACTS) == FACTS
    assert {file.name for file in path.parent.iterdir()} == {"Vase.radiance.json", "Vase.radiance.exr"}
    found = layers() | {"rest": np.full((8, 12, 3), -1e6, dtype=np.float32)}
    assert write_buckets(path, np.full((8, 12, 1), 1e6), found, FACTS).clamped == 8 * 12 * 4


@pytest.mark.parametrize("layer", ["", "rest", "base"])
def test_an_image_of_another_size_is_refused_and_nothing_is_written(path: Path, layer: str) -> None:
    named = {"": np.ones((8, 12, 4)), **layers()}
    named[layer] = np.ones((4, 4, 3))
    with pytest.raises(ShapeError, match=r"expected shape .*, got \(4, 4, 3\)"):
        write_buckets(path, named.pop(""), named, FACTS)
    assert list(path.parent.iterdir()) == []


def test_values_that_are_no_numbers_leave_what_was_there(path: Path) -> None:
    write_buckets(path, np.ones((8, 12, 4)), layers(), FACTS)
    before = {file: file.read_bytes() for file in path.parent.iterdir()}
    broken = layers()
    broken["base"][0, 0, 0] = np.nan
    with pytest.raises(BakeError, match=r"Vase\.radiance\.base\.exr was not written: 1 of its values"):
        write_buckets(path, np.zeros((8, 12, 4)), broken, FACTS)
    assert {file: file.read_bytes() for file in path.parent.iterdir()} == before


@pytest.mark.parametrize("name", ["../rest", "sub/rest", "..\\rest", "C:rest", "rest\n", "rest\0", ".."])
def test_a_layer_that_lies_elsewhere_is_refused(name: str, path: Path) -> None:
    write_buckets(path, np.ones((8, 12, 4)), layers(), FACTS)
    sidecar = json.loads(path.read_text(encoding="utf-8"))
    path.write_text(json.dumps(sidecar | {"layers": [name]}), encoding="utf-8")
    with pytest.raises(FormatError, match="no file can be called so") as caught:
        read_layer(path, name)
    assert str(caught.value).isprintable()


def test_a_layer_of_another_bake_or_none_is_refused(path: Path) -> None:
    write_buckets(path, np.ones((8, 12, 4)), layers(), FACTS)
    with pytest.raises(FormatError, match="has no layer glossy: its layers are rest, base"):
        read_layer(path, "glossy")
    other = path.with_name("other.json")
    write_buckets(other, np.full((8, 12, 4), 1e6), layers(), FACTS)
    other.with_name("other.rest.exr").replace(path.with_name("Vase.radiance.rest.exr"))
    with pytest.raises(FormatError, match="is of another bake than"):
        read_layer(path, "rest")


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
        monkeypatch.setattr(exr_rows, "_BAND_BYTES", band_bytes)
        bands = list(image.bands(SIDECAR.bucket))
        assert [first for first, _ in bands] == list(np.cumsum([0, *(len(rows) for _, rows in bands[:-1])]))
        assert all(first % SIDECAR.bucket == 0 for first, _ in bands)
        joined = np.concatenate([rows for _, rows in bands])
        assert joined.dtype == whole.dtype
        np.testing.assert_array_equal(joined, whole)


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
