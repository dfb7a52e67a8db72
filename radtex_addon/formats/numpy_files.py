# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""numpy's files (.npz, .npy), from anywhere: every size is checked before memory is taken.

numpy's own `load` takes as much memory as a header says, and raises whatever its parsers meet.
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

from ..core.errors import FormatError
from .json_reader import shown
from .memory import check_memory
from .regular import open_regular

_FORMAT: Any = np.lib.format  # which older stubs leave untyped


def read_npz(path: Path, wanted: Mapping[str, str], most: int) -> dict[str, npt.NDArray[Any]]:
    """The arrays of these names, whose types are of these kinds, such as "iu" for whole numbers.

    None has more than `most` bytes. Raises FormatError, with the path, for what is none of that.
    """
    try:
        with open_regular(path) as file, zipfile.ZipFile(file) as archive:
            return {name: _member(archive, name, kinds, most) for name, kinds in wanted.items()}
    except Exception as error:  # numpy and zipfile raise whatever they meet
        raise _damaged(path, error) from error


def read_npy(path: Path, kinds: str) -> npt.NDArray[Any]:
    """The array of a file, whose type is one of these `kinds`.

    Raises FormatError, with the path, for another, for what is damaged, and for more than memory holds.
    """
    try:
        with open_regular(path) as file:
            size = os.fstat(file.fileno()).st_size
            check_memory(str(path), size)
            return _array(file, size, kinds)
    except FormatError:
        raise
    except Exception as error:  # numpy's parser of headers raises whatever it meets
        raise _damaged(path, error) from error


def _member(archive: zipfile.ZipFile, name: str, kinds: str, most: int) -> npt.NDArray[Any]:
    said = archive.getinfo(f"{name}.npy")
    with archive.open(said) as stream:
        return _array(stream, min(said.file_size, most + (1 << 16)), kinds)


def _array(stream: IO[bytes], size: int, kinds: str) -> npt.NDArray[Any]:
    """An array that takes `size` bytes of the stream at most. Raises ValueError, and what numpy raises."""
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
