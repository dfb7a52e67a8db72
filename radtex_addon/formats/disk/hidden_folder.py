# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Hidden temporary folders beside the output, on the same disk; the next bake removes what a kill left."""

from __future__ import annotations

import os
import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from .lock import HeldError, Lock, take_lock

_ENDING = ".folder"
LOCK = "lock"  # a file in the folder, locked by the process that owns the folder


def mark_of(pid: int) -> str:
    """The prefix of the names of unfinished files and folders of the process `pid`."""
    return f".radtex-{pid}-"


@contextmanager
def hidden_folder(parent: Path) -> Iterator[Path]:
    """Yield a new hidden folder in `parent`, which is created if needed; the new folder is removed at exit.

    It contains the file LOCK. Folders beside it with the same stem and other suffixes are removed with it.
    Folders that dead processes left in `parent` are removed first. Raises OSError where the system refuses.
    """
    parent.mkdir(parents=True, exist_ok=True)
    _remove_left(parent)
    folder, lock = _make(parent)
    try:
        yield folder
    finally:
        _remove(folder, lock)


def _remove(folder: Path, lock: Lock) -> None:
    """Remove the folder last: if this process is killed before that, another one can find and remove it."""
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
        except (HeldError, FileNotFoundError):  # another process took or removed it before
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
    """Whether this user owns the folder: others may write to the same place."""
    return not hasattr(os, "getuid") or folder.stat().st_uid == os.getuid()
