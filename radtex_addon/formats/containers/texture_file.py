# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A texture that is encoded in bands of rows, and stored in a temporary file until it is complete."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from math import prod
from pathlib import Path
from typing import BinaryIO

import numpy as np

from ...core.arrays import Floats
from ...core.errors import BakeError
from .texture import TextureShape, encode_rows

_PIECE = 1 << 22  # bytes that are read at once


class TextureFile:
    """The blocks of a texture of the given `form`; each image's rows must be added in order.

    Blocks that reach beyond an edge repeat the last pixels, as in `encode_texture`.
    """

    def __init__(self, form: TextureShape, file: BinaryIO) -> None:
        self.form, self._file = form, file
        ends = np.cumsum([0, *(form.nbytes(level) for level in range(form.levels))])
        self._begins = [int(end) for end in ends[:-1]]
        self._waiting: dict[tuple[int, int], Floats] = {}  # pixel rows that do not fill a block yet

    def put(self, level: int, layer: int, first: int, rows: Floats) -> None:
        """Add rows (k, W, 3 or 4), from row number `first` on. Raises InputError as `encode_texture` does."""
        held = self._waiting.pop((level, layer), rows[:0])
        rows, first = np.concatenate([held, rows]) if len(held) else rows, first - len(held)
        side = self.form.format.side
        is_last = first + len(rows) == max(1, self.form.height >> level)
        whole = len(rows) if is_last else len(rows) // side * side
        if whole < len(rows):
            self._waiting[level, layer] = rows[whole:].copy()
        if whole:
            blocks = encode_rows(rows[:whole], self.form.format)
            self._file.seek(self._begin(level, layer) + first // side * blocks[0].nbytes)
            self._file.write(np.ascontiguousarray(blocks).data)

    def parts(self, level: int, layer: int) -> Iterator[memoryview]:
        """Yield the bytes of one layer of a level, after all its rows were added."""
        begin, size = self._begin(level, layer), prod(self.form.shape(level)[1:])
        for place in range(0, size, _PIECE):
            self._file.seek(begin + place)
            yield memoryview(self._file.read(min(_PIECE, size - place)))

    def _begin(self, level: int, layer: int) -> int:
        return self._begins[level] + layer * prod(self.form.shape(level)[1:])


@contextmanager
def texture_file(form: TextureShape, folder: Path) -> Iterator[TextureFile]:
    """Yield an empty texture in a temporary file in `folder`, which is created if needed.

    The file is removed at exit. Raises BakeError where the system refuses.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder, prefix=".radtex-") as file:
            yield TextureFile(form, file)
    except OSError as error:
        reason = error.strerror or error
        raise BakeError(
            f"{folder} could not be written: {reason}; free its disk, or choose another"
        ) from error
