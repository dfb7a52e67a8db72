# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What is finished of a bake, kept in a folder, so that a kill at any moment costs one render and no more.

A piece is some arrays under a name. It is written beside and renamed; its file ends with a digest of all that
stands before, so that one that was half written, or damaged later, is noticed and made again. The key says
what the pieces belong to: a bake that differs in any fact of it may not use them. Whoever works on them has
a lock.
"""

from __future__ import annotations

import hashlib
import json
import logging
import os
from collections.abc import Callable, Iterable
from contextlib import suppress
from math import prod
from pathlib import Path
from typing import Any, BinaryIO, TypeAlias

import numpy as np
import numpy.typing as npt

from ..core.errors import BakeError, InputError
from ..formats.atomic import refusal, remove_unfinished, replacing
from ..formats.facts import shown
from ..formats.lock import HeldError, Lock, NoLockError, holder, take_lock
from ..formats.regular import MOST_TEXT, open_regular
from .key import (
    KEY,
    LOCK,
    Facts,
    Key,
    in_use,
    is_announced,
    is_unfinished,
    read_key,
    workers,
    write_key,
)
from .written import drop_waiting, move_out, waiting_place

log = logging.getLogger(__name__)

Arrays: TypeAlias = dict[str, npt.NDArray[Any]]

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


class Checkpoint(Keeper):
    """Keeps pieces in `folder`, which appears with the first of them, and is this bake's until it is closed.

    The first piece that is kept or found raises InputError where another process works on them.
    """

    def __init__(
        self,
        folder: Path,
        resume: bool,
        replaces: Iterable[Path] = (),
        check: Callable[[], None] = lambda: None,
    ) -> None:
        """Go on with what `folder` holds if `resume`, else begin anew, and drop that at the first piece.

        Before it is dropped, and once nobody else can write there, `check` may raise InputError for what has
        come meanwhile.

        `replaces` are the files that the bake may put in the place of others. Raises InputError for a key
        that cannot be read.
        """
        self._folder = folder
        self._facts: dict[str, str] = {}
        self._known = read_key(folder) if resume and is_unfinished(folder) else None
        self._replaces = sorted({path.name for path in replaces})
        if self._known is not None and not self._known.facts:  # it was only announced
            self._known = None
        self._made = None if self._known is None else self._known.made
        self._workers: list[int] = []
        self._lock: Lock | None = None
        self._check = check

    def __enter__(self) -> Checkpoint:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Let others go on with what is kept. Of files that were written nothing is, unless all were."""
        if self._lock is None:
            return
        if self._made is None:
            with suppress(OSError):
                drop_waiting(self._folder)
        self._lock.release()

    def begin(self) -> None:
        """Take the lock, and say so, before there is a piece. Raises as the first piece does."""
        if not self._begun:
            self._begin()

    @property
    def _begun(self) -> bool:
        return self._lock is not None

    def expect(self, facts: Facts) -> None:
        self._facts.update(facts)
        if self._known is None:
            return
        if said := self._known.differences(facts):
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
        except Exception as error:  # noqa: BLE001  # numpy's parser of headers raises whatever it meets
            log.warning(
                "%s is damaged and is made again (%s)", path, shown(" ".join(str(error).split()), 200)
            )
            return None
        if not self._begun:
            self._begin()
        return piece

    def keep(self, name: str, arrays: Arrays) -> None:
        if not self._begun:
            self._begin()
        elif not is_unfinished(self._folder):
            raise self._gone()
        with replacing(self._folder / f"{name}{_PIECE}") as beside:
            _write_piece(beside, self._mark(name), arrays)

    def place(self, path: Path) -> Path:
        if not self._begun:
            self._begin()
        return waiting_place(self._folder, path)

    @property
    def made(self) -> dict[str, Any] | None:
        """What the bake came to, if all its files are written: these may be in their places or not."""
        return self._made

    def settle(self, made: dict[str, Any]) -> None:
        """Give the files their places, all of which are written: the bake came to what `made` says.

        From here on it is gone on with behind this. Raises BakeError where the system refuses.
        """
        if not self._begun:
            self._begin()
        self._made = made
        self._write_key()
        move_out(self._folder, self._replaces)

    @property
    def keeps(self) -> bool:
        return True

    def rows(self, name: str, array: str, first: int, count: int) -> npt.NDArray[Any]:
        path = self._folder / f"{name}{_PIECE}"
        try:
            return _read_rows(path, array, first, count)
        except OSError as error:
            reason = error.strerror or str(error)
        except Exception as error:  # noqa: BLE001  # numpy's parser of headers raises whatever it meets
            reason = f"it is damaged ({shown(' '.join(str(error).split()), 200)})"
        raise BakeError(f"{path} can no longer be read: {reason}; bake again")

    def remove(self) -> None:
        """Drop all pieces, and what killed processes were writing: the bake is done.

        Raises BakeError where the system refuses.
        """
        self._drop()

    def drop_own(self) -> None:
        """Drop what this bake has kept, or that it was announced, unless it went on with another's."""
        if self._known is None and (self._begun or is_announced(self._folder)):
            self._drop()

    def _drop(self) -> None:
        """The key goes first: killed behind that, the bake is over, and the next one removes the rest."""
        for pid in self._workers:
            remove_unfinished(self._folder.parent, pid)
        try:
            (self._folder / KEY).unlink(missing_ok=True)
        except OSError as error:
            raise BakeError(_stays(self._folder, error)) from error
        _clear(self._folder)
        self.close()
        remove_left(self._folder)

    def _begin(self) -> None:
        """Take the lock, and write the key."""
        lock = self._taken_lock()
        try:
            self._enter()
        except BaseException:
            lock.release()
            if self._known is None:
                remove_left(self._folder)
            raise
        self._lock = lock

    def _taken_lock(self) -> Lock:
        try:
            if self._known is None:
                self._folder.mkdir(parents=True, exist_ok=True)
            return take_lock(self._folder / LOCK)
        except HeldError as held:
            raise InputError(in_use(self._folder, str(held))) from held
        except NoLockError as error:
            raise InputError(str(error)) from error
        except FileNotFoundError as error:
            raise self._gone() from error
        except OSError as error:
            raise BakeError(refusal(self._folder, error)) from error

    def _enter(self) -> None:
        self._workers = workers(self._folder)
        if self._known is None:
            self._check()
            _clear(self._folder)
        elif not is_unfinished(self._folder):  # whoever had the lock has finished the bake
            raise self._gone()
        else:
            self._replaces = sorted({*self._replaces, *self._known.replaces})
        if self._made is None:
            with suppress(OSError):
                drop_waiting(self._folder)
        self._write_key()

    def _write_key(self) -> None:
        facts = self._facts if self._known is None else self._known.facts
        write_key(self._folder, Key(facts, self._replaces, [*self._workers, os.getpid()], self._made))

    def _gone(self) -> BakeError:
        return BakeError(f"{self._folder} has gone while the bake ran: bring its disk back, or bake again")

    def _mark(self, name: str) -> dict[str, str]:
        """What a piece's file says of itself: one of another bake, or under another's name, is no use."""
        facts = json.dumps(self._facts, sort_keys=True)
        return {"piece": name, "of": hashlib.sha256(facts.encode()).hexdigest()}


