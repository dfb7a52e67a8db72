# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Matrix products whose bits do not depend on how many cores there are."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from importlib import import_module
from pathlib import Path

import numpy as np

# As OpenBLAS calls them, NumPy's wheels, and builds for long indices.
_NAMES = [f"{first}openblas_{{}}_num_threads{last}" for first in ("scipy_", "") for last in ("64_", "")]


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Let NumPy's OpenBLAS work in one thread, and as before afterwards; another BLAS is left alone.

    It cuts matrices into as many pieces as it has threads, and adds up otherwise along the cuts.
    """
    openblas = _openblas()
    if openblas is None:
        yield
        return
    library, name = openblas
    before = int(library[name.format("get")]())
    library[name.format("set")](1)
    try:
        yield
    finally:
        library[name.format("set")](before)


def _openblas() -> tuple[ctypes.CDLL, str] | None:
    """The library, and what its functions are called; None where NumPy has none."""
    linked = import_module("numpy.linalg._umath_linalg").__file__
    beside = Path(np.__file__).parent.with_name("numpy.libs").glob("*openblas*.dll")
    for path in (linked, *beside):  # Windows does not look names up in what a library is linked to
        with suppress(OSError, TypeError):
            library = ctypes.CDLL(str(path))
            for name in _NAMES:
                if hasattr(library, name.format("set")):
                    return library, name
    return None
