# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Keepers of a bake's finished pieces: none, or memory; a folder is `checkpoint.py`'s."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy.typing as npt

from ..core.errors import BakeError
from .key import Facts
from .pieces import Arrays


class Keeper:
    """Is given the finished pieces of a bake, and keeps none: for a bake that is not to be resumed."""

    def expect(self, facts: Facts) -> None:
        """Say what the pieces belong to, before the first is given or asked for; may be called again.

        Raises InputError where those that are kept belong to something else.
        """

    def names(self) -> list[str]:
        """Of all pieces that are kept, sorted."""
        return []

    def found(self, _name: str) -> Arrays | None:
        """A piece that was kept, whole and undamaged, or None."""
        return None

    def keep(self, _name: str, _arrays: Arrays) -> None:
        """Keep a piece. Raises BakeError where the system refuses."""

    def place(self, path: Path) -> Path:
        """Where to write the file that is to become `path` once all files of the bake are whole.

        Raises BakeError where the system refuses.
        """
        return path

    @property
    def keeps(self) -> bool:
        """Whether pieces that were kept can be found."""
        return False

    def rows(self, name: str, _array: str, _first: int, _count: int) -> npt.NDArray[Any]:
        """Some rows of an array of a piece that is kept. Raises BakeError where they cannot be read."""
        raise BakeError(f"'{name}' was not kept")

    def once(self, name: str, make: Callable[[], Arrays]) -> Arrays:
        """The piece, kept before or made now."""
        kept = self.found(name)
        if kept is None:
            kept = make()
            self.keep(name, kept)
        return kept


KEEPS_NOTHING = Keeper()


class Pile(Keeper):
    """Keeps pieces in memory, for as long as it lives."""

    def __init__(self) -> None:
        self._pieces: dict[str, Arrays] = {}

    @property
    def keeps(self) -> bool:
        return True

    def names(self) -> list[str]:
        return sorted(self._pieces)

    def found(self, name: str) -> Arrays | None:
        return self._pieces.get(name)

    def keep(self, name: str, arrays: Arrays) -> None:
        self._pieces[name] = arrays

    def rows(self, name: str, array: str, first: int, count: int) -> npt.NDArray[Any]:
        return self._pieces[name][array][first : first + count]


class Drawer(Keeper):
    """The pieces of another keeper whose names begin with a `label`, without it."""

    def __init__(self, keeper: Keeper, label: str) -> None:
        self._keeper, self._label = keeper, label

    def expect(self, facts: Facts) -> None:
        self._keeper.expect(facts)

    @property
    def keeps(self) -> bool:
        return self._keeper.keeps

    def rows(self, name: str, array: str, first: int, count: int) -> npt.NDArray[Any]:
        return self._keeper.rows(self._label + name, array, first, count)

    def names(self) -> list[str]:
        label = self._label
        return [name.removeprefix(label) for name in self._keeper.names() if name.startswith(label)]

    def found(self, name: str) -> Arrays | None:
        return self._keeper.found(self._label + name)

    def keep(self, name: str, arrays: Arrays) -> None:
        self._keeper.keep(self._label + name, arrays)

    def place(self, path: Path) -> Path:
        return self._keeper.place(path)
