# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The checkpoint of a bake: a folder of finished pieces, so that a kill costs at most one render.

The key lists the facts that the pieces belong to: a bake that differs in any of them may not use them. The
process that works on the folder holds a lock. Everything is written under a temporary name, then renamed.

The bake's own files wait in a folder inside until all of them are written: all get their final names, or
none. Once all are complete the key records it, and they are moved out by one rename each. If the bake is
killed meanwhile, resuming it moves the others.
"""

from __future__ import annotations

import logging
import os
import shutil
from collections.abc import Callable, Iterable
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy.typing as npt

from ..bake.piece_store import Arrays, Facts, PieceStore
from ..core.errors import BakeError, InputError, RadTexError
from ..core.messages import do
from ..formats.disk.atomic import flush_folder, refusal, remove_unfinished, replacing
from ..formats.disk.lock import HeldError, Lock, NoLockError, holder, take_lock
from ..formats.json_reader import shown
from .checkpoint_files import (
    ANEW,
    KEY,
    LOCK,
    PIECE,
    Key,
    is_unfinished,
    known_key,
    label_of,
    read_key,
    read_piece,
    read_rows,
    write_key,
    write_piece,
)

log = logging.getLogger(__name__)

_WAITING = "written"  # the folder inside in which the bake's own files wait


class Checkpoint(PieceStore):
    """Stores pieces in `folder`, which is created for the first of them and locked until `close`.

    The first piece that is stored or found raises InputError where another process works on the folder. As a
    context it closes itself, and lets our errors name files by their final paths. `made` is the bake's
    result, as given to `publish`, once all its files are written; they may not have their final names yet.
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
        files that have appeared meanwhile. `replaces` are the output files that the bake may overwrite,
        `blend` is the name of the .blend that is baked. Raises InputError for a key that cannot be read.
        """
        self._folder = folder
        self._facts: dict[str, str] = {}
        self._known = read_key(folder) if resume and is_unfinished(folder) else None
        self._replaces = sorted({path.name for path in replaces})
        if self._known is not None and not self._known.facts:  # it was only announced
            self._known = None
        self.made = None if self._known is None else self._known.made
        self._workers: list[int] = []
        self._lock: Lock | None = None
        self._check = check
        self._blend = blend

    def __enter__(self) -> Checkpoint:
        return self

    def __exit__(self, _: object, error: BaseException | None, __: object) -> None:
        self.close()
        if isinstance(error, RadTexError):
            problem = error.message.problem
            said = problem.replace(str(self._folder / _WAITING), str(self._folder.parent))
            if said != problem:
                raise error.saying(said) from error

    def close(self) -> None:
        """Release the lock; pieces stay. Output files are deleted, unless all of them were written."""
        if self._lock is None:
            return
        if self.made is None:
            with suppress(OSError):
                _drop_waiting(self._folder)
        self._lock.release()

    def begin(self) -> None:
        """Take the lock and write the key before the first piece. Raises as the first piece does."""
        if self._begun:
            return
        lock = self._taken_lock()
        try:
            self._enter()
        except BaseException:
            lock.release()
            if self._known is None:
                remove_left(self._folder)
            raise
        self._lock = lock

    @property
    def _begun(self) -> bool:
        return self._lock is not None

    def set_facts(self, facts: Facts) -> None:
        if self._known is None:
            self._facts.update(facts)
            return
        if said := self._known.differences(facts):
            raise InputError(
                f"{self._folder} is of a bake that differs in {said}", do("bake as before"), ANEW
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
        path = self._path(name)
        try:
            piece = read_piece(path, label_of(name, self._facts))
        except FileNotFoundError:
            return None
        except Exception as error:  # noqa: BLE001  # numpy's header parser may raise anything
            log.warning("%s is damaged and is made again (%s)", path, _in_one_line(error))
            return None
        self.begin()
        return piece

    def keep(self, name: str, arrays: Arrays) -> None:
        if self._begun and not is_unfinished(self._folder):
            raise self._gone()
        self.begin()
        with replacing(self._path(name)) as beside:
            write_piece(beside, label_of(name, self._facts), arrays)

    @property
    def keeps(self) -> bool:
        return True

    def rows(self, name: str, array: str, first: int, count: int) -> npt.NDArray[Any]:
        path = self._path(name)
        try:
            return read_rows(path, array, first, count)
        except OSError as error:
            reason = error.strerror or str(error)
        except Exception as error:  # noqa: BLE001  # numpy's header parser may raise anything
            reason = f"it is damaged ({_in_one_line(error)})"
        raise BakeError(f"{path} can no longer be read: {reason}; bake again")

    def place(self, path: Path) -> Path:
        self.begin()
        folder = self._folder / _WAITING
        try:
            folder.mkdir(exist_ok=True)
        except OSError as error:
            raise BakeError(refusal(path, error)) from error
        return folder / path.name

    def publish(self, made: dict[str, Any]) -> None:
        """Record the bake's result `made`, and move its files, all of them written, to their final names.

        A bake that is resumed after this continues with its preview and exports. Raises BakeError where the
        system refuses.
        """
        self.begin()
        self.made = made
        self._write_key()
        self._move_out()

    def remove(self) -> None:
        """Delete all pieces, and temporary files of killed processes: the bake is done.

        The key goes first: if killed after that, the bake is over, and the next one deletes the rest. Raises
        BakeError where the system refuses.
        """
        for pid in self._workers:
            remove_unfinished(self._folder.parent, pid)
        try:
            (self._folder / KEY).unlink(missing_ok=True)
        except OSError as error:
            raise BakeError(_stays(self._folder, error)) from error
        _clear(self._folder)
        self.close()
        remove_left(self._folder)

    def drop_own(self) -> None:
        """Delete this bake's pieces, or its announcement, unless it resumed an earlier bake."""
        if self._known is None and (self._begun or is_announced(self._folder)):
            self.remove()

    def _path(self, name: str) -> Path:
        return self._folder / f"{name}{PIECE}"

    def _taken_lock(self) -> Lock:
        try:
            if self._known is None:
                self._folder.mkdir(parents=True, exist_ok=True)
            return take_lock(self._folder / LOCK)
        except HeldError as held:
            raise InputError(_in_use(self._folder, str(held))) from held
        except NoLockError as error:
            raise InputError(str(error)) from error
        except FileNotFoundError as error:
            raise self._gone() from error
        except OSError as error:
            raise BakeError(refusal(self._folder, error)) from error

    def _enter(self) -> None:
        """Make the folder this bake's, now that the lock is held, and write the key."""
        earlier = known_key(self._folder)
        self._workers = [] if earlier is None else earlier.processes
        if self._known is None:
            self._check()
            _clear(self._folder)
        elif not is_unfinished(self._folder):  # the process that had the lock has finished the bake
            raise self._gone()
        else:
            self._replaces = sorted({*self._replaces, *self._known.replaces})
        if self.made is None:
            with suppress(OSError):
                _drop_waiting(self._folder)
        self._write_key()

    def _write_key(self) -> None:
        facts: Facts = self._facts
        blend = self._blend
        if self._known is not None:
            facts, blend = self._known.facts, self._known.blend or blend
        write_key(self._folder, Key(facts, self._replaces, [*self._workers, os.getpid()], self.made, blend))

    def _move_out(self) -> None:
        """Move the waiting files that the bake may replace to their final places; delete the others.

        The sidecar comes last. The new names are on disk before this returns.
        """
        folder = self._folder / _WAITING
        if folder.is_symlink() or not folder.is_dir():
            return
        sidecar = self._folder.with_suffix(".json").name
        for path in sorted(folder.iterdir(), key=lambda path: (path.name == sidecar, path.name)):
            place = self._folder.with_name(path.name)
            if path.name in self._replaces:
                try:
                    path.replace(place)
                except OSError as error:
                    raise BakeError(refusal(place, error)) from error
        flush_folder(self._folder.parent)
        _drop_waiting(self._folder)

    def _gone(self) -> BakeError:
        return BakeError(f"{self._folder} has gone while the bake ran: bring its disk back, or bake again")


