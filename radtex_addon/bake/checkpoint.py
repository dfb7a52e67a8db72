# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What is finished of a bake, kept in a folder, so that a kill at any moment costs one render and no more.

A piece is some arrays under a name. It is written beside and renamed; its file ends with a digest of all that
stands before, so that one that was half written, or damaged later, is noticed and made again. The key says
what the pieces belong to: a bake that differs in any fact of it may not use them.
"""

from __future__ import annotations

import hashlib
import json
import logging
import os
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, BinaryIO, TypeAlias, cast

import numpy as np
import numpy.typing as npt

from ..core.errors import BakeError, InputError
from ..formats.atomic import remove_unfinished, replacing, write_text

log = logging.getLogger(__name__)

Arrays: TypeAlias = dict[str, npt.NDArray[Any]]
Facts: TypeAlias = Mapping[str, str]

VERSION = 1
KEY = "key.json"
DIGEST = "sha256:"  # begins a fact that nobody can read
_PIECE = ".piece"
_DIGEST_BYTES = 32
_CHUNK = 1 << 22  # bytes
_FORMAT: Any = np.lib.format  # which older stubs leave untyped


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

    def once(self, name: str, make: Callable[[], Arrays]) -> Arrays:
        """The piece, kept before or made now."""
        kept = self.found(name)
        if kept is None:
            kept = make()
            self.keep(name, kept)
        return kept


KEEPS_NOTHING = Keeper()


class Drawer(Keeper):
    """The pieces of another keeper whose names begin with a `label`, without it."""

    def __init__(self, keeper: Keeper, label: str) -> None:
        self._keeper, self._label = keeper, label

    def expect(self, facts: Facts) -> None:
        self._keeper.expect(facts)

    def names(self) -> list[str]:
        label = self._label
        return [name.removeprefix(label) for name in self._keeper.names() if name.startswith(label)]

    def found(self, name: str) -> Arrays | None:
        return self._keeper.found(self._label + name)

    def keep(self, name: str, arrays: Arrays) -> None:
        self._keeper.keep(self._label + name, arrays)


class Checkpoint(Keeper):
    """Keeps pieces in `folder`, which appears with the first of them."""

    def __init__(self, folder: Path, resume: bool, replaces: Iterable[Path] = ()) -> None:
        """Go on with what `folder` holds if `resume`, else begin anew, and drop that at the first piece.

        `replaces` are the files that the bake may put in the place of others. Raises InputError for a key
        that cannot be read.
        """
        self._folder = folder
        self._facts: dict[str, str] = {}
        self._known = _read_key(folder) if resume and is_unfinished(folder) else None
        self._replaces = sorted({path.name for path in replaces})
        self._begun = False

    def expect(self, facts: Facts) -> None:
        self._facts.update(facts)
        if self._known is None:
            return
        known = self._known["facts"]
        differing = [_difference(name, known.get(name), value) for name, value in facts.items()]
        said = ", ".join(words for words in differing if words)
        if said:
            raise InputError(
                f"{self._folder} is of a bake that differs in {said}: bake as before, "
                "or begin anew (--overwrite, without --resume)"
            )

    def names(self) -> list[str]:
        if self._known is None and not self._begun:
            return []
        return sorted(path.stem for path in self._folder.glob(f"*{_PIECE}"))

    def found(self, name: str) -> Arrays | None:
        if self._known is None and not self._begun:
            return None
        path = self._folder / f"{name}{_PIECE}"
        try:
            piece = _read_piece(path, self._mark(name))
        except FileNotFoundError:
            return None
        except (OSError, ValueError) as error:
            log.warning("%s is damaged and is made again (%s)", path, error)
            return None
        if not self._begun:
            self._begin()
        return piece

    def keep(self, name: str, arrays: Arrays) -> None:
        if not self._begun:
            self._begin()
        elif not is_unfinished(self._folder):
            raise BakeError(f"{self._folder} has gone while the bake ran: bring its disk back, or bake again")
        with replacing(self._folder / f"{name}{_PIECE}") as beside:
            _write_piece(beside, self._mark(name), arrays)

    def remove(self) -> None:
        """Drop all pieces, and what killed processes were writing: the bake is done.

        Raises BakeError where the system refuses.
        """
        for pid in self._known["processes"] if self._known else ():
            remove_unfinished(self._folder.parent, pid)
        _clear(self._folder)

    def drop_own(self) -> None:
        """Drop what this bake has kept, unless it went on with another's."""
        if self._begun and self._known is None:
            _clear(self._folder)

    def _begin(self) -> None:
        """Write the key; it lists the processes that worked on the bake."""
        processes = [os.getpid()]
        if self._known is None:
            _clear(self._folder)
        else:
            processes = [*self._known["processes"], *processes]
        key = {
            "version": VERSION,
            "facts": self._facts if self._known is None else self._known["facts"],
            "replaces": self._replaces,
            "processes": processes,
        }
        write_text(self._folder / KEY, json.dumps(key, indent=2) + "\n")
        self._begun = True

    def _mark(self, name: str) -> dict[str, str]:
        """What a piece's file says of itself: one of another bake, or under another's name, is no use."""
        facts = json.dumps(self._facts, sort_keys=True)
        return {"piece": name, "of": hashlib.sha256(facts.encode()).hexdigest()}


