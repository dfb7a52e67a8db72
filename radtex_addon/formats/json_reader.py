# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The JSON of a sidecar or a manifest, read key by key with errors that name the key."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from typing import Any

from ..core.errors import BakeError, FormatError
from .disk.regular import MOST_TEXT

_MOST = 2**64 - 1  # limit of whole numbers; ours are far smaller
MOST_VALUES = 1_000_000  # limit of values in a text: in memory each takes up to a hundred times its bytes


def shown(text: str, most: int = 40) -> str:
    """Text of a file for a message, truncated to `most` characters."""
    return text if len(text) <= most else text[:most] + "…"


def json_text(facts: dict[str, Any]) -> str:
    """JSON as in the files, in ASCII and with a newline at its end.

    Raises BakeError for more than `Facts.parse` and `read_regular` take, so that no file is written in vain.
    """
    text = json.dumps(facts, indent=2) + "\n"
    if said := excess(text):
        raise BakeError(f"what is to be written {said}: nothing was written")
    return text


def excess(text: str, share: float = 1.0) -> str:
    """What a text has more of than readers take, such as "has 2000000 values, 1000000 are the most".

    Empty if it has not. With a `share`, more than that share of it.
    """
    values, size = _values_in(text), len(text)
    for found, most, what in ((values, MOST_VALUES, "values"), (size, MOST_TEXT, "bytes of text")):
        if found > share * most:
            return f"has {found} {what}, {int(share * most)} are the most"
    return ""


def _values_in(text: str) -> int:
    """The most values that a text of JSON can have."""
    return sum(map(text.count, ",[{"))


@dataclass(frozen=True)
class Facts:
    """A JSON object whose values are read with type checks; `source` names it in errors, `what` is its kind.

    Every method raises FormatError for a missing or mistyped key.
    """

    values: dict[str, Any]
    source: str
    what: str = "RadTex sidecar"

    @classmethod
    def parse(cls, text: str, source: str, what: str = "RadTex sidecar") -> Facts:
        """Inverse of `json_text`. Raises FormatError if it is no JSON object, or has too many values."""
        if _values_in(text) > MOST_VALUES:
            raise FormatError(f"{source} has more values than any {what}: bake it again")
        try:
            values = json.loads(text)
        except (ValueError, RecursionError) as error:
            raise FormatError(f"{source} is not JSON ({error}): bake it again") from error
        if not isinstance(values, dict):
            raise FormatError(f"{source} is not a JSON object: it is no {what}")
        return cls(values, source, what)

    def inner(self, key: str) -> Facts:
        value = self._of(key)
        if not isinstance(value, dict):
            raise self._mistyped(key, "an object")
        return Facts(value, f'{self.source} in "{key}"', self.what)

    def whole_number(self, key: str, least: int, most: int = _MOST) -> int:
        value = self._of(key)
        if type(value) is not int or not least <= value <= most:
            bound = f"of at least {least}" if most == _MOST else f"from {least} to {most}"
            raise self._mistyped(key, f"a whole number {bound}")
        return value

    def number(self, key: str) -> float:
        value = self._of(key)
        if not _is_number(value):
            raise self._mistyped(key, "a number")
        return float(value)

    def positive(self, key: str) -> float:
        value = self._of(key)
        if not _is_number(value) or value <= 0:
            raise self._mistyped(key, "a number above 0")
        return float(value)

    def text(self, key: str) -> str:
        value = self._of(key)
        if not isinstance(value, str):
            raise self._mistyped(key, "text")
        return value

    def texts(self, key: str) -> tuple[str, ...]:
        value = self._of(key)
        if not isinstance(value, list) or not all(isinstance(item, str) for item in value):
            raise self._mistyped(key, "a list of texts")
        return tuple(value)

    def truth(self, key: str) -> bool:
        value = self._of(key)
        if not isinstance(value, bool):
            raise self._mistyped(key, "true or false")
        return value

    def choice(self, key: str, among: tuple[str, ...]) -> str:
        value = self._of(key)
        if value not in among:
            raise self._mistyped(key, " or ".join(among))
        return str(value)

    def choices(self, key: str, among: tuple[str, ...]) -> tuple[str, ...]:
        value = self._of(key)
        if not isinstance(value, list) or any(item not in among or value.count(item) > 1 for item in value):
            raise self._mistyped(key, f"a list of {' or '.join(among)}, each at most once")
        return tuple(value)

    def size(self, key: str, most: int = _MOST) -> tuple[int, int]:
        value = self._of(key)
        pair = isinstance(value, list) and len(value) == 2
        if not pair or any(type(n) is not int or not 1 <= n <= most for n in value):
            bound = "of at least 1" if most == _MOST else f"from 1 to {most}"
            raise self._mistyped(key, f"two whole numbers {bound}")
        return value[0], value[1]

    def colours(self, key: str) -> tuple[tuple[float, float, float], ...]:
        value = self._of(key)
        if not isinstance(value, list) or not value or not all(map(_is_colour, value)):
            raise self._mistyped(key, "a list of [red, green, blue]")
        return tuple((float(r), float(g), float(b)) for r, g, b in value)

    def numbers(self, key: str, count: int) -> list[float]:
        value = self._of(key)
        if not isinstance(value, list) or len(value) != count or not all(map(_is_number, value)):
            raise self._mistyped(key, f"{count} numbers")
        return [float(number) for number in value]

    def point(self, key: str) -> tuple[float, float, float, float]:
        x, y, z, w = self.numbers(key, 4)
        return x, y, z, w

    def constant(self, key: str, expected: object) -> None:
        if self._of(key) != expected:
            raise self._mistyped(key, json.dumps(expected))

    def _of(self, key: str) -> Any:
        if key not in self.values:
            raise FormatError(f'{self.source} lacks "{key}": it is no {self.what}, or it was cut short')
        return self.values[key]

    def _mistyped(self, key: str, expected: str) -> FormatError:
        found = shown(json.dumps(self.values[key]))
        return FormatError(f'{self.source}: "{key}" is {found}, expected {expected}')


def _is_number(value: object) -> bool:
    """Whether `value` is a finite double: JSON files may have NaN, Infinity and integers of any length."""
    if type(value) not in (int, float):
        return False
    try:
        return math.isfinite(value)  # type: ignore[arg-type]
    except OverflowError:
        return False


def _is_colour(value: object) -> bool:
    return isinstance(value, list) and len(value) == 3 and all(map(_is_number, value))
