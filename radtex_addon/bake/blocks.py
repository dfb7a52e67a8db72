# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Process samples in blocks of texels: uses little memory, and all cores.

Each of K texels has S samples. Inside a block their arrays are (C, k, S), channels first, because NumPy is
fast only along a long last axis.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

import numpy as np

from ..core.arrays import Floats

_Part = TypeVar("_Part")
_Result = TypeVar("_Result")

SAMPLES_AT_ONCE = 1 << 14  # in a block: its data fits a core's cache
THREADS = os.cpu_count() or 1


def side_by_side(function: Callable[[_Part], _Result], parts: Iterable[_Part]) -> list[_Result]:
    """Run the function on all parts in several threads; its results in the order of the parts."""
    with ThreadPoolExecutor(THREADS) as pool:
        return list(pool.map(function, parts))


def in_blocks(
    function: Callable[[slice], _Result], texels: int, samples: int, at_once: int = SAMPLES_AT_ONCE
) -> list[_Result]:
    """Run the function on blocks of `texels` with `samples` each, in several threads; its results in order.

    A block has about `at_once` samples, however many threads there are.
    """
    step = max(1, at_once // max(samples, 1))
    blocks = [slice(first, min(first + step, texels)) for first in range(0, texels, step)]
    return side_by_side(function, blocks)


def planes(values: Floats) -> Floats:
    """Channels first: (..., C) -> (C, ...) float32, contiguous."""
    return np.ascontiguousarray(np.moveaxis(values, -1, 0), dtype=np.float32)
