# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Write files atomically: under a temporary name in the same folder, then rename.

The file is flushed to disk (fsync) before the rename, its folder after, so that a power cut does no harm.
"""

from __future__ import annotations

import errno
import os
import re
import secrets
import shutil
import sys
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from ...core.errors import BakeError, InputError, RadTexError
from ...core.messages import Setting, do
from .path_checks import nearest_folder
from .temporary import LOCK, hidden_folder, mark_of

_BESIDE = re.compile(r"\.radtex-\d+-[0-9a-f]{16}")  # the temporary names of `replacing`
_REASONS = [os.strerror(code) for code in (errno.ENOSPC, errno.EROFS, errno.EACCES, errno.EPERM, errno.EIO)]


@contextmanager
def replacing(path: Path, lasting: bool = True) -> Iterator[Path]:
    """Yield a temporary path in `path`'s folder; the file written there is renamed to `path` on success.

    After any error or interruption the temporary file is removed and `path` unchanged. Creates the folder if
    needed. Without `lasting` the file is not flushed to disk. Raises BakeError where the system refuses.
    """
    beside = path.with_name(f"{mark_of(os.getpid())}{secrets.token_hex(8)}{path.suffix}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            yield beside
            if lasting:
                _settle(beside)
            beside.replace(path)
            if lasting:
                flush_folder(path.parent)
        finally:
            beside.unlink(missing_ok=True)
    except OSError as error:
        if beside.name not in str(error) and _BESIDE.search(str(error)):
            raise  # the error is of another file, whose own `replacing` handles it
        raise BakeError(refusal(path, error).replace(str(beside), str(path))) from error


@contextmanager
def replacing_together(path: Path) -> Iterator[Path]:
    """Yield a path named like `path` in a new hidden folder; all files written there move out on success.

    `path` itself moves last, so that it never refers to missing files. After an error or interruption before
    the move everything is as it was; messages of our errors name the final paths. Creates the folder if
    needed. Raises BakeError where the system refuses.
    """
    place = None
    try:
        with hidden_folder(path.parent) as folder:
            place, inside = str(folder), folder / path.name
            yield inside
            files = [file for file in folder.iterdir() if file.name != LOCK]
            for file in files:
                _settle(file)
            for file in sorted(files, key=lambda file: (file == inside, file.name)):
                target = path.with_name(file.name)
                try:
                    file.replace(target)
                except OSError as error:
                    raise BakeError(refusal(target, error)) from error
            flush_folder(path.parent)
    except RadTexError as error:
        problem = error.message.problem
        if place is None or place not in problem:
            raise
        raise error.saying(problem.replace(place, str(path.parent))) from error
    except OSError as error:
        raise BakeError(refusal(path, error)) from error


def write_text(path: Path, text: str) -> None:
    """Write `text` to `path` in UTF-8, atomically. Raises BakeError where the system refuses."""
    with replacing(path) as beside:
        beside.write_text(text, encoding="utf-8", newline="\n")


def remove_unfinished(folder: Path, pid: int) -> None:
    """Remove the temporary files that the killed process `pid` left in `folder`."""
    for path in folder.glob(f"{mark_of(pid)}*"):
        with suppress(OSError):
            if path.is_dir():
                shutil.rmtree(path)
            else:
                path.unlink()


def check_writable(folder: Path) -> None:
    """Make sure that files can be written to `folder`, which need not exist yet; leaves nothing there.

    Raises InputError if not.
    """
    existing = nearest_folder(folder)
    try:
        with tempfile.TemporaryFile(dir=existing, prefix=".radtex-"):
            pass
    except OSError as error:
        reason = error.strerror or error
        raise InputError(f"{folder} cannot be written: {reason}; choose another folder") from error


def check_absent(paths: Iterable[Path], overwrite: bool) -> None:
    """Raise InputError for the first of `paths` that is a folder, or exists while `overwrite` is off."""
    for path in paths:
        if path.is_dir():
            raise InputError(f"{path} is a folder where a file must go: move it, or choose another folder")
        if os.path.lexists(path) and not overwrite:  # broken links count too
            raise InputError(
                f"{path} is already there",
                do("overwrite it", Setting.OVERWRITE),
                do("choose another folder", Setting.OUT),
            )


def _settle(file: Path) -> None:
    """Flush the file's contents to disk; some systems report only now that the disk is full."""
    with file.open("r+b") as stream:  # Windows cannot flush a file that is opened for reading only
        os.fsync(stream.fileno())


def flush_folder(folder: Path) -> None:
    """Flush the names in the folder to disk, where the system supports it."""
    if sys.platform == "win32":
        return
    with suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


def refusal(path: Path, error: OSError) -> str:
    """Message for a failure to write `path`; finds the system's reason also within a library's message."""
    said = str(error)
    reason = error.strerror or next((known for known in _REASONS if known in said), said)
    return f"{path} could not be written: {reason}; free its disk, or choose another"
