# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What is finished of a bake, kept in a folder, so that a kill at any moment costs one render and no more.

A piece is some arrays under a name (`pieces.py`). It is written beside and renamed. The key says what the
pieces belong to: a bake that differs in any fact of it may not use them. Whoever works on them has a lock.
"""

from __future__ import annotations

import hashlib
import json
import logging
import os
from collections.abc import Callable, Iterable
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy.typing as npt

from ..core.errors import BakeError, InputError
from ..formats.atomic import refusal, remove_unfinished, replacing
from ..formats.json_reader import shown
from ..formats.lock import HeldError, Lock, NoLockError, holder, take_lock
from .keeper import Keeper
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
from .pieces import PIECE, Arrays, read_piece, read_rows, write_piece
from .written import drop_waiting, move_out, waiting_place

log = logging.getLogger(__name__)


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
        return sorted(path.stem for path in self._folder.glob(f"*{PIECE}"))

    def found(self, name: str) -> Arrays | None:
        if self._known is None and not self._begun:
            return None
        path = self._folder / f"{name}{PIECE}"
        try:
            piece = read_piece(path, self._mark(name))
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
        with replacing(self._folder / f"{name}{PIECE}") as beside:
            write_piece(beside, self._mark(name), arrays)

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
        path = self._folder / f"{name}{PIECE}"
        try:
            return read_rows(path, array, first, count)
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
        for pattern in (f"*{PIECE}", ".radtex-*", KEY):
            for path in folder.glob(pattern):
                path.unlink(missing_ok=True)
    except OSError as error:
        raise BakeError(_stays(folder, error)) from error


def _stays(folder: Path, error: OSError) -> str:
    return f"{folder} could not be removed: {error.strerror or error}; remove it"