def is_unfinished(folder: Path) -> bool:
    """Whether the folder holds pieces of a bake that was not finished."""
    return (folder / KEY).is_file()


def replaced_by(folder: Path) -> frozenset[str]:
    """The names of the files that the unfinished bake in `folder` may replace: it may have written them."""
    return frozenset(_read_key(folder)["replaces"]) if is_unfinished(folder) else frozenset()


def _read_key(folder: Path) -> dict[str, Any]:
    path = folder / KEY
    anew = "begin anew (--overwrite, without --resume)"
    try:
        key = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"{path} cannot be read: {error.strerror or error}; or {anew}") from error
    except ValueError as error:
        raise InputError(f"{path} is damaged: {anew}") from error
    if not isinstance(key, dict) or key.get("version") != VERSION or not _is_key(key):
        raise InputError(f"{path} is damaged, or of another RadTex: {anew}")
    return cast("dict[str, Any]", key)


def _is_key(key: dict[str, Any]) -> bool:
    facts, replaces, processes = (key.get(name) for name in ("facts", "replaces", "processes"))
    return (
        isinstance(facts, dict)
        and all(isinstance(value, str) for value in facts.values())
        and isinstance(replaces, list)
        and all(isinstance(value, str) for value in replaces)
        and isinstance(processes, list)
        and all(isinstance(value, int) for value in processes)
    )


def _difference(name: str, before: str | None, now: str) -> str:
    if before == now:
        return ""
    if before is None or now.startswith(DIGEST):
        return name
    return f"{name} ({before}, now {now})"


def _clear(folder: Path) -> None:
    """Remove what we wrote, the key last: killed before that, it can be resumed; then the empty folder."""
    try:
        for pattern in (f"*{_PIECE}", ".radtex-*", KEY):
            for path in folder.glob(pattern):
                path.unlink(missing_ok=True)
        if folder.is_dir() and not any(folder.iterdir()):
            folder.rmdir()
    except OSError as error:
        raise BakeError(f"{folder} could not be removed: {error.strerror or error}; remove it") from error


def _write_piece(path: Path, mark: dict[str, str], arrays: Arrays) -> None:
    with path.open("wb") as stream:
        hashing = _Hashing(stream)
        hashing.write((json.dumps({**mark, "arrays": list(arrays)}) + "\n").encode())
        for array in arrays.values():
            _FORMAT.write_array(hashing, array, allow_pickle=False)
        stream.write(hashing.digest())


def _read_piece(path: Path, mark: dict[str, str]) -> Arrays:
    """Raises OSError, FileNotFoundError among them, and ValueError for what is not this piece, whole."""
    with path.open("rb") as stream:
        left = path.stat().st_size - _DIGEST_BYTES
        found = hashlib.sha256()
        while left > 0 and (chunk := stream.read(min(_CHUNK, left))):
            found.update(chunk)
            left -= len(chunk)
        if left or stream.read() != found.digest():
            raise ValueError("its digest is wrong")
        stream.seek(0)
        says = json.loads(stream.readline())
        names = says.pop("arrays")
        if says != mark:
            raise ValueError("it is of another bake")
        return {name: _FORMAT.read_array(stream, allow_pickle=False) for name in names}


class _Hashing:
    """A stream to write to, and the digest of what was written."""

    def __init__(self, stream: BinaryIO) -> None:
        self._stream, self._hash = stream, hashlib.sha256()

    def write(self, data: bytes) -> int:
        self._hash.update(data)
        return self._stream.write(data)

    def digest(self) -> bytes:
        return self._hash.digest()
