# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Preflight checks of paths: names that the system, Blender or OpenEXR cannot handle."""

from __future__ import annotations

import os
from pathlib import Path

from ...core.errors import InputError

_ROOM = 256  # bytes reserved for our file names in a folder, with the slash and temporary prefixes
_TEMPORARY_ROOM = 64  # bytes reserved for the names of temporary folders and images in them
_NAME, _PATH = 255, 4096  # default limits of a name and of a path, in bytes
_BLENDER = 1023  # Blender's limit of a path, in bytes


def nearest_folder(folder: Path) -> Path:
    """The folder itself if it exists, or its nearest existing parent.

    Raises InputError if that is not a folder, or if names or the path are too long or not Unicode.
    """
    place = folder.absolute()
    check_unicode(folder)
    while not os.path.lexists(place) and place != place.parent:
        place = place.parent
    if not place.is_dir():
        what = "a link that leads nowhere" if place.is_symlink() and not place.exists() else "a file"
        raise InputError(f"{folder} cannot be written: {place} is {what}; choose another folder")
    missing = folder.absolute().parts[len(place.parts) :]
    longest = max((len(os.fsencode(name)) for name in missing), default=0)
    for what, length, most in (
        ("a name in it", longest, _limit(place, "PC_NAME_MAX", _NAME)),
        ("its path with a file's name", _length(folder) + _ROOM, _limit(place, "PC_PATH_MAX", _PATH)),
    ):
        if length > most:
            raise InputError(
                f"{folder} cannot be written: {what} has {length} bytes, {most} is the most; "
                "choose another folder"
            )
    return place


def check_unicode(path: Path) -> None:
    """Raise InputError for a path that is not Unicode: Linux allows it, Blender and OpenEXR do not."""
    try:
        str(path).encode("utf-8")
    except UnicodeEncodeError as error:
        raise InputError(f"{path}: this name is not Unicode (UTF-8): rename it, or choose another") from error
    if "\0" in str(path):
        raise InputError(f"{path}: no name may hold a zero byte: choose another")


def check_for_blender(path: Path, room: int = 0) -> None:
    """Raise InputError if Blender would truncate the path, made longer by `room` bytes."""
    check_unicode(path)
    length = _length(path) + room
    if length > _BLENDER:
        raise InputError(
            f"{path}: this path has {length} bytes, and Blender handles {_BLENDER}: choose another"
        )


def check_loadable(path: Path) -> None:
    """Raise InputError for a file that Blender could not find by its name."""
    check_for_blender(path)
    if os.sep != "\\" and "\\" in str(path.absolute()):
        raise InputError(f"{path}: Blender takes a backslash for a slash: rename it, or its folder")


def check_saveable(path: Path) -> None:
    """Raise InputError for a .blend's path that Blender could not save to, or find images relative to."""
    check_for_blender(path, _ROOM)
    if os.sep != "\\" and "\\" in str(path.absolute()):
        raise InputError(
            f"{path}: Blender takes a backslash for a slash: save no preview there, or rename it"
        )


def one_root(path: str) -> str:
    """Reduce leading slashes to one: for Blender "//" means the folder of the open file.

    On Windows "//" begins a server's name, and stays.
    """
    return f"/{path.lstrip('/')}" if os.sep == "/" and path.startswith("//") else path


def render_path(path: Path) -> str:
    """A path as Blender's render output: braces are doubled, as single ones mean templates there."""
    return str(path.absolute()).replace("{", "{{").replace("}", "}}")


def check_rendered_into(folder: Path) -> None:
    """Raise InputError for a folder whose name Blender would change when it renders into it."""
    check_for_blender(folder, _TEMPORARY_ROOM)
    if os.sep != "\\" and "\\" in str(folder.absolute()):
        raise InputError(f"{folder}: Blender takes a backslash for a slash: choose another")


def _length(path: Path) -> int:
    return len(os.fsencode(path.absolute()))


def _limit(place: Path, name: str, known: int) -> int:
    try:
        return os.pathconf(place, name)
    except (OSError, ValueError, AttributeError):  # AttributeError: Windows has no such function
        return known
