# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that somebody else may have put there: regular ones alone are opened, and read up to a limit.

A pipe (FIFO) would keep us waiting for ever, a device has no end, and a sparse file says that it is larger
than any memory.
"""

from __future__ import annotations

import errno
import os
import stat
from io import BufferedReader
from pathlib import Path

from .memory import readable_size

MOST_TEXT = 64 << 20  # bytes of a sidecar, a manifest or another text of ours; nearly all have a few thousand

FOLDER = "a folder"  # as `other_kind` says it

_KINDS = (
    (stat.S_ISDIR, FOLDER),
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)
_FLAGS = os.O_RDONLY | getattr(os, "O_BINARY", 0) | getattr(os, "O_CLOEXEC", 0) | getattr(os, "O_NOCTTY", 0)


def other_kind(path: Path) -> str | None:
    """What is at `path` (or where a link there leads) if that is no regular file, such as "a pipe".

    None for a file, and where nothing is, or where access is refused.
    """
    try:
        return _kind(path.stat().st_mode)
    except (OSError, ValueError):
        return None


def open_regular(path: Path) -> BufferedReader:
    """Open a regular file for reading, and never wait for one.

    Raises OSError for what cannot be opened, and for what is none.
    """
    _refuse(path, path.stat())  # to open some devices does something
    descriptor = os.open(path, _FLAGS | getattr(os, "O_NONBLOCK", 0))
    try:
        _refuse(path, os.fstat(descriptor))  # another may have come in its place
        return os.fdopen(descriptor, "rb")
    except BaseException:
        os.close(descriptor)
        raise


def read_regular(path: Path, most: int = MOST_TEXT) -> bytes:
    """All bytes of a regular file, which are `most` at most.

    Raises OSError as `open_regular` does, and for a file that is larger.
    """
    with open_regular(path) as file:
        size = os.fstat(file.fileno()).st_size
        data = file.read(most + 1) if size <= most else b""
    if max(size, len(data)) > most:
        said = f"it has {readable_size(size)}, and nothing of its kind more than {readable_size(most)}"
        raise OSError(errno.EFBIG, said, str(path))
    return data


def _refuse(path: Path, found: os.stat_result) -> None:
    kind = _kind(found.st_mode)
    if kind is not None:
        raise OSError(errno.EINVAL, f"it is {kind} and no file", str(path))


def _kind(mode: int) -> str | None:
    if stat.S_ISREG(mode):
        return None
    return next((name for is_kind, name in _KINDS if is_kind(mode)), "no regular file")