def remove_left(folder: Path) -> None:
    """Remove what a process that was killed amid its end left in `folder`; what is not ours stays.

    So does a bake that is unfinished, or that somebody works on. Raises BakeError.
    """
    lock = folder / LOCK
    try:
        if folder.is_symlink() or not folder.is_dir() or is_unfinished(folder) or holder(lock) is not None:
            return
        _clear(folder)
        if set(folder.iterdir()) <= {lock}:
            lock.unlink(missing_ok=True)
            folder.rmdir()
    except OSError as error:
        raise BakeError(_stays(folder, error)) from error


def _clear(folder: Path) -> None:
    """Remove what we wrote, the key last: killed before that, it can be resumed."""
    try:
        drop_waiting(folder)
        for pattern in (f"*{_PIECE}", ".radtex-*", KEY):
            for path in folder.glob(pattern):
                path.unlink(missing_ok=True)
    except OSError as error:
        raise BakeError(_stays(folder, error)) from error


def _stays(folder: Path, error: OSError) -> str:
    return f"{folder} could not be removed: {error.strerror or error}; remove it"


def _write_piece(path: Path, mark: dict[str, str], arrays: Arrays) -> None:
    with path.open("wb") as stream:
        hashing = _Hashing(stream)
        hashing.write((json.dumps({**mark, "arrays": list(arrays)}) + "\n").encode())
        for array in arrays.values():
            _FORMAT.write_array(hashing, array, allow_pickle=False)
        stream.write(hashing.digest())