def announce(folder: Path, replaces: Iterable[Path], blend: str = "") -> None:
    """Mark a bake as unfinished before it starts, so that resuming a killed run of several bakes includes it.

    Makes a checkpoint without pieces in `folder`; `replaces` and `blend` are as for `Checkpoint`. Raises
    InputError where a process works on it, BakeError where the system refuses.
    """
    publish_earlier(folder)
    with Checkpoint(folder, False, replaces, blend=blend) as coming:
        coming.begin()


def is_announced(folder: Path) -> bool:
    """Whether the bake in `folder` was only announced and has not started."""
    key = known_key(folder)
    return key is not None and not key.facts


def publish_earlier(folder: Path) -> None:
    """If a bake was killed while its finished files were moved to their final names, move the others too.

    Raises InputError where a process works on it, BakeError where the system refuses.
    """
    if not is_unfinished(folder):
        return
    try:
        key = read_key(folder)
    except InputError:  # a new bake does not need the old key
        return
    if key.made is not None:
        with Checkpoint(folder, resume=True) as left:
            left.publish(key.made)


def replaced_by(folder: Path) -> frozenset[str]:
    """The names of files that the unfinished bake in `folder` may replace, as it may have written them.

    Raises InputError for a key that cannot be read.
    """
    return frozenset(read_key(folder).replaces) if is_unfinished(folder) else frozenset()


def check_free(folder: Path) -> None:
    """Raises InputError where a process works on the bake in `folder`, or its lock is no lock file."""
    try:
        who = holder(folder / LOCK)
    except NoLockError as error:
        raise InputError(str(error)) from error
    if who:
        raise InputError(_in_use(folder, who))


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
        _drop_waiting(folder)
        for pattern in (f"*{PIECE}", ".radtex-*", KEY):
            for path in folder.glob(pattern):
                path.unlink(missing_ok=True)
    except OSError as error:
        raise BakeError(_stays(folder, error)) from error


def _drop_waiting(folder: Path) -> None:
    """Delete the waiting files, and temporary files of killed processes beside them. Raises OSError."""
    waiting = folder / _WAITING
    if waiting.is_dir() and not waiting.is_symlink():
        shutil.rmtree(waiting)


def _in_use(folder: Path, who: str) -> str:
    return f"{folder} is in use, {who} bakes into it: wait for its end, or end it"


def _stays(folder: Path, error: OSError) -> str:
    return f"{folder} could not be removed: {error.strerror or error}; remove it"


def _in_one_line(error: Exception) -> str:
    return shown(" ".join(str(error).split()), 200)
