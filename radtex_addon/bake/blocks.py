# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Work on samples, a block of texels at a time: little memory, and all cores.

Samples are S for each of K texels. Inside a block they are planes: (C, k, S), the channels first, for NumPy
is quick along long last axes only.
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

SAMPLES_AT_ONCE = 1 << 14  # what they need fits a core's cache
THREADS = os.cpu_count() or 1


def side_by_side(function: Callable[[_Part], _Result], parts: Iterable[_Part]) -> list[_Result]:
    """The function's results for all parts, in order; it runs in several threads."""
    with ThreadPoolExecutor(THREADS) as pool:
        return list(pool.map(function, parts))


def in_blocks(
    function: Callable[[slice], _Result], texels: int, samples: int, at_once: int = SAMPLES_AT_ONCE
) -> list[_Result]:
    """The function's results for blocks of `texels` with `samples` each, in order, whatever the threads."""
    step = max(1, at_once // max(samples, 1))
    blocks = [slice(first, min(first + step, texels)) for first in range(0, texels, step)]
    return side_by_side(function, blocks)


def planes(values: Floats) -> Floats:
    """Channels first: (..., C) -> (C, ...) float32, contiguous."""
    return np.ascontiguousarray(np.moveaxis(values, -1, 0), dtype=np.float32)
