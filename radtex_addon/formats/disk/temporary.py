# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Temporary folders, and hidden ones beside the output, on the same disk.

Each has a file that its process locks; other processes remove the folders that killed ones left.
"""

from __future__ import annotations

import os
import secrets
import shutil
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from ...core.errors import BakeError, InputError
from .lock import HeldError, Lock, take_lock
from .path_checks import check_rendered_into, one_root

LOCK = "lock"  # a file in the folder, locked by the process that owns the folder
PREFIX = "radtex-temporary-"
_HIDDEN = ".folder"  # the suffix of a hidden one
_open: set[Path] = set()  # this process's temporary folders


@contextmanager
def temporary_folder() -> Iterator[Path]:
    """Yield a new folder, which is removed at exit. Blender can render into it.

    Raises InputError if Blender would change the folder's path, BakeError where the system refuses it.
    """
    root = Path(one_root(tempfile.gettempdir()))
    try:
        check_rendered_into(root)
    except InputError as error:
        raise InputError(f"the folder for temporary files, {error}, by TMPDIR") from error
    _remove_left(root, f"{PREFIX}*")
    try:
        folder, lock = _make(lambda: Path(tempfile.mkdtemp(prefix=PREFIX, dir=root)))
    except OSError as error:
        raise BakeError(
            f"{root} takes no temporary files: {error.strerror or error}; free its disk, or name another "
            "folder by TMPDIR"
        ) from error
    _open.add(folder)
    try:
        yield folder
    finally:
        _open.discard(folder)
        _remove(folder, lock)


def remove_open() -> None:
    """Remove this process's folders, as before an end in whose course they would stay."""
    for folder in list(_open):
        shutil.rmtree(folder, ignore_errors=True)


def mark_of(pid: int) -> str:
    """The prefix of the names of unfinished files and folders of the process `pid`."""
    return f".radtex-{pid}-"


@contextmanager
def hidden_folder(parent: Path) -> Iterator[Path]:
    """Yield a new hidden folder in `parent`, which is created if needed; the new folder is removed at exit.

    It contains the file LOCK. Folders beside it with the same stem and other suffixes are removed with it.
    Folders that dead processes left in `parent` are removed first. Raises OSError where the system refuses.
    """

    def made() -> Path:
        folder = parent / f"{mark_of(os.getpid())}{secrets.token_hex(8)}{_HIDDEN}"
        folder.mkdir()
        return folder

    parent.mkdir(parents=True, exist_ok=True)
    _remove_left(parent, f".radtex-*{_HIDDEN}")
    folder, lock = _make(made)
    try:
        yield folder
    finally:
        _remove(folder, lock)


def _make(made: Callable[[], Path]) -> tuple[Path, Lock]:
    """A folder that was just `made`, and the lock in it. Raises OSError."""
    while True:
        folder = made()
        try:
            return folder, take_lock(folder / LOCK)
        except (HeldError, FileNotFoundError):  # another process took or removed it before
            continue
        except OSError:
            shutil.rmtree(folder, ignore_errors=True)
            raise


def _remove_left(root: Path, names: str) -> None:
    """Remove the folders with such names of processes that have ended."""
    for folder in root.glob(names):
        with suppress(OSError, HeldError):
            if not _is_own(folder):
                continue
            lock = take_lock(folder / LOCK)
            if lock.is_sure:
                _remove(folder, lock)
            lock.release()


def _remove(folder: Path, lock: Lock) -> None:
    """Remove the folder last: if this process is killed before that, another one can find and remove it."""
    if folder.suffix == _HIDDEN:
        for path in folder.parent.glob(f"{folder.stem}.*"):
            if path != folder:
                shutil.rmtree(path, ignore_errors=True)
    lock.release()
    shutil.rmtree(folder, ignore_errors=True)


def _is_own(folder: Path) -> bool:
    """Whether it is a folder (no link) and owned by this user: others may write to the same place."""
    if folder.is_symlink() or not folder.is_dir():
        return False
    return not hasattr(os, "getuid") or folder.stat().st_uid == os.getuid()
