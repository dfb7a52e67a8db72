# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Values of all texels' samples that take little memory: in 16 bits, and drawn at random."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ....bake.light_samples import Some
from ....core import large_arrays
from ....core.arrays import Bools, Floats, Ints

_STEPS = 65535
_MOST = 65504.0  # the largest half float
_DRAWN_AT_ONCE = 1 << 20


class Places:
    """Places on the octahedron's square, in [0, 1], of S samples of each of K texels, in 16 bits."""

    def __init__(self, shape: tuple[int, ...]) -> None:
        self._kept = large_arrays.empty((2, *shape), np.uint16)

    def keep(self, some: Some, place: Floats) -> Floats:
        """Keep those of some texels, (2, k, S); returns them as they are kept."""
        kept = (place * np.float32(_STEPS) + np.float32(0.5)).astype(np.uint16)
        self._kept[:, some] = kept
        return _read(kept)

    def __getitem__(self, some: Some) -> Floats:
        """Those of some texels, (2, k, S) float32."""
        return _read(self._kept[:, some])

    def some(self, some: Ints, each: slice) -> Floats:
        """Those of some samples of some texels, (2, k, S')."""
        return _read(self._kept[:, some, each])


def _read(kept: Ints) -> Floats:
    found: Floats = kept * np.float32(1 / _STEPS)
    return found


def halved(values: Floats) -> Floats:
    """Values as half floats, limited to their range."""
    limited: Floats = np.clip(values, -_MOST, _MOST).astype(np.float16)
    return limited


def random_half(shape: tuple[int, ...], seed: int) -> Bools:
    """About half of the samples (K, S), at random."""
    rng = np.random.default_rng(seed)
    half = large_arrays.empty(shape, bool)
    step = max(1, _DRAWN_AT_ONCE // max(shape[1], 1))
    for some in _slices(shape[0], step):
        half[some] = rng.random(half[some].shape) < 0.5
    return half


def _slices(count: int, step: int) -> Iterator[slice]:
    for first in range(0, count, step):
        yield slice(first, min(first + step, count))
