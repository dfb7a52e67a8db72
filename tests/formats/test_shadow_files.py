# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The file of shadows: bits to disk and back, and what is no such file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR
import pytest

from radtex_addon.core.errors import BakeError, FormatError, InputError, ShapeError
from radtex_addon.core.shadow import word_count
from radtex_addon.formats.containers.exr import ATTRIBUTE, Compression, write_atlas
from radtex_addon.formats.shadow_files import Words, read_shadow, read_shadow_of, write_shadow
from radtex_addon.formats.sidecar import Sidecar, write_sidecar

FACTS = Sidecar("Vase", "shadow", 5, 3, 8, "RadTex", 1, 0, "portal", "RadTex", "5.2")


def random_words(facts: Sidecar = FACTS) -> Words:
    shape = (facts.height, facts.width, word_count(facts.bucket))
    return np.random.default_rng(2).integers(0, 2**32, shape, dtype=np.uint32)


@pytest.mark.parametrize("bucket", [4, 8, 16, 40])
@pytest.mark.parametrize("compression", [Compression.ZIP, Compression.PIZ])
def test_every_bit_comes_back(tmp_path: Path, bucket: int, compression: Compression) -> None:
    facts, path = replace(FACTS, bucket=bucket), tmp_path / "Vase.shadow.exr"
    words = random_words(facts)
    write_shadow(path, words, facts, compression)
    found, inner = read_shadow(path)
    np.testing.assert_array_equal(found, words)
    assert found.dtype == np.uint32
    assert inner == facts
    write_sidecar(path.with_suffix(".json"), facts)
    np.testing.assert_array_equal(read_shadow_of(path.with_suffix(".json"))[0], words)


def test_another_reader_finds_the_channels_in_order_and_the_top_row_first(tmp_path: Path) -> None:
    path, words = tmp_path / "Vase.shadow.exr", random_words()
    write_shadow(path, words, FACTS)
    channels = OpenEXR.File(str(path)).channels()
    assert list(channels) == ["word0000", "word0001"]
    for index, channel in enumerate(channels.values()):
        assert channel.type() == OpenEXR.UINT
        np.testing.assert_array_equal(channel.pixels, words[::-1, :, index])


def test_only_a_shadow_is_read(tmp_path: Path) -> None:
    path = tmp_path / "Vase.shadow.exr"
    write_atlas(path, np.zeros((24, 40, 4)), replace(FACTS, kind="radiance"))
    with pytest.raises(FormatError, match="kind radiance, not shadow"):
        read_shadow(path)
    write_atlas(path, np.zeros((24, 40, 4)), FACTS)
    with pytest.raises(FormatError, match="channels A, B, G, R, expected word0000, word0001"):
        read_shadow(path)


@pytest.mark.parametrize(
    ("facts", "dtype", "said"),
    [
        (replace(FACTS, bucket=9), np.uint32, "expected word0000, word0001, word0002"),
        (replace(FACTS, width=4), np.uint32, "5 x 3 pixels of uint32, its header says 4 x 3"),
        (FACTS, np.float32, "pixels of float32"),
    ],
)
def test_a_header_that_says_otherwise_is_found_out(
    tmp_path: Path, facts: Sidecar, dtype: type[Any], said: str
) -> None:
    path, words = tmp_path / "Vase.shadow.exr", random_words()
    channels = {f"word{k:04d}": words[..., k].astype(dtype) for k in range(2)}
    header = {ATTRIBUTE: facts.to_json(), "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, channels).write(str(path))
    with pytest.raises(FormatError, match=said):
        read_shadow(path)


def test_files_of_two_bakes_are_told_apart(tmp_path: Path) -> None:
    path = tmp_path / "Vase.shadow.exr"
    write_shadow(path, random_words(), FACTS)
    write_sidecar(path.with_suffix(".json"), replace(FACTS, seed=1))
    with pytest.raises(FormatError, match="of another bake"):
        read_shadow_of(path.with_suffix(".json"))


def test_what_cannot_be_written_leaves_what_was(tmp_path: Path) -> None:
    path = tmp_path / "Vase.shadow.exr"
    path.write_bytes(b"before")
    with pytest.raises(InputError, match="dwaa keeps no bits"):
        write_shadow(path, random_words(), FACTS, Compression.DWAA)
    with pytest.raises(ShapeError, match=r"expected \(3, 5, 2\) of uint32"):
        write_shadow(path, random_words().astype(np.int64), FACTS)
    assert path.read_bytes() == b"before"
    blocked = tmp_path / "folder" / "Vase.shadow.exr"
    blocked.parent.write_bytes(b"")
    with pytest.raises(BakeError, match="could not be written"):
        write_shadow(blocked, random_words(), FACTS)
    assert [item.name for item in tmp_path.iterdir() if item.name.startswith(".radtex")] == []
