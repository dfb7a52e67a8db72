# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Folders whose names no file can be put under: found out before anything is made."""

from __future__ import annotations

import os
from pathlib import Path

from ..core.errors import InputError

_ROOM = 256  # bytes that names of our files may take in a folder, a slash and their marks among them
_TEMPORARY_ROOM = 64  # bytes of the names of temporary folders and the pictures in them
_NAME, _PATH = 255, 4096  # bytes of a name and of a path where the system does not say
_BLENDER = 1023  # bytes of a path that Blender handles


def nearest_folder(folder: Path) -> Path:
    """The folder, or of those above it the nearest that is there.

    Raises InputError where it is no folder, and where the names of those below cannot be given.
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
    """Raises InputError for a path that is no Unicode: Linux allows it, Blender and OpenEXR do not."""
    try:
        str(path).encode("utf-8")
    except UnicodeEncodeError as error:
        raise InputError(f"{path}: this name is not Unicode (UTF-8): rename it, or choose another") from error
    if "\0" in str(path):
        raise InputError(f"{path}: no name may hold a zero byte: choose another")


def check_for_blender(path: Path, room: int = 0) -> None:
    """Raises InputError for a file whose path, with `room` bytes more, Blender would cut off."""
    check_unicode(path)
    length = _length(path) + room
    if length > _BLENDER:
        raise InputError(
            f"{path}: this path has {length} bytes, and Blender handles {_BLENDER}: choose another"
        )


def check_saveable(path: Path) -> None:
    """Raises InputError for a .blend that Blender would not save, or not find its images from."""
    check_for_blender(path, _ROOM)
    if os.sep != "\\" and "\\" in str(path.absolute()):
        raise InputError(
            f"{path}: Blender takes a backslash for a slash: save no preview there, or rename it"
        )


def one_root(path: str) -> str:
    """A path without a second slash at its beginning: to Blender that would mean the open file's folder.

    On Windows it begins a server's name, and stays.
    """
    return f"/{path.lstrip('/')}" if os.sep == "/" and path.startswith("//") else path


def render_path(path: Path) -> str:
    """A file as Blender's path of a render's output, in which it would take braces for a template's."""
    return str(path.absolute()).replace("{", "{{").replace("}", "}}")


def check_rendered_into(folder: Path) -> None:
    """Raises InputError for a folder into which Blender would render under another name."""
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
