# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sort many keys, one range of them at a time, so that little memory is needed beside the keys."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from .arrays import Ints

Keys: TypeAlias = npt.NDArray[np.uint64]

AT_ONCE = 1 << 20  # about so many keys are sorted together
_SAMPLED = 1 << 12  # keys by which the ranges are chosen


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
