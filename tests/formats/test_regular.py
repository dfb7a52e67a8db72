# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Only regular files are read, and no more of them than any of ours has: nothing waits or fills memory."""

from __future__ import annotations

import os
import signal
import socket
import sys
from collections.abc import Iterator
from pathlib import Path
from types import FrameType

import numpy as np
import pytest

from radtex_addon.core.errors import BakeError, FormatError, RadTexError
from radtex_addon.formats.disk.regular import MOST_TEXT, open_regular, other_kind, read_regular
from radtex_addon.store.checkpoint import Checkpoint
from tests.fuzz.corpus import FACTS, make_corpus
from tests.fuzz.readers import READERS

if sys.platform != "win32":
    import resource

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such files")
_HANG = 10  # seconds


@pytest.fixture(scope="module")
def corpus(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("corpus")
    make_corpus(folder)
    return folder


@pytest.fixture(autouse=True)
def _no_waiting() -> Iterator[None]:
    def waits(_number: int, _frame: FrameType | None) -> None:
        raise AssertionError("it waits")

    before = signal.signal(signal.SIGALRM, waits)
    signal.alarm(_HANG)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


@pytest.mark.parametrize("name", READERS)
def test_no_reader_waits_for_a_pipe(name: str, corpus: Path) -> None:
    path = corpus / READERS[name].target
    kept = path.read_bytes()
    path.unlink()
    os.mkfifo(path)
    said = _said(name, path)
    path.unlink()
    path.write_bytes(kept)
    assert "pipe" in said or "holds no farm" in said or name in ("piece", "key", "assemble-frame")


def _said(name: str, path: Path) -> str:
    """What a reader complains of; a piece that is none is made again."""
    try:
        READERS[name].read(path)
    except RadTexError as error:
        return str(error)
    return ""


def _most_memory() -> int:
    """The most bytes of memory that this process had so far."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)


@pytest.mark.parametrize("where", ["sidecar", "glb", "key", "piece"])
def test_a_sparse_file_takes_no_memory(where: str, corpus: Path) -> None:
    path = corpus / READERS[where].target
    kept = path.read_bytes()
    before = _most_memory()
    os.truncate(path, 1 << 29)
    said = _said(where, path)
    path.write_bytes(kept)
    assert path.name in said or where == "piece"
    assert _most_memory() - before < 100 << 20


def test_a_text_of_too_many_values_is_refused(corpus: Path) -> None:
    path = corpus / "many.json"
    path.write_text('{"a": [' + "{}," * 2_000_000 + "{}]}")
    with pytest.raises(FormatError, match=r"many\.json has more values"):
        READERS["sidecar"].read(path)


def test_what_is_no_file_is_named_by_its_kind(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "link").symlink_to(tmp_path / "pipe")
    (tmp_path / "file").write_bytes(b"abc")
    (tmp_path / "to file").symlink_to(tmp_path / "file")
    with socket.socket(socket.AF_UNIX) as bound:
        bound.bind(str(tmp_path / "socket"))
        kinds = {"pipe": "a pipe", "link": "a pipe", "socket": "a socket", ".": "a folder"}
        for name, kind in kinds.items():
            assert other_kind(tmp_path / name) == kind
            with pytest.raises(OSError, match=f"it is {kind} and no file"):
                open_regular(tmp_path / name)
    assert other_kind(Path("/dev/zero")) == "a device"
    assert other_kind(tmp_path / "nothing") is None
    assert read_regular(tmp_path / "to file") == b"abc"
    assert read_regular(tmp_path / "file", 3) == b"abc"
    with pytest.raises(OSError, match="it has 3 bytes, and nothing of its kind more than 2 bytes"):
        read_regular(tmp_path / "file", 2)
    with pytest.raises(OSError, match="device"):
        read_regular(Path("/dev/zero"), MOST_TEXT)


@pytest.mark.parametrize(
    "harm", ["cut", "header", "fewer", "other", "pipe"], ids=lambda harm: f"a piece that is {harm}"
)
def test_rows_of_a_piece_that_is_no_more_what_it_was_are_refused(harm: str, tmp_path: Path) -> None:
    kept = Checkpoint(tmp_path / "bake.radtex-unfinished", resume=False)
    kept.set_facts(FACTS)
    kept.keep("tile", {"cells": np.arange(32, dtype=np.float32).reshape(8, 4)})
    np.testing.assert_array_equal(kept.rows("tile", "cells", 2, 1), [[8, 9, 10, 11]])
    path = tmp_path / "bake.radtex-unfinished" / "tile.piece"
    data = path.read_bytes()
    if harm == "cut":
        path.write_bytes(data[:60])
    elif harm == "header":
        path.write_bytes(data.replace(b"'descr'", b"'decsr'"))
    elif harm == "fewer":
        path.write_bytes(data.replace(b"(8, 4)", b"(2, 4)"))
    elif harm == "other":
        path.write_bytes(data.replace(b'"cells"', b'"seeds"'))
    else:
        path.unlink()
        os.mkfifo(path)
    with pytest.raises(BakeError, match=r"tile\.piece can no longer be read: .*; bake again"):
        kept.rows("tile", "cells", 2, 4)
