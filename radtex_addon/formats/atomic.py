# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Files appear whole or not at all: written beside their place, then renamed.

The disk has a file before its name changes, and the name before we go on: a power cut leaves it whole, too.
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

from ..core.errors import BakeError, InputError, RadTexError
from .hidden_folder import LOCK, hidden_folder, mark_of
from .path_checks import nearest_folder

_BESIDE = re.compile(r"\.radtex-\d+-[0-9a-f]{16}")  # names that `replacing` yields
_REASONS = [os.strerror(code) for code in (errno.ENOSPC, errno.EROFS, errno.EACCES, errno.EPERM, errno.EIO)]


@contextmanager
def replacing(path: Path, lasting: bool = True) -> Iterator[Path]:
    """Yield a new name in `path`'s folder; what is written under it takes the name `path` when all went well.

    After any error or interruption nothing is left and `path` is what it was. Makes the folder if need be.
    What is not `lasting` need not outlive a power cut. Raises BakeError where the system refuses.
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
                settle_names(path.parent)
        finally:
            beside.unlink(missing_ok=True)
    except OSError as error:
        if beside.name not in str(error) and _BESIDE.search(str(error)):
            raise  # it is of another file, whose turn comes
        raise BakeError(refusal(path, error).replace(str(beside), str(path))) from error


@contextmanager
def replacing_together(path: Path) -> Iterator[Path]:
    """Yield `path`'s name in a new folder beside it; all that is written there moves out when all went well.

    `path` itself moves last, so that it speaks of no file that is not there. After any error or interruption
    before that nothing is left and all is what it was; our errors then name the files by their places. Makes
    the folder if need be. Raises BakeError where the system refuses.
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
            settle_names(path.parent)
    except RadTexError as error:
        if place is None or place not in str(error):
            raise
        raise type(error)(str(error).replace(place, str(path.parent))) from error
    except OSError as error:
        raise BakeError(refusal(path, error)) from error


def write_text(path: Path, text: str) -> None:
    """Write `text` to `path` in UTF-8, whole or not at all. Raises BakeError where the system refuses."""
    with replacing(path) as beside:
        beside.write_text(text, encoding="utf-8", newline="\n")


def remove_unfinished(folder: Path, pid: int) -> None:
    """Remove what the process `pid`, which was killed, has not finished in `folder`."""
    for path in folder.glob(f"{mark_of(pid)}*"):
        with suppress(OSError):
            if path.is_dir():
                shutil.rmtree(path)
            else:
                path.unlink()


def check_writable(folder: Path) -> None:
    """Make sure that files can be put into `folder`, which need not exist yet; leaves nothing there.

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
    """Make sure that writing `paths` destroys nothing, or may. Raises InputError for the first in the way."""
    for path in paths:
        if path.is_dir():
            raise InputError(f"{path} is a folder where a file must go: move it, or choose another folder")
        if os.path.lexists(path) and not overwrite:  # a link that leads nowhere is there, too
            raise InputError(f"{path} is already there: overwrite it (--overwrite), or choose another folder")


def _settle(file: Path) -> None:
    """Wait until the disk has what is in the file; some systems say only now that it is full."""
    with file.open("r+b") as stream:  # Windows settles nothing that is open for reading alone
        os.fsync(stream.fileno())


def settle_names(folder: Path) -> None:
    """Wait until the disk has the names in the folder, where the system can be asked for that."""
    if sys.platform == "win32":
        return
    with suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


def refusal(path: Path, error: OSError) -> str:
    """What to say where the system does not let us write `path`; libraries wrap its reason in words."""
    said = str(error)
    reason = error.strerror or next((known for known in _REASONS if known in said), said)
    return f"{path} could not be written: {reason}; free its disk, or choose another"
