# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Types of the arrays used throughout RadTex, and the check of their shape and type."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from .errors import ShapeError

Floats: TypeAlias = npt.NDArray[np.floating[Any]]
Ints: TypeAlias = npt.NDArray[np.integer[Any]]
Bools: TypeAlias = npt.NDArray[np.bool_]


def blocks(count: int, most: int = 1 << 18) -> Iterator[slice]:
    """Slices of at most so many rows, which cut `count` rows into blocks that need little memory each."""
    for first in range(0, count, most):
        yield slice(first, min(first + most, count))


def as_floats(name: str, values: npt.ArrayLike, components: int) -> Floats:
    """`values` as a float array of shape (..., components).

    float32 and float64 stay as they are, everything else becomes float64.
    Raises ShapeError, with `name` in the message, for another last axis or values that are not real numbers.
    """
    array = np.asarray(values)
    if array.dtype.kind not in "fiu":
        raise ShapeError(f"{name}: expected real numbers, got {array.dtype}")
    if array.ndim == 0 or array.shape[-1] != components:
        raise ShapeError(f"{name}: expected shape (..., {components}), got {array.shape}")
    if array.dtype not in (np.float32, np.float64):
        array = array.astype(np.float64)
    return array
