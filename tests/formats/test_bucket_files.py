# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake's files in buckets: an atlas, layers and a sidecar that belong together."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.core.errors import BakeError, FormatError, ShapeError
from radtex_addon.formats.bucket_files import read_layer, write_buckets
from radtex_addon.formats.containers.exr import Compression, read_buckets
from radtex_addon.formats.sidecar import Sidecar, read_sidecar

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
