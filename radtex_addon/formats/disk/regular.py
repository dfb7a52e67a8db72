# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Open untrusted files safely: only regular files, and read no more than a limit.

A pipe (FIFO) could block for ever, a device may have no end, and a sparse file may be larger than memory.
"""

from __future__ import annotations

import errno
import hashlib
import os
import stat
from io import BufferedReader
from pathlib import Path

from ...core.errors import FormatError
from .memory import readable_size

MOST_TEXT = 64 << 20  # bytes of a sidecar, a manifest or another text; nearly all have a few thousand

FOLDER = "a folder"  # result of `other_kind` for a folder

_KINDS = (
    (stat.S_ISDIR, FOLDER),
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)
_FLAGS = os.O_RDONLY | getattr(os, "O_BINARY", 0) | getattr(os, "O_CLOEXEC", 0) | getattr(os, "O_NOCTTY", 0)


def other_kind(path: Path) -> str | None:
    """The kind of thing at `path` (links are followed) if it is no regular file, such as "a pipe".

    None for a regular file, and if nothing is there or access is refused.
    """
    try:
        return _kind(path.stat().st_mode)
    except (OSError, ValueError):
        return None


def open_regular(path: Path) -> BufferedReader:
    """Open a regular file for reading, without blocking.

    Raises OSError if it cannot be opened, or is no regular file.
    """
    _refuse(path, path.stat())  # merely opening some devices has effects
    descriptor = os.open(path, _FLAGS | getattr(os, "O_NONBLOCK", 0))
    try:
        _refuse(path, os.fstat(descriptor))  # it may have been replaced since the first check
        return os.fdopen(descriptor, "rb")
    except BaseException:
        os.close(descriptor)
        raise


def read_regular(path: Path, most: int = MOST_TEXT) -> bytes:
    """Read a regular file of at most `most` bytes.

    Raises OSError as `open_regular` does, and for a larger file.
    """
    with open_regular(path) as file:
        size = os.fstat(file.fileno()).st_size
        data = file.read(most + 1) if size <= most else b""
    if max(size, len(data)) > most:
        said = f"it has {readable_size(size)}, and nothing of its kind more than {readable_size(most)}"
        raise OSError(errno.EFBIG, said, str(path))
    return data


def digest(path: Path) -> str:
    """A file's SHA-256 in hexadecimal digits. Raises FormatError, with the path, if it cannot be read."""
    try:
        with open_regular(path) as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise FormatError(f"{path} cannot be read: {error.strerror or error}") from error


def _refuse(path: Path, found: os.stat_result) -> None:
    kind = _kind(found.st_mode)
    if kind is not None:
        raise OSError(errno.EINVAL, f"it is {kind} and no file", str(path))


def _kind(mode: int) -> str | None:
    if stat.S_ISREG(mode):
        return None
    return next((name for is_kind, name in _KINDS if is_kind(mode)), "no regular file")
