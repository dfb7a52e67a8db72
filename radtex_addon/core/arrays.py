# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Types of the arrays used throughout RadTex, the check of their shape and type, and sorting in ranges."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from .errors import ShapeError

Keys: TypeAlias = npt.NDArray[np.uint64]

AT_ONCE = 1 << 20  # about so many keys are sorted together
_SAMPLED = 1 << 12  # keys by which the ranges are chosen
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


def sorted_ranges(keys: Keys) -> Iterator[Ints]:
    """Indices of the keys (N,), ascending by key and then by index, in arrays that have no key in common."""
    sample = np.sort(keys[:: max(len(keys) // _SAMPLED, 1)])
    parts = max(len(keys) // AT_ONCE, 1)
    starts = np.unique(sample[np.arange(1, parts) * len(sample) // parts])
    for low, high in zip([None, *starts], [*starts, None], strict=True):
        inside = np.ones(len(keys), dtype=bool) if low is None else keys >= low
        if high is not None:
            inside &= keys < high
        some = np.flatnonzero(inside)
        yield some[np.argsort(keys[some], kind="stable")]


def ranks(keys: Keys) -> npt.NDArray[np.uint32]:
    """The rank, 0, 1, … without gaps, of each of the keys (N,) among their different values: (N,)."""
    found = np.empty(len(keys), dtype=np.uint32)
    following = 0
    for order in sorted_ranges(keys):
        ascending = keys[order]
        new = np.ones(len(order), dtype=bool)
        np.not_equal(ascending[1:], ascending[:-1], out=new[1:])
        found[order] = np.cumsum(new) + (following - 1)
        following += int(np.count_nonzero(new))
    return found
