# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Pieces of a bake as files: named arrays, after a first line that says which bake and piece they belong to.

A file ends with a digest of everything before, so that half-written or damaged files are noticed.
"""

from __future__ import annotations

import hashlib
import json
import os
from math import prod
from pathlib import Path
from typing import Any, BinaryIO, TypeAlias

import numpy as np
import numpy.typing as npt

from ..formats.disk.regular import MOST_TEXT, open_regular

Arrays: TypeAlias = dict[str, npt.NDArray[Any]]

PIECE = ".piece"
_DIGEST_BYTES = 32
_CHUNK = 1 << 22  # bytes
_FORMAT: Any = np.lib.format  # older stubs leave it untyped


def write_piece(path: Path, mark: dict[str, str], arrays: Arrays) -> None:
    """Write a piece with the label `mark`."""
    with path.open("wb") as stream:
        hashing = _Hashing(stream)
        hashing.write((json.dumps({**mark, "arrays": list(arrays)}) + "\n").encode())
        for array in arrays.values():
            _FORMAT.write_array(hashing, array, allow_pickle=False)
        stream.write(hashing.digest())


def read_piece(path: Path, mark: dict[str, str]) -> Arrays:
    """Read the piece with the label `mark`.

    Raises OSError, such as FileNotFoundError, and any other error if it is another piece or damaged.
    """
    with open_regular(path) as stream:
        end = left = os.fstat(stream.fileno()).st_size - _DIGEST_BYTES
        found = hashlib.sha256()
        while left > 0 and (chunk := stream.read(min(_CHUNK, left))):
            found.update(chunk)
            left -= len(chunk)
        if left or stream.read() != found.digest():
            raise ValueError("its digest is wrong")
        stream.seek(0)
        says = json.loads(stream.readline(MOST_TEXT))
        names = says.pop("arrays")
        if says != mark:
            raise ValueError("it is of another bake")
        return {name: _read_array(stream, end) for name in names}


def _read_array(stream: BinaryIO, end: int) -> npt.NDArray[Any]:
    """Read an array that ends before `end`; its header is checked before memory is allocated."""
    place = stream.tell()
    _array_header(stream, end)
    stream.seek(place)
    array: npt.NDArray[Any] = _FORMAT.read_array(stream, allow_pickle=False)
    return array


def read_rows(path: Path, array: str, first: int, count: int) -> npt.NDArray[Any]:
    """Read rows of an array from a piece that was complete before; the digest is not checked again.

    Raises OSError, and any other error if the file is damaged now.
    """
    with open_regular(path) as stream:
        end = os.fstat(stream.fileno()).st_size - _DIGEST_BYTES
        before = json.loads(stream.readline(MOST_TEXT))["arrays"].index(array)
        shape, dtype = _array_header(stream, end)
        for _ in range(before):
            stream.seek(prod(shape) * dtype.itemsize, os.SEEK_CUR)
            shape, dtype = _array_header(stream, end)
        if not 0 <= first <= first + count <= shape[0]:
            raise ValueError("it has other rows")
        stream.seek(first * prod(shape[1:]) * dtype.itemsize, os.SEEK_CUR)
        found: npt.NDArray[Any] = np.fromfile(stream, dtype, count * prod(shape[1:]))
        if found.size != count * prod(shape[1:]):
            raise OSError("it has become shorter")
        return found.reshape(count, *shape[1:])


def _array_header(stream: BinaryIO, end: int) -> tuple[tuple[int, ...], np.dtype[Any]]:
    """Shape and type of an array that must end before `end`. Raises ValueError if it does not."""
    version = _FORMAT.read_magic(stream)
    shape, _, dtype = _FORMAT.read_array_header_1_0(stream)
    if version != (1, 0) or min(shape, default=0) < 0 or prod(shape) * dtype.itemsize > end - stream.tell():
        raise ValueError("an array in it is not of its size")
    return shape, dtype


class _Hashing:
    """Writes to a stream, and computes the digest of what was written."""

    def __init__(self, stream: BinaryIO) -> None:
        self._stream, self._hash = stream, hashlib.sha256()

    def write(self, data: bytes) -> int:
        self._hash.update(data)
        return self._stream.write(data)

    def digest(self) -> bytes:
        return self._hash.digest()
