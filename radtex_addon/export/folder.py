# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Write an exported folder whole or not at all, and leave alone all files in it that no export wrote.

A new folder is made beside its final place and renamed. Into the folder of an earlier export the files are
moved one by one. During the moves the list of our files has an additional name, which never exists: if the
process is killed then, the folder is recognised as incomplete, and the next export completes it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path, PurePosixPath, PureWindowsPath

from ..core.errors import BakeError, FormatError, InputError, RadTexError
from ..core.messages import Setting, do
from ..formats.disk.atomic import check_writable
from ..formats.disk.regular import digest, read_regular
from ..formats.disk.temporary import hidden_folder

LIST = ".radtex-files"  # the list of all files that exports wrote; other files are the user's
_NOT_WHOLE = ".radtex-unfinished"  # in that list while files are moved; there is no such file


def check_out(out: Path, bake: Path, overwrite: bool) -> None:
    """Make sure that writing the folder `out` loses nothing; `bake` is the bake's own folder.

    Raises InputError for a folder that cannot be written, that contains the bake itself, or that contains
    anything else than an earlier export.
    """
    ours, theirs = out.resolve(), bake.resolve()
    if theirs.is_relative_to(ours):
        raise InputError(f"{out} holds the bake itself", do("choose another folder", Setting.OUT))
    if out.is_symlink() or (out.exists() and not out.is_dir()):
        raise InputError(f"{out} is a file, or a link", do("choose another folder", Setting.OUT))
    if out.is_dir() and any(out.iterdir()):
        if not is_export(out):
            raise InputError(
                f"{out} holds other things than an export", do("choose another folder", Setting.OUT)
            )
        if not overwrite:
            raise InputError(
                f"{out} is already there",
                do("overwrite it", Setting.OVERWRITE),
                do("choose another folder", Setting.OUT),
            )
    check_writable(out.parent)


@contextmanager
def replacing_folder(out: Path) -> Iterator[Path]:
    """Yield a new folder beside `out`; if there was no error, its files are moved to `out` at the end.

    Everything in `out` that no export wrote stays as it is, also links and empty folders. After an error or
    interruption before the end `out` is as it was; our errors then give the files' final paths. Raises
    InputError if something is in the way, BakeError if the system refuses.
    """
    place = None
    try:
        with hidden_folder(out.parent) as hidden:
            new = hidden / "new"
            place = str(new)
            new.mkdir()
            yield new
            if is_export(out):
                _replace_files(new, out, hidden / "list")
            else:
                _write_list(new / LIST, _digests_in(new))
                if out.is_dir():  # which is empty
                    out.rmdir()
                new.rename(out)
    except RadTexError as error:
        problem = error.message.problem
        if place is None or place not in problem:
            raise
        raise error.saying(problem.replace(place, str(out))) from error
    except OSError as error:
        reason = str(error.strerror or error).replace(str(place), str(out))
        raise BakeError(f"{out} could not be written: {reason}; free its disk, or choose another") from error


def is_export(out: Path) -> bool:
    """Whether an earlier export wrote this folder."""
    return (out / LIST).is_file()


def is_whole(out: Path) -> bool:
    """Whether all files of the last export are in the folder."""
    names = _listed(out)
    return bool(names) and all((out / name).is_file() for name in names)


def remove_export(out: Path) -> list[Path]:
    """Delete all files that exports wrote into a folder, and the folder if nothing else is in it.

    Files that were changed after the export stay, and are returned. Raises OSError.
    """
    digests = _digests(out)
    names = sorted(digests.keys() - {LIST})
    changed = [out / name for name in names if _is_changed(out / name, digests[name])]
    for name in names:
        if out / name not in changed:
            _remove(out, name)
    (out / LIST).unlink(missing_ok=True)
    with suppress(OSError):  # it is not empty
        out.rmdir()
    return changed


def _is_changed(path: Path, written: str) -> bool:
    """Whether a file has another digest than what was written, or cannot be read; not without one."""
    try:
        return bool(written) and path.is_file() and digest(path) != written
    except FormatError:
        return True


def files_in(folder: Path) -> list[str]:
    """All files below a folder, relative to it, with slashes."""
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())


def _write_list(path: Path, digests: Mapping[str, str]) -> None:
    """Write the list: a line for each file, its name, a tab, and the digest of its content if it is known."""
    lines = [f"{name}\t{known}" if known else name for name, known in digests.items()]
    path.write_text("\n".join([*lines, LIST]) + "\n", encoding="utf-8", newline="\n")


def _digests_in(folder: Path) -> dict[str, str]:
    return {name: digest(folder / name) for name in files_in(folder) if name != LIST}


def _listed(out: Path) -> set[str]:
    """The files that exports wrote into the folder, by its list; paths that lead elsewhere are ignored."""
    return set(_digests(out))


def _digests(out: Path) -> dict[str, str]:
    """The names of the list with their digests, which are empty where it has none."""
    if not is_export(out):
        return {}
    lines = read_regular(out / LIST).decode("utf-8", "replace").split("\n")  # no other line end
    split = (line.partition("\t") for line in lines)
    return {name: known for name, _, known in split if name and _is_below(name)}


def _is_below(name: str) -> bool:
    path = PurePosixPath(name)
    return not (path.is_absolute() or ".." in path.parts or "\\" in name or PureWindowsPath(name).drive)


def _replace_files(new: Path, out: Path, scratch: Path) -> None:
    """Move the files from `new` into the earlier export `out`, and remove its other files of ours.

    At every moment its list contains all our files in the folder.
    """
    before, digests = _listed(out), _digests_in(new)
    names = list(digests)
    for name in names:
        _check_free(out, name, before)
    _write_list(scratch, dict.fromkeys(sorted({*before, *names, _NOT_WHOLE} - {LIST}), ""))
    scratch.replace(out / LIST)
    for name in sorted(before - {*names, LIST}):
        _remove(out, name)
    for name in names:
        (out / name).parent.mkdir(parents=True, exist_ok=True)
        (new / name).replace(out / name)
    _write_list(scratch, digests)
    scratch.replace(out / LIST)


def _check_free(out: Path, name: str, ours: set[str]) -> None:
    """Raise InputError if a file of this name would replace something that is not ours."""
    for folder in _folders_above(out, name):
        if folder.is_symlink() or (folder.exists() and not folder.is_dir()):
            raise _in_the_way(folder)
    path = out / name
    is_ours = name in ours and path.is_file() and not path.is_symlink()
    if not is_ours and (path.exists() or path.is_symlink()):
        raise _in_the_way(path)


def _in_the_way(path: Path) -> InputError:
    problem = f"{path} is in the way, and no export wrote it"
    return InputError(problem, do("move it"), do("choose another folder", Setting.OUT))


def _remove(out: Path, name: str) -> None:
    """Remove a file of an earlier export, and its folders if empty; links and folders by its name stay."""
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
