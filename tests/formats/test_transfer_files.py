# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A transfer bake's files: what is written is read, and what is not ours is refused."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.core.errors import BakeError, FormatError, ShapeError
from radtex_addon.formats.sidecar import Sidecar, read_sidecar
from radtex_addon.formats.transfer_files import TransferSidecar, read_transfer, write_transfer

FACTS = TransferSidecar(
    Sidecar("Wax", "transfer", 3, 2, 4, "UVMap", 16, 0, "portal", "RadTex test", "5.2.0"), suns=16
)


def pixels(seed: int = 1) -> Floats:
    return np.random.default_rng(seed).random((8, 12, 4)).astype(np.float32)


@pytest.mark.parametrize("half", [True, False])
def test_what_is_written_is_read(tmp_path: Path, half: bool) -> None:
    path, image = tmp_path / "Wax.transfer.json", pixels()
    image[0, 0, 0] = 1e5
    written = write_transfer(path, image, FACTS, half)
    assert {file.name for file in tmp_path.iterdir()} == {"Wax.transfer.json", "Wax.transfer.exr"}
    found, facts = read_transfer(path)
    assert facts == written
    assert facts.bake.clamped == int(half)
    expected = np.minimum(image, 65504).astype(np.float16) if half else image
    np.testing.assert_array_equal(found, expected)
    told = json.loads(path.read_text())
    assert (told["kind"], told["layout"], told["bucket"]) == ("transfer", "sphere", 4)
    assert told["transfer"] == {"view": "normal", "suns": 16}
    with pytest.raises(FormatError, match='"layout" is "sphere", expected "buckets"'):
        read_sidecar(path)  # who knows hemispherical buckets alone


@pytest.mark.parametrize(
    ("view", "more", "bad", "says"),
    [
        ("camera", {"eye": (1.0, -4.5, 0.5, 1.0)}, {"eye": [1, 2, 3]}, '"eye" is .*, expected 4 numbers'),
        ("around", {"views": 2}, {"views": 1}, '"views" is 1, expected a whole number from 2 to 16'),
    ],
)
def test_views_are_written_and_read(tmp_path: Path, view: str, more: Any, bad: Any, says: str) -> None:
    path, sidecar = tmp_path / "Wax.transfer.json", replace(FACTS, view=view, **more)
    image = np.tile(pixels(), (sidecar.views, sidecar.views, 1))
    write_transfer(path, image, sidecar)
    found, facts = read_transfer(path)
    assert facts == sidecar
    np.testing.assert_array_equal(found, image.astype(np.float16))
    wrong = json.loads(path.read_text())
    wrong["transfer"] |= bad
    path.write_text(json.dumps(wrong))
    with pytest.raises(FormatError, match=says):
        read_transfer(path)
    del wrong["transfer"][next(iter(bad))]
    path.write_text(json.dumps(wrong))
    with pytest.raises(FormatError, match="lacks"):
        read_transfer(path)


def test_another_view_or_bake_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "Wax.transfer.json"
    write_transfer(path, pixels(), FACTS)
    text = path.read_text()
    path.write_text(text.replace('"normal"', '"cells"'))
    with pytest.raises(FormatError, match='"view" is "cells", expected normal or camera or around'):
        read_transfer(path)
    path.write_text(text.replace('"suns": 16', '"suns": 17'))
    with pytest.raises(FormatError, match=r"Wax.transfer.exr is of another bake than"):
        read_transfer(path)


def test_nothing_is_written_of_what_cannot_be(tmp_path: Path) -> None:
    path = tmp_path / "Wax.transfer.json"
    with pytest.raises(ShapeError, match="transfer atlas: expected shape"):
        write_transfer(path, pixels()[1:], FACTS)
    broken = pixels()
    broken[3, 3] = np.nan
    with pytest.raises(BakeError, match="4 of its values are not numbers"):
        write_transfer(path, broken, FACTS)
    assert not list(tmp_path.iterdir())
