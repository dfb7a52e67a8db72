# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""An exported folder appears whole or not at all, and replaces only what an export wrote before."""

from __future__ import annotations

import os
import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ..core.errors import BakeError, InputError
from ..formats.atomic import check_writable, mark_of

LIST = ".radtex-files"  # names what an export wrote, so that the next one knows what is the user's


def check_out(out: Path, bake: Path, overwrite: bool) -> None:
    """Make sure that writing the folder `out` loses nothing; `bake` is the folder exported from.

    Raises InputError for a place that cannot be written, that holds the bake itself, or that holds something
    else than an earlier export.
    """
    ours, theirs = out.resolve(), bake.resolve()
    if theirs.is_relative_to(ours):
        raise InputError(f"{out} holds the bake itself: choose another folder (--out)")
    if out.is_symlink() or (out.exists() and not out.is_dir()):
        raise InputError(f"{out} is a file, or a link: choose another folder (--out)")
    if out.is_dir() and any(out.iterdir()):
        if not (out / LIST).is_file():
            raise InputError(f"{out} holds other things than an export: choose another folder (--out)")
        if not overwrite:
            raise InputError(f"{out} is already there: overwrite it (--overwrite), or choose another (--out)")
    check_writable(out.parent)


@contextmanager
def replacing_folder(out: Path) -> Iterator[Path]:
    """Yield a new folder beside `out`, which takes its name when all went well.

    What lay in `out` and was not written by an export stays in it. After any error or interruption `out` is
    what it was. Raises BakeError where the system refuses.
    """
    mark = secrets.token_hex(8)
    beside = out.with_name(f"{mark_of(os.getpid())}{mark}")
    old = out.with_name(f".radtex-{mark}-old")  # nothing unfinished: nobody may remove it
    try:
        beside.mkdir(parents=True)
        try:
            yield beside
            _list(beside)
            _keep_others(out, beside)
            _swap(beside, out, old)
        finally:
            shutil.rmtree(beside, ignore_errors=True)
    except OSError as error:
        reason = str(error.strerror or error).replace(str(beside), str(out))
        raise BakeError(f"{out} could not be written: {reason}; free its disk, or choose another") from error


def files_in(folder: Path) -> list[str]:
    """All files below a folder, relative to it, with slashes."""
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())


def _list(folder: Path) -> None:
    (folder / LIST).write_text("\n".join([*files_in(folder), LIST]) + "\n", encoding="utf-8", newline="\n")


def _keep_others(before: Path, after: Path) -> None:
    """Copy what others put into the folder; what is ours goes first."""
    if not (before / LIST).is_file():
        return
    written = set((before / LIST).read_text(encoding="utf-8").splitlines())
    for name in files_in(before):
        if name not in written and not (after / name).exists():
            (after / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(before / name, after / name)


def _swap(new: Path, place: Path, old: Path) -> None:
    if not place.exists():
        new.rename(place)
        return
    place.rename(old)
    try:
        new.rename(place)
    except OSError:
        old.rename(place)
        raise
    shutil.rmtree(old, ignore_errors=True)
