# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""An exported folder: it appears whole, and what others put into it stays where it is.

A new one is made beside its place and renamed. Over an earlier one files are moved one by one, so that what
is not ours is never touched. Meanwhile the list of our files names one that is never there: killed amid the
moves, the folder is known not to be whole, and the next export completes it.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path, PurePosixPath, PureWindowsPath

from ..core.errors import BakeError, InputError, RadTexError
from ..formats.disk.atomic import check_writable
from ..formats.disk.hidden_folder import hidden_folder
from ..formats.disk.regular import read_regular

LIST = ".radtex-files"  # names what an export wrote, so that the next one knows what is the user's
_NOT_WHOLE = ".radtex-unfinished"  # in that list while files are moved; there is no such file


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
    """Yield a new folder beside `out`; all that is written there becomes `out`'s when all went well.

    What lay in `out` and was not written by an export stays as it is, links and empty folders among it. After
    any error or interruption before the end `out` is what it was; our errors then name the files by their
    places. Raises InputError where something is in the way, BakeError where the system refuses.
    """
    place = None
    try:
        with hidden_folder(out.parent) as hidden:
            new = hidden / "new"
            place = str(new)
            new.mkdir()
            yield new
            if (out / LIST).is_file():
                _replace_files(new, out, hidden / "list")
            else:
                _write_list(new / LIST, files_in(new))
                if out.is_dir():  # which is empty
                    out.rmdir()
                new.rename(out)
    except RadTexError as error:
        if place is None or place not in str(error):
            raise
        raise type(error)(str(error).replace(place, str(out))) from error
    except OSError as error:
        reason = str(error.strerror or error).replace(str(place), str(out))
        raise BakeError(f"{out} could not be written: {reason}; free its disk, or choose another") from error


def is_whole(out: Path) -> bool:
    """Whether the folder holds all that the last export wrote there."""
    names = _listed(out)
    return bool(names) and all((out / name).is_file() for name in names)


def files_in(folder: Path) -> list[str]:
    """All files below a folder, relative to it, with slashes."""
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())


def _write_list(path: Path, names: list[str]) -> None:
    path.write_text("\n".join([*names, LIST]) + "\n", encoding="utf-8", newline="\n")


def _listed(out: Path) -> set[str]:
    """The files that exports wrote into the folder, as its list has them; none that lies elsewhere."""
    if not (out / LIST).is_file():
        return set()
    names = read_regular(out / LIST).decode("utf-8", "replace").splitlines()
    return {name for name in names if name and _is_below(name)}


def _is_below(name: str) -> bool:
    path = PurePosixPath(name)
    return not (path.is_absolute() or ".." in path.parts or "\\" in name or PureWindowsPath(name).drive)


def _replace_files(new: Path, out: Path, scratch: Path) -> None:
    """Move the files from `new` into the earlier export `out`, whose other files of ours go.

    Its list names, at every moment, all files there that are ours.
    """
    before, names = _listed(out), files_in(new)
    for name in names:
        _check_free(out, name, before)
    _write_list(scratch, sorted({*before, *names, _NOT_WHOLE} - {LIST}))
    scratch.replace(out / LIST)
    for name in sorted(before - {*names, LIST}):
        _remove(out, name)
    for name in names:
        (out / name).parent.mkdir(parents=True, exist_ok=True)
        (new / name).replace(out / name)
    _write_list(scratch, names)
    scratch.replace(out / LIST)


def _check_free(out: Path, name: str, ours: set[str]) -> None:
    """Raises InputError where a file of this name would take the place of something that is not ours."""
    for folder in _folders_above(out, name):
        if folder.is_symlink() or (folder.exists() and not folder.is_dir()):
            raise InputError(_in_the_way(folder))
    path = out / name
    is_ours = name in ours and path.is_file() and not path.is_symlink()
    if not is_ours and (path.exists() or path.is_symlink()):
        raise InputError(_in_the_way(path))


def _in_the_way(path: Path) -> str:
    return f"{path} is in the way, and no export wrote it: move it, or choose another folder (--out)"


def _remove(out: Path, name: str) -> None:
    """Remove a file that an earlier export wrote, unless it was replaced, and folders that are empty then."""
    path, folders = out / name, _folders_above(out, name)
    if any(folder.is_symlink() for folder in folders) or path.is_symlink() or not path.is_file():
        return
    path.unlink()
    for folder in folders:
        with suppress(OSError):  # it is not empty
            folder.rmdir()


def _folders_above(out: Path, name: str) -> list[Path]:
    """The folders between `out` and a file in it, the innermost first."""
    return [out / folder for folder in PurePosixPath(name).parents if folder.parts]
