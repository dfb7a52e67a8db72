# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Digests of values that are not computed to the last bit alike each time, and how near two of them are.

Blender makes some values otherwise from one evaluation of a scene to the next: the Bevel modifier's UVs
differ by a few units in the last place. A hash of them tells nothing, a hash of rounded values flips where a
value lies between two, so their weighted sums are compared.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

DIGEST = "sha256:"  # prefix of texts that are hashes, which messages do not show
_PARTS = 8  # of each array: one sum for each
_SMALL = 1e-3  # sizes of values below it are rounded as values of that size
_SAME = 3e-5  # differences of sums up to this are rounding: all of Bevel's UVs together make 3e-7
_TEXT = re.compile(r"(sha256:[0-9a-f]{64}) ([0-9a-f]{64}) ([-+.,0-9e]+)")
_STEP = (5**0.5 - 1) / 2  # weights are this step's multiples, less whole numbers: no pattern cancels out


@dataclass(frozen=True)
class NearDigest:
    """A digest of values to the last bit, `exact`, and where these may vary, what they are near to.

    `of` is a digest of what the values are made of, and of those values that do not vary; it is empty where
    `exact` alone tells. `sums` are weighted sums of the values that may vary.
    """

    exact: str
    of: str = ""
    sums: tuple[float, ...] = ()

    def is_like(self, other: NearDigest) -> bool:
        """Whether both are of the same values, but for rounding."""
        if self.exact == other.exact:
            return True
        if not self.of or self.of != other.of or len(self.sums) != len(other.sums):
            return False
        mine, its = np.array(self.sums), np.array(other.sums)
        return bool(np.all(np.abs(mine - its) <= _SAME * np.maximum(np.abs(mine), 1)))

    def __str__(self) -> str:
        """The digest as text, which `parse` reads."""
        return f"{self.exact} {self.near}" if self.of else self.exact

    @property
    def near(self) -> str:
        """The text without `exact`; empty where that alone tells."""
        return f"{self.of} {','.join(f'{one:.7g}' for one in self.sums)}" if self.of else ""

    @classmethod
    def parse(cls, text: str) -> NearDigest:
        """Read a digest's text; any other text is an `exact` one."""
        found = _TEXT.fullmatch(text)
        if found is None:
            return cls(text)
        try:
            return cls(found[1], found[2], tuple(float(one) for one in found[3].split(",")))
        except ValueError:
            return cls(text)


def is_same(one: str, other: str) -> bool:
    """Whether two texts of digests are of the same values, but for rounding."""
    return one == other or NearDigest.parse(one).is_like(NearDigest.parse(other))


class NearHash:
    """Feeds a NearDigest's `of` and `sums`."""

    def __init__(self, of: str) -> None:
        self._of = hashlib.sha256(of.encode("utf-8", "surrogateescape"))
        self._sums = np.zeros(_PARTS + 1)

    def feed(self, name: str, values: npt.NDArray[Any], varies: bool = False) -> None:
        """Add values; of those that are floats and may vary, only the shape to the last bit."""
        self._of.update(f"\0{name} {values.shape} {values.dtype}".encode("utf-8", "surrogateescape"))
        if varies and values.dtype.kind == "f":
            self._sums += _weighted_sums(values.reshape(-1))
        else:
            self._of.update(np.ascontiguousarray(values).reshape(-1).view(np.uint8).data)

    def digest(self, exact: str) -> NearDigest:
        """The digest of all that was fed, and of the `exact` one."""
        return NearDigest(exact, self._of.hexdigest(), tuple(self._sums.tolist()))


def joined(exact: str, parts: Iterable[NearDigest], beside: Iterable[str] = ()) -> NearDigest:
    """The digest of several, in their order, and of texts `beside` them; `exact` is of all of it."""
    digests: Sequence[NearDigest] = list(parts)
    if not any(each.of for each in digests):
        return NearDigest(exact)
    of = hash_of((*(each.of or each.exact for each in digests), *beside))
    sums = np.sum([each.sums for each in digests if each.of], axis=0)
    return NearDigest(exact, of, tuple(sums.tolist()))


def hash_of(texts: Iterable[str]) -> str:
    """SHA-256 of texts in this order."""
    state = hashlib.sha256()
    for text in texts:
        state.update(text.encode("utf-8", "surrogateescape") + b"\0")
    return state.hexdigest()


def _weighted_sums(values: npt.NDArray[Any]) -> npt.NDArray[np.float64]:
    """Sums of values (N,), times weights, over each of the parts, in units of their mean size; and that size.

    As errors of rounding have no sign in common, sums are divided by the root of the parts' lengths.
    """
    found = np.zeros(_PARTS + 1)
    if not len(values):
        return found
    size = 0.0
    for number, part in enumerate(np.array_split(values, _PARTS)):
        some = np.nan_to_num(part.astype(np.float64), posinf=0.0, neginf=0.0)
        weights = np.arange(1, len(some) + 1) * _STEP % 1.0 - 0.5
        found[number] = weights @ some
        size += float(np.abs(some).sum()) / len(values)
    found /= (size + _SMALL) * np.sqrt(max(len(values) / _PARTS, 1.0))
    found[_PARTS] = np.arcsinh(size)
    return found
