# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Read untrusted numpy files (.npz, .npy): every size is checked before memory is allocated.

numpy's own `load` allocates as much memory as a header says, and may raise any exception.
"""

from __future__ import annotations

import os
import zipfile
from collections.abc import Mapping
from math import prod
from pathlib import Path
from typing import IO, Any

import numpy as np
import numpy.typing as npt

from ...core.errors import FormatError
from ..disk.memory import check_memory
from ..disk.regular import open_regular
from ..json_reader import shown

_FORMAT: Any = np.lib.format  # older stubs leave it untyped


def read_npz(path: Path, wanted: Mapping[str, str], most: int) -> dict[str, npt.NDArray[Any]]:
    """Read the `wanted` arrays: names with the dtype kinds allowed, such as "iu" for whole numbers.

    Each may have about `most` bytes at most. Raises FormatError, with the path, for any other file.
    """
    try:
        with open_regular(path) as file, zipfile.ZipFile(file) as archive:
            return {name: _member(archive, name, kinds, most) for name, kinds in wanted.items()}
    except Exception as error:  # numpy and zipfile may raise anything
        raise _damaged(path, error) from error


def read_npy(path: Path, kinds: str) -> npt.NDArray[Any]:
    """Read the array of a file, whose dtype must be of one of the `kinds`.

    Raises FormatError, with the path, for another dtype, a damaged file, or one too large for memory.
    """
    try:
        with open_regular(path) as file:
            size = os.fstat(file.fileno()).st_size
            check_memory(str(path), size)
            return _array(file, size, kinds)
    except FormatError:
        raise
    except Exception as error:  # numpy's header parser may raise anything
        raise _damaged(path, error) from error


def _member(archive: zipfile.ZipFile, name: str, kinds: str, most: int) -> npt.NDArray[Any]:
    said = archive.getinfo(f"{name}.npy")
    with archive.open(said) as stream:
        return _array(stream, min(said.file_size, most + (1 << 16)), kinds)


def _array(stream: IO[bytes], size: int, kinds: str) -> npt.NDArray[Any]:
    """Read an array of at most `size` bytes from the stream. Raises ValueError, and any error of numpy."""
    version = _FORMAT.read_magic(stream)
    shape, by_columns, dtype = _FORMAT.read_array_header_1_0(stream)
    length = prod(shape) * dtype.itemsize
    if version != (1, 0) or dtype.kind not in kinds or min(shape, default=0) < 0 or length > size:
        raise ValueError("an array in it is of another kind or size")
    data = stream.read(length)
    if len(data) != length:
        raise ValueError("it is cut short")
    values: npt.NDArray[Any] = np.frombuffer(data, dtype).reshape(shape, order="F" if by_columns else "C")
    return values


def _damaged(path: Path, error: Exception) -> FormatError:
    reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
    return FormatError(f"{path} is damaged: {shown(' '.join(reason.split()), 200) or type(error).__name__}")
