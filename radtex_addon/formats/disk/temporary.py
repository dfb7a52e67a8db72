# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Temporary folders; each process also removes those that killed processes left."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from ...core.errors import BakeError, InputError
from .lock import HeldError, Lock, take_lock
from .path_checks import check_rendered_into, one_root

PREFIX = "radtex-temporary-"
_LOCK = "lock"  # a file in the folder, locked by the process that owns the folder
_open: set[Path] = set()  # this process's


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
    _remove_left(root)
    try:
        folder, lock = _make(root)
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
        lock.release()
        shutil.rmtree(folder, ignore_errors=True)


def remove_open() -> None:
    """Remove this process's folders, as before an end in whose course they would stay."""
    for folder in list(_open):
        shutil.rmtree(folder, ignore_errors=True)


def _make(root: Path) -> tuple[Path, Lock]:
    while True:
        folder = Path(tempfile.mkdtemp(prefix=PREFIX, dir=root))
        try:
            return folder, take_lock(folder / _LOCK)
        except (HeldError, FileNotFoundError):  # another process took or removed it before
            continue
        except OSError:
            shutil.rmtree(folder, ignore_errors=True)
            raise


def _remove_left(root: Path) -> None:
    """Remove the folders of processes that have ended."""
    for folder in root.glob(f"{PREFIX}*"):
        with suppress(OSError, HeldError):
            if not _is_own(folder):
                continue
            lock = take_lock(folder / _LOCK)
            if lock.is_sure:
                shutil.rmtree(folder, ignore_errors=True)
            lock.release()


def _is_own(folder: Path) -> bool:
    """Whether it is a folder (no link) and owned by this user: others may write to the same place."""
    if folder.is_symlink() or not folder.is_dir():
        return False
    return not hasattr(os, "getuid") or folder.stat().st_uid == os.getuid()
