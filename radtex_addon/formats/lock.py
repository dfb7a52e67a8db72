# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Locks on files: one process has it, and the system takes it back from one that dies, however it dies.

A process's number would not do: numbers come again, and mean nothing on another machine.
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

_TRIES, _PAUSE = 4, 0.05  # seconds; whoever only looks has the lock for a moment
_FAR = 1 << 30  # what Windows locks nobody else can read: a byte far behind the text
_OWN = b"process "  # how the text in a lock's file begins
_FLAGS = os.O_RDWR | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_CLOEXEC", 0)


class HeldError(Exception):
    """Another has the lock; the message says who, such as "process 12 on tower"."""


class NoLockError(OSError):
    """Something else has a lock's name; the message is one line that says what to do."""


class Lock:
    """A lock that is ours until it is released, or nobody refers to it any more; its file goes away then.

    `is_sure` is False where the filesystem knows no locks: then others believe that they have it, too.
    """

    def __init__(self, path: Path, descriptor: int, is_sure: bool) -> None:
        self.is_sure = is_sure
        self._end = weakref.finalize(self, _give_back, path, descriptor)

    def release(self) -> None:
        """Let others have it."""
        self._end()


def take_lock(path: Path) -> Lock:
    """Lock the file `path`, which need not be there, in a folder that is.

    Raises HeldError where another has it, NoLockError where something else has that name (nothing is written
    behind a link, and into no file but a lock's), OSError where the system refuses.
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
    """Who has the lock on the file `path`, None for nobody. Raises NoLockError for something else."""
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
        os.close(descriptor)  # it was removed while we waited: another file has its name


def _opened(path: Path, more: int = 0) -> int:
    """A descriptor of a file called so, of no link, pipe, device or folder. Raises NoLockError, OSError."""
    with suppress(FileNotFoundError):  # Windows has no flag for links, and devices are better not opened
        _refuse_others(path, path.lstat())
    descriptor = os.open(path, _FLAGS | more, 0o666)
    try:
        _refuse_others(path, os.fstat(descriptor))
    except BaseException:
        os.close(descriptor)
        raise
    return descriptor


def _refuse_others(path: Path, found: os.stat_result) -> None:
    """Raises NoLockError for what is no file, or has other names too, behind which others' files may be."""
    if stat.S_ISLNK(found.st_mode) or found.st_nlink > 1:
        raise NoLockError(f"{path} is a link, where RadTex keeps a lock: remove it")
    if not stat.S_ISREG(found.st_mode):
        raise NoLockError(f"{path} is no file, where RadTex keeps a lock: remove it")


def _refuse_text(path: Path, descriptor: int) -> None:
    """Raises NoLockError for a file that holds no lock's text, nor what a kill left of one."""
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
    """False where the filesystem knows no locks. Raises HeldError."""
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
    """Remove the file while it is ours; Windows removes none that is open."""
    if sys.platform == "win32":
        os.close(descriptor)
    with suppress(OSError):
        path.unlink()
    if sys.platform != "win32":
        os.close(descriptor)
