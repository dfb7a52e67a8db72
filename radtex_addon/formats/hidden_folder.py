# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Hidden folders beside what is being made, on its disk: the next one there removes what a kill left."""

from __future__ import annotations

import os
import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from .lock import HeldError, Lock, take_lock

_ENDING = ".folder"
LOCK = "lock"  # whose folder it is, has this file in it locked


def mark_of(pid: int) -> str:
    """How names begin of what the process `pid` has not finished."""
    return f".radtex-{pid}-"


@contextmanager
def hidden_folder(parent: Path) -> Iterator[Path]:
    """Yield a new hidden folder in `parent`, which is made if need be; the new one goes away at exit.

    The file LOCK is in it. Folders beside it whose names differ in their endings go away with it, and so does
    all that processes left which are no more. Raises OSError where the system refuses.
    """
    parent.mkdir(parents=True, exist_ok=True)
    _remove_left(parent)
    folder, lock = _make(parent)
    try:
        yield folder
    finally:
        _remove(folder, lock)


def _remove(folder: Path, lock: Lock) -> None:
    """The folder itself goes last: killed before that, the next one removes the rest."""
    for path in folder.parent.glob(f"{folder.stem}.*"):
        if path != folder:
            shutil.rmtree(path, ignore_errors=True)
    lock.release()
    shutil.rmtree(folder, ignore_errors=True)


def _make(parent: Path) -> tuple[Path, Lock]:
    while True:
        folder = parent / f"{mark_of(os.getpid())}{secrets.token_hex(8)}{_ENDING}"
        folder.mkdir()
        try:
            return folder, take_lock(folder / LOCK)
        except (HeldError, FileNotFoundError):  # another found it before it was locked
            continue
        except OSError:
            shutil.rmtree(folder, ignore_errors=True)
            raise


def _remove_left(parent: Path) -> None:
    for folder in parent.glob(f".radtex-*{_ENDING}"):
        with suppress(OSError, HeldError):
            if folder.is_symlink() or not folder.is_dir() or not _is_own(folder):
                continue
            lock = take_lock(folder / LOCK)
            if lock.is_sure:
                _remove(folder, lock)
            lock.release()


def _is_own(folder: Path) -> bool:
    """Whether it is this user's: others may write to the same place."""
    return not hasattr(os, "getuid") or folder.stat().st_uid == os.getuid()