def _read_piece(path: Path, mark: dict[str, str]) -> Arrays:
    """Raises OSError, FileNotFoundError among them, and anything else for what is not this piece, whole."""
    with open_regular(path) as stream:
        end = left = os.fstat(stream.fileno()).st_size - _DIGEST_BYTES
        found = hashlib.sha256()
        while left > 0 and (chunk := stream.read(min(_CHUNK, left))):
            found.update(chunk)
            left -= len(chunk)
        if left or stream.read() != found.digest():
            raise ValueError("its digest is wrong")
        stream.seek(0)
        says = json.loads(stream.readline(MOST_TEXT))
        names = says.pop("arrays")
        if says != mark:
            raise ValueError("it is of another bake")
        return {name: _read_array(stream, end) for name in names}


def _read_array(stream: BinaryIO, end: int) -> npt.NDArray[Any]:
    """An array that lies before `end`: its header is not believed before memory is taken."""
    place = stream.tell()
    _array_header(stream, end)
    stream.seek(place)
    array: npt.NDArray[Any] = _FORMAT.read_array(stream, allow_pickle=False)
    return array


def _read_rows(path: Path, array: str, first: int, count: int) -> npt.NDArray[Any]:
    """Rows of an array of a piece that was whole. Raises OSError, and anything else where it is no more."""
    with open_regular(path) as stream:
        end = os.fstat(stream.fileno()).st_size - _DIGEST_BYTES
        before = json.loads(stream.readline(MOST_TEXT))["arrays"].index(array)
        shape, dtype = _array_header(stream, end)
        for _ in range(before):
            stream.seek(prod(shape) * dtype.itemsize, os.SEEK_CUR)
            shape, dtype = _array_header(stream, end)
        if not 0 <= first <= first + count <= shape[0]:
            raise ValueError("it has other rows")
        stream.seek(first * prod(shape[1:]) * dtype.itemsize, os.SEEK_CUR)
        found: npt.NDArray[Any] = np.fromfile(stream, dtype, count * prod(shape[1:]))
        if found.size != count * prod(shape[1:]):
            raise OSError("it has become shorter")
        return found.reshape(count, *shape[1:])


def _array_header(stream: BinaryIO, end: int) -> tuple[tuple[int, ...], np.dtype[Any]]:
    """Shape and type of an array that lies before `end`. Raises ValueError for one that does not."""
    version = _FORMAT.read_magic(stream)
    shape, _, dtype = _FORMAT.read_array_header_1_0(stream)
    if version != (1, 0) or min(shape, default=0) < 0 or prod(shape) * dtype.itemsize > end - stream.tell():
        raise ValueError("an array in it is not of its size")
    return shape, dtype


class _Hashing:
    """A stream to write to, and the digest of what was written."""

    def __init__(self, stream: BinaryIO) -> None:
        self._stream, self._hash = stream, hashlib.sha256()

    def write(self, data: bytes) -> int:
        self._hash.update(data)
        return self._stream.write(data)

    def digest(self) -> bytes:
        return self._hash.digest()
