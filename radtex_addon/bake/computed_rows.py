# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Arrays that take no memory: their rows are computed whenever they are read."""

from __future__ import annotations

from collections.abc import Callable
from typing import cast

from ..core.arrays import Floats
from .light_samples import Some


class Rows:
    """An array of this `shape`, some rows of which are computed whenever it is indexed by them."""

    def __init__(self, shape: tuple[int, ...], compute: Callable[[Some], Floats]) -> None:
        self.shape, self._compute = shape, compute

    def __len__(self) -> int:
        return self.shape[0]

    def __getitem__(self, some: Some) -> Floats:
        return self._compute(some)


def computed(shape: tuple[int, ...], compute: Callable[[Some], Floats]) -> Floats:
    """`Rows`, where an array is expected that is only indexed by some of its rows."""
    return cast(Floats, Rows(shape, compute))
