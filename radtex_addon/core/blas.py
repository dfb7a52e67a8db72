# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Matrix products whose results do not depend on the number of cores."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from importlib import import_module
from pathlib import Path

import numpy as np

# OpenBLAS's function names: "scipy_" is the prefix in NumPy's wheels, "64_" the suffix for 64-bit indices.
_NAMES = [f"{first}openblas_{{}}_num_threads{last}" for first in ("scipy_", "") for last in ("64_", "")]


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Limit NumPy's OpenBLAS to one thread, and restore its setting at exit; other BLAS are left alone.

    OpenBLAS cuts matrices into one piece per thread, so that rounding depends on the number of threads.
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
    """The OpenBLAS library and the pattern of its function names; None if NumPy uses no OpenBLAS."""
    linked = import_module("numpy.linalg._umath_linalg").__file__
    beside = Path(np.__file__).parent.with_name("numpy.libs").glob("*openblas*.dll")
    for path in (linked, *beside):  # Windows does not search a library's dependencies for names
        with suppress(OSError, TypeError):
            library = ctypes.CDLL(str(path))
            for name in _NAMES:
                if hasattr(library, name.format("set")):
                    return library, name
    return None
