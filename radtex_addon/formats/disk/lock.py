# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""File locks: one process holds a lock, and the system releases it when that process ends, however it ends.

A file with a process id would not do: ids are reused, and mean nothing on another machine.
"""

from __future__ import annotations

import os
import socket
import stat
import sys
import weakref
from contextlib import suppress
from pathlib import Path
from time import sleep

if sys.platform == "win32":
    import msvcrt
else:
    import fcntl

_TRIES, _PAUSE = 4, 0.05  # seconds; `holder` in another process takes the lock for a moment
_FAR = 1 << 30  # on Windows other processes cannot read locked bytes: lock one far behind the text
_OWN = b"process "  # the beginning of a lock file's text
_FLAGS = os.O_RDWR | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_CLOEXEC", 0)


class HeldError(Exception):
    """Another process holds the lock; the message names it, such as "process 12 on tower"."""


class NoLockError(OSError):
    """The lock's path is not a lock file; the message is one line that says what to do."""


class Lock:
    """A lock that we hold until it is released or garbage-collected; its file is then removed.

    `is_sure` is False if the filesystem has no locks: then several processes may hold it at once.
    """

    def __init__(self, path: Path, descriptor: int, is_sure: bool) -> None:
        self.is_sure = is_sure
        self._end = weakref.finalize(self, _give_back, path, descriptor)
        _held.add(self)

    def release(self) -> None:
        """Release the lock and remove its file."""
        self._end()


_held = weakref.WeakSet[Lock]()  # by this process


def release_all() -> None:
    """Release this process's locks, as before an end in whose course their files would stay."""
    for lock in list(_held):
        lock.release()


def take_lock(path: Path) -> Lock:
    """Lock the file `path`, which is created if missing; its folder must exist.

    Raises HeldError if another process holds the lock, NoLockError if `path` is something else than a lock
    file (links are not followed, and other files not overwritten), OSError where the system refuses.
    """
    for left in reversed(range(_TRIES)):
        try:
            return _take(path)
        except HeldError:
            if not left:
                raise
            sleep(_PAUSE)
    raise AssertionError  # the last try returns or raises


def holder(path: Path) -> str | None:
    """The process that holds the lock `path`, or None. Raises NoLockError if it is not a lock file."""
    try:
        descriptor = _opened(path)
    except NoLockError:
        raise
    except OSError:
        return None
    try:
        _lock(descriptor)
    except HeldError as held:
        return str(held)
    finally:
        os.close(descriptor)
    return None


def _take(path: Path) -> Lock:
    while True:
        descriptor = _opened(path, os.O_CREAT)
        try:
            is_sure = _lock(descriptor)
            if _is_file(path, descriptor):
                _refuse_text(path, descriptor)
                os.lseek(descriptor, 0, os.SEEK_SET)
                os.truncate(descriptor, 0)
                os.write(descriptor, f"process {os.getpid()} on {socket.gethostname()}".encode())
                return Lock(path, descriptor, is_sure)
        except BaseException:
            os.close(descriptor)
            raise
        os.close(descriptor)  # the file was removed or replaced before we locked it: try again


def _opened(path: Path, more: int = 0) -> int:
    """Open `path` if it is a regular file. Raises NoLockError for a link, pipe, device or folder; OSError."""
    with suppress(FileNotFoundError):  # Windows has no O_NOFOLLOW, and opening a device may have effects
        _refuse_others(path, path.lstat())
    descriptor = os.open(path, _FLAGS | more, 0o666)
    try:
        _refuse_others(path, os.fstat(descriptor))
    except BaseException:
        os.close(descriptor)
        raise
    return descriptor


def _refuse_others(path: Path, found: os.stat_result) -> None:
    """Raise NoLockError if it is no regular file, or a symbolic or hard link, possibly to another file."""
    if stat.S_ISLNK(found.st_mode) or found.st_nlink > 1:
        raise NoLockError(f"{path} is a link, where RadTex keeps a lock: remove it")
    if not stat.S_ISREG(found.st_mode):
        raise NoLockError(f"{path} is no file, where RadTex keeps a lock: remove it")


def _refuse_text(path: Path, descriptor: int) -> None:
    """Raise NoLockError if the file holds anything but a lock's text or an interrupted part of one."""
    text = _text(descriptor).rstrip(b"\0")
    if not text.startswith(_OWN[: len(text)]):
        raise NoLockError(f"{path} is somebody's file, where RadTex keeps a lock: move it away")


def _text(descriptor: int) -> bytes:
    os.lseek(descriptor, 0, os.SEEK_SET)
    return os.read(descriptor, 1000)


def _is_file(path: Path, descriptor: int) -> bool:
    with suppress(OSError):
        return os.path.samestat(path.lstat(), os.fstat(descriptor))
    return False


def _lock(descriptor: int) -> bool:
    """Try to lock; False if the filesystem has no locks. Raises HeldError if another process holds it."""
    try:
        if sys.platform == "win32":
            os.lseek(descriptor, _FAR, os.SEEK_SET)
            msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
        else:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except (BlockingIOError, PermissionError) as error:
        who = _text(descriptor).decode(errors="replace").strip()
        raise HeldError(who or "another process") from error
    except OSError:
        return False
    finally:
        os.lseek(descriptor, 0, os.SEEK_SET)
    return True


def _give_back(path: Path, descriptor: int) -> None:
    """Remove the file while it is still locked; Windows cannot remove open files, so close it first there."""
    if sys.platform == "win32":
        os.close(descriptor)
    with suppress(OSError):
        path.unlink()
    if sys.platform != "win32":
        os.close(descriptor)
