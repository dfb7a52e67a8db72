# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The part of a sidecar for the condensed form of the shared layout: the object "condensed" in "shared"."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from ..core.arrays import Floats
from ..core.shared import Axis
from .condensed_sizes import MOST_CLUSTERS
from .containers.texture import MOST_PIXELS
from .json_reader import Facts
from .packing import LOBE_CHANNELS

# The least and the greatest value of each channel: of the first tiles (weight 1), then of the weighted ones.
Range: TypeAlias = tuple[tuple[float, ...], ...]

_MOST = float(np.finfo(np.float32).max)


@dataclass(frozen=True)
class Tiles:
    """The number of a lobe's clusters, and for each of its parts the values that 0 and 1 in a texture mean.

    Each range has four rows: low and high of the tiles k = 0, low and high of the others.
    """

    clusters: int
    ranges: dict[str, Range]


@dataclass(frozen=True)
class CondensedFacts:
    """Facts about a condensed bake's textures.

    `rank` is the number of weights of a texel, `columns` that of tiles side by side in the lobes' images;
    `digests` are the files' SHA-256 by layer, in hexadecimal digits.
    """

    rank: int
    columns: int
    lobes: dict[Axis, Tiles]
    digests: dict[str, str]

    def facts(self) -> dict[str, Any]:
        """The JSON's keys and values, in order."""
        return {
            "rank": self.rank,
            "columns": self.columns,
            "lobes": {
                axis.value: {"clusters": tiles.clusters}
                | {part: [list(row) for row in rows] for part, rows in tiles.ranges.items()}
                for axis, tiles in self.lobes.items()
            },
            "digests": dict(self.digests),
        }

    @classmethod
    def from_facts(cls, shared: Facts, lobes: Iterable[Axis], layers: Iterable[str]) -> CondensedFacts:
        """Inverse of `facts`: read the object `shared` of a bake with these lobes and layers.

        Raises FormatError for a missing or mistyped key.
        """
        facts = _Facts(shared.values, shared.source).inner("condensed")
        tiles, digests = facts.inner("lobes"), facts.inner("digests")
        return cls(
            rank=facts.whole_number("rank", 2, MOST_PIXELS),
            columns=facts.whole_number("columns", 1, MOST_PIXELS),
            lobes={axis: _tiles(tiles.inner(axis)) for axis in lobes},
            digests={layer: digests.text(layer) for layer in layers},
        )


def as_range(rows: Floats) -> Range:
    """Four rows of float32 values as the shortest numbers that are read as the same float32."""
    return tuple(tuple(shortest(value) for value in row) for row in rows)


def shortest(value: np.floating[Any]) -> float:
    """The number with the fewest digits that is read as the same float32 as `value`."""
    return float(str(np.float32(value)))


class _Facts(Facts):
    """Facts with a reader for ranges, also in nested objects."""

    def inner(self, key: str) -> _Facts:
        return _Facts(super().inner(key).values, f'{self.source.rstrip(",")}, in "{key}",')

    def range(self, key: str, channels: int) -> Range:
        value = self._of(key)
        if not isinstance(value, list) or len(value) != 4 or not all(_is_row(row, channels) for row in value):
            raise self._mistyped(key, f"4 lists of {channels} numbers")
        return tuple(tuple(map(float, row)) for row in value)


def _tiles(facts: _Facts) -> Tiles:
    return Tiles(
        clusters=facts.whole_number("clusters", 1, MOST_CLUSTERS),
        ranges={part: facts.range(part, channels) for part, channels in LOBE_CHANNELS.items()},
    )


def _is_row(row: object, channels: int) -> bool:
    """Whether `row` has this many numbers within float32's range; integers in JSON may have any length."""
    numbers = isinstance(row, list) and len(row) == channels and all(type(n) in (int, float) for n in row)
    return numbers and all(-_MOST <= n <= _MOST for n in row)  # type: ignore[attr-defined]
