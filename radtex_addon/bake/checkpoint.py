# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The checkpoint of a bake: a folder of finished pieces, so that a kill costs at most one render.

A piece is a set of named arrays (`pieces.py`), written under a temporary name and then renamed. The key lists
the facts that the pieces belong to: a bake that differs in any of them may not use them. The process that
works on the folder holds a lock.
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
from ..core.messages import Setting, do
from ..formats.disk.atomic import refusal, remove_unfinished, replacing
from ..formats.disk.lock import HeldError, Lock, NoLockError, holder, take_lock
from ..formats.json_reader import shown
from . import piece_format
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
from .pending_files import drop_waiting, move_out, waiting_place
from .piece_store import PieceStore
from .pieces import PIECE, Arrays, read_piece, read_rows, write_piece

log = logging.getLogger(__name__)


class Checkpoint(PieceStore):
    """Stores pieces in `folder`, which is created for the first of them and locked until `close`.

    The first piece that is stored or found raises InputError where another process works on the folder.
    """

    def __init__(
        self,
        folder: Path,
        resume: bool,
        replaces: Iterable[Path] = (),
        check: Callable[[], None] = lambda: None,
        blend: str = "",
    ) -> None:
        """If `resume`, go on with the pieces in `folder`; else start over, deleting them at the first piece.

        Before they are deleted, but with the lock already held, `check` runs: it may raise InputError for
        files that have appeared meanwhile.

        `replaces` are the output files that the bake may overwrite, `blend` is the name of the .blend that is
        baked. Raises InputError for a key that cannot
        be read.
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
        self._blend = blend

    def __enter__(self) -> Checkpoint:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Release the lock; pieces stay. Output files are deleted, unless all of them were written."""
        if self._lock is None:
            return
        if self._made is None:
            with suppress(OSError):
                drop_waiting(self._folder)
        self._lock.release()

    def begin(self) -> None:
        """Take the lock and write the key before the first piece. Raises as the first piece does."""
        if not self._begun:
            self._begin()

    @property
    def _begun(self) -> bool:
        return self._lock is not None

    def set_facts(self, facts: Facts) -> None:
        if self._known is None:
            self._facts.update(facts)
            return
        if said := self._known.differences(facts):
            raise InputError(
                f"{self._folder} is of a bake that differs in {said}",
                do("bake as before"),
                do("begin anew", Setting.OVERWRITE, without=(Setting.RESUME,)),
            )
        known = self._known.facts  # they may differ by rounding, and pieces are of these
        self._facts.update({name: known[name] for name in facts})

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
        except Exception as error:  # noqa: BLE001  # numpy's header parser may raise anything
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
        """The bake's result, as given to `publish`, once all its files are written; else None.

        The files may not have their final names yet.
        """
        return self._made

    def publish(self, made: dict[str, Any]) -> None:
        """Record the bake's result `made`, and move its files, all of them written, to their final names.

        A bake that is resumed after this continues with its preview and exports. Raises BakeError where the
        system refuses.
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
        except Exception as error:  # noqa: BLE001  # numpy's header parser may raise anything
            reason = f"it is damaged ({shown(' '.join(str(error).split()), 200)})"
        raise BakeError(f"{path} can no longer be read: {reason}; bake again")

    def remove(self) -> None:
        """Delete all pieces, and temporary files of killed processes: the bake is done.

        Raises BakeError where the system refuses.
        """
        self._drop()

    def drop_own(self) -> None:
        """Delete this bake's pieces, or its announcement, unless it resumed an earlier bake."""
        if self._known is None and (self._begun or is_announced(self._folder)):
            self._drop()

    def _drop(self) -> None:
        """Delete all, the key first: if killed after that, the bake is over; the next deletes the rest."""
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
        elif not is_unfinished(self._folder):  # the process that had the lock has finished the bake
            raise self._gone()
        else:
            self._replaces = sorted({*self._replaces, *self._known.replaces})
        if self._made is None:
            with suppress(OSError):
                drop_waiting(self._folder)
        self._write_key()

    def _write_key(self) -> None:
        facts: Facts = self._facts
        blend = self._blend
        if self._known is not None:
            facts, blend = self._known.facts, self._known.blend or blend
        write_key(self._folder, Key(facts, self._replaces, [*self._workers, os.getpid()], self._made, blend))

    def _gone(self) -> BakeError:
        return BakeError(f"{self._folder} has gone while the bake ran: bring its disk back, or bake again")

    def _mark(self, name: str) -> dict[str, str]:
        """The label in a piece's file: a piece of another bake, or of another name, is not used."""
        facts = json.dumps([piece_format.PIECE_FORMAT, self._facts], sort_keys=True)
        return {"piece": name, "of": hashlib.sha256(facts.encode()).hexdigest()}


def remove_left(folder: Path) -> None:
    """Delete from `folder` what a process left that was killed while it cleaned up; other files stay.

    A bake that is unfinished, or that a process works on, stays too. Raises BakeError.
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
    """Delete what RadTex wrote, the key last: if killed before that, the bake can still be resumed."""
    try:
        drop_waiting(folder)
        for pattern in (f"*{PIECE}", ".radtex-*", KEY):
            for path in folder.glob(pattern):
                path.unlink(missing_ok=True)
    except OSError as error:
        raise BakeError(_stays(folder, error)) from error


def _stays(folder: Path, error: OSError) -> str:
    return f"{folder} could not be removed: {error.strerror or error}; remove it"
