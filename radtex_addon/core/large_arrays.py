# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Arrays that may be larger than memory: within `arrays_in_files` they lie in temporary files.

The system writes their pages out, and reads them again, as memory allows. To NumPy they are arrays as any
other, so that what is computed with them is the same to the bit. The files have no names, or lose them with
the array: they go with the last reference to it, and with the process.
"""

from __future__ import annotations

import mmap
import os
import shutil
import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from math import prod
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from .arrays import Bools, Ints, blocks
from .errors import BakeError
from .messages import Setting, do

_Array: TypeAlias = npt.NDArray[Any]

LEAST = 8 << 20  # bytes: smaller arrays stay in memory
AT_ONCE = 1 << 18  # rows that are computed at once


@dataclass(frozen=True)
class _Files:
    folder: Path
    least: int


_open: list[_Files] = []  # the last one is used


@contextmanager
def arrays_in_files(folder: Path) -> Iterator[None]:
    """Put large arrays that are made meanwhile into files in `folder`."""
    files = _Files(folder, LEAST)
    _open.append(files)
    try:
        yield
    finally:
        _open.remove(files)


def empty(shape: int | Sequence[int], dtype: npt.DTypeLike = np.float32) -> _Array:
    """As `numpy.empty`. Raises BakeError where the disk has no room."""
    files = _files_for(shape, dtype)
    return np.empty(shape, dtype) if files is None else _in_file(files.folder, shape, dtype)


def zeros(shape: int | Sequence[int], dtype: npt.DTypeLike = np.float32) -> _Array:
    """As `numpy.zeros`. Raises as `empty`."""
    files = _files_for(shape, dtype)
    return np.zeros(shape, dtype) if files is None else _in_file(files.folder, shape, dtype)


def from_blocks(count: int, compute: Callable[[slice], _Array], most: int = AT_ONCE) -> _Array:
    """An array of `count` rows, which are computed block by block, at most so many at once.

    Raises as `empty`.
    """
    step = min(count, most)
    first = compute(slice(0, step))
    if step == count:
        return stowed(first)
    found = empty((count, *first.shape[1:]), first.dtype)
    found[:step] = first
    for some in blocks(count, most):
        if some.start:
            found[some] = compute(some)
    return found


def taken(values: _Array, which: Ints) -> _Array:
    """Some rows of an array, by their numbers. Raises as `empty`."""
    return from_blocks(len(which), lambda some: values[which[some]])


def flatnonzero(count: int, mask: Callable[[slice], Bools]) -> Ints:
    """The numbers of those of `count` rows for which the mask of a block of them is True, ascending.

    Raises as `empty`.
    """
    kind = np.int32 if count < 2**31 else np.int64
    return concatenated(
        [(np.flatnonzero(mask(some)) + some.start).astype(kind) for some in blocks(count, AT_ONCE)]
        or [np.empty(0, kind)]
    )


def stacked(parts: Iterable[_Array]) -> _Array:
    """As `numpy.stack` along the second axis, of arrays (N, C) of one type. Raises as `empty`."""
    kept = [stowed(part) for part in parts]
    found = empty((len(kept[0]), len(kept), kept[0].shape[1]), kept[0].dtype)
    for number, part in enumerate(kept):
        found[:, number] = part
    return found


def copied(values: _Array) -> _Array:
    """A copy of the values. Raises as `empty`."""
    return as_type(values, values.dtype)


def stowed(values: _Array) -> _Array:
    """The values, copied into a file where large arrays lie in files. Raises as `empty`."""
    if _files_for(values.shape, values.dtype) is None or 0 in values.strides:
        return values
    return copied(values)


def as_type(values: _Array, dtype: npt.DTypeLike) -> _Array:
    """A copy of the values of a type. Raises as `empty`."""
    found = empty(values.shape, dtype)
    found[...] = values
    return found


def concatenated(parts: Sequence[_Array]) -> _Array:
    """As `numpy.concatenate` along the first axis, of arrays of one type. Raises as `empty`."""
    found = empty((sum(map(len, parts)), *parts[0].shape[1:]), parts[0].dtype)
    first = 0
    for part in parts:
        found[first : first + len(part)] = part
        first += len(part)
    return found


def _files_for(shape: int | Sequence[int], dtype: npt.DTypeLike) -> _Files | None:
    """Where an array lies, None for memory."""
    if not _open or _bytes(shape, dtype) < max(_open[-1].least, 1):
        return None
    return _open[-1]


def _bytes(shape: int | Sequence[int], dtype: npt.DTypeLike) -> int:
    return prod(shape if isinstance(shape, Sequence) else (shape,)) * np.dtype(dtype).itemsize


def _in_file(folder: Path, shape: int | Sequence[int], dtype: npt.DTypeLike) -> _Array:
    size = _bytes(shape, dtype)
    try:
        with tempfile.TemporaryFile(dir=folder) as file:
            _reserve(file.fileno(), folder, size)
            mapped = mmap.mmap(file.fileno(), size)
    except OSError as error:
        raise BakeError(
            f"{folder} has no room for {size >> 20} MiB of samples: {error.strerror or error}",
            do("free its disk"),
            do("choose another folder", Setting.OUT),
            do("allow more memory", Setting.MEMORY),
        ) from error
    return np.frombuffer(mapped, dtype).reshape(shape)


def _reserve(file: int, folder: Path, size: int) -> None:
    """Give a file so many bytes of the disk, of 0: a disk that fills up later ends the process.

    Raises OSError where it has no room.
    """
    os.truncate(file, size)
    if hasattr(os, "posix_fallocate"):
        os.posix_fallocate(file, 0, size)
    elif shutil.disk_usage(folder).free < size:
        raise OSError(0, "the disk is full")
