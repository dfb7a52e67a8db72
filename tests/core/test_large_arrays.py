# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Arrays in files: the same values as in memory, no files left, and a full disk is told of."""

from __future__ import annotations

import errno
import os
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from radtex_addon.core import large_arrays
from radtex_addon.core.errors import BakeError


@pytest.fixture(autouse=True)
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(large_arrays, "LEAST", 1 << 16)


def in_memory() -> int:
    """Bytes of this process that lie in no file."""
    (line,) = (each for each in Path("/proc/self/status").read_text().splitlines() if "RssAnon" in each)
    return int(line.split()[1]) << 10


@pytest.mark.skipif(sys.platform != "linux", reason="/proc")
def test_large_arrays_take_no_memory_in_files_and_leave_nothing(tmp_path: Path) -> None:
    before = in_memory()
    with large_arrays.arrays_in_files(tmp_path):
        large = large_arrays.zeros((1 << 12, 1 << 12))
        large += 1
        assert in_memory() - before < large.nbytes // 8
        assert large.sum() == large.size
    assert not list(tmp_path.iterdir())
    assert large[-1, -1] == 1  # it may be read after the context
    plain = large_arrays.zeros((1 << 12, 1 << 12))
    plain += 1
    assert in_memory() - before > plain.nbytes // 2


def made() -> list[Any]:
    """One of each kind of array."""
    values = np.random.default_rng(1).random((70_000, 3), dtype=np.float32)
    mask = values[:, 0] > 0.5
    some = large_arrays.flatnonzero(len(values), lambda block: mask[block])
    return [
        large_arrays.from_blocks(len(values), lambda block: values[block] * 2, most=999),
        large_arrays.taken(values, some),
        some,
        large_arrays.concatenated([values, values[:5]]),
        large_arrays.stacked(values[:, :2] * number for number in range(4)),
        large_arrays.as_type(values, np.float16),
        large_arrays.copied(values[::2]),
        large_arrays.stowed(values),
        large_arrays.from_blocks(0, lambda block: values[block]),
        large_arrays.flatnonzero(0, lambda block: mask[block]),
    ]


def test_values_are_the_same_in_files_and_as_numpy_makes_them(tmp_path: Path) -> None:
    expected = made()
    with large_arrays.arrays_in_files(tmp_path):
        found = made()
    for ours, theirs in zip(found, expected, strict=True):
        assert ours.dtype == theirs.dtype
        np.testing.assert_array_equal(ours, theirs)
    values = expected[7]
    np.testing.assert_array_equal(expected[0], values * 2)
    np.testing.assert_array_equal(expected[2], np.flatnonzero(values[:, 0] > 0.5))
    np.testing.assert_array_equal(expected[4][:, 3], values[:, :2] * 3)


def test_small_arrays_stay_in_memory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tempfile, "TemporaryFile", None)
    with large_arrays.arrays_in_files(tmp_path):
        assert large_arrays.empty(1 << 13).nbytes == 1 << 15
        with pytest.raises(TypeError):
            large_arrays.empty(1 << 14)


@pytest.mark.skipif(not hasattr(os, "posix_fallocate"), reason="reserves otherwise")
def test_a_full_disk_is_told_of(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "posix_fallocate", full)
    with large_arrays.arrays_in_files(tmp_path), pytest.raises(BakeError) as caught:
        large_arrays.empty(1 << 22)
    assert str(caught.value) == (
        f"{tmp_path} has no room for 16 MiB of samples: No space left on device: free its disk, or choose "
        "another folder, or allow more memory"
    )
    assert not list(tmp_path.iterdir())
