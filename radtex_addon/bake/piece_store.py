# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Stores for a bake's finished pieces: nowhere, or in memory; `store/checkpoint.py` has the one on disk."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

import numpy.typing as npt

from ..core.errors import BakeError

Arrays: TypeAlias = dict[str, npt.NDArray[Any]]  # a piece: its arrays by name
Facts: TypeAlias = Mapping[str, str]  # what pieces are of; a hash begins with `near_digest.DIGEST`


class PieceStore:
    """A store for a bake's finished pieces; this base class stores nothing, for bakes without resume."""

    def set_facts(self, facts: Facts) -> None:
        """Set the facts that the pieces belong to, before the first is stored or read; may be called again.

        Raises InputError if stored pieces belong to other facts.
        """

    def names(self) -> list[str]:
        """The names of all stored pieces, sorted."""
        return []

    def found(self, _name: str) -> Arrays | None:
        """The stored piece if it is complete and undamaged, else None."""
        return None

    def keep(self, _name: str, _arrays: Arrays) -> None:
        """Store a piece. Raises BakeError where the system refuses."""

    def place(self, path: Path) -> Path:
        """Where to write the output file `path` until all files of the bake are complete.

        Raises BakeError where the system refuses.
        """
        return path

    @property
    def keeps(self) -> bool:
        """Whether stored pieces can be read again."""
        return False

    def rows(self, name: str, _array: str, _first: int, _count: int) -> npt.NDArray[Any]:
        """Some rows of an array of a stored piece. Raises BakeError where they cannot be read."""
        raise BakeError(f"'{name}' was not kept")

    def get_or_make(self, name: str, make: Callable[[], Arrays]) -> Arrays:
        """The stored piece, or if there is none the result of `make`, which is then stored."""
        kept = self.found(name)
        if kept is None:
            kept = make()
            self.keep(name, kept)
        return kept

    def share_of(self, names: Sequence[str]) -> Sequence[int]:
        """Which of several pieces, by number, this process has to make: all, but for a farm's task."""
        return range(len(names))


class ShareDoneError(Exception):
    """The pieces that this process has to make are stored, and others make the rest."""


def in_shares(store: PieceStore, names: Sequence[str]) -> Iterator[int]:
    """The numbers of the pieces with these names, which are independent, to be asked of the store in turn.

    Raises ShareDoneError at the end where they are only a share of them.
    """
    share = store.share_of(names)
    yield from share
    if len(share) < len(names):
        raise ShareDoneError


NO_STORE = PieceStore()


class MemoryStore(PieceStore):
    """Stores pieces in memory, until it is deleted."""

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


class PrefixedStore(PieceStore):
    """The pieces of another store whose names begin with `prefix`; here they are named without it."""

    def __init__(self, store: PieceStore, prefix: str) -> None:
        self._store, self._prefix = store, prefix

    def set_facts(self, facts: Facts) -> None:
        self._store.set_facts(facts)

    @property
    def keeps(self) -> bool:
        return self._store.keeps

    def rows(self, name: str, array: str, first: int, count: int) -> npt.NDArray[Any]:
        return self._store.rows(self._prefix + name, array, first, count)

    def names(self) -> list[str]:
        prefix = self._prefix
        return [name.removeprefix(prefix) for name in self._store.names() if name.startswith(prefix)]

    def found(self, name: str) -> Arrays | None:
        return self._store.found(self._prefix + name)

    def keep(self, name: str, arrays: Arrays) -> None:
        self._store.keep(self._prefix + name, arrays)

    def place(self, path: Path) -> Path:
        return self._store.place(path)

    def share_of(self, names: Sequence[str]) -> Sequence[int]:
        return self._store.share_of([self._prefix + name for name in names])
