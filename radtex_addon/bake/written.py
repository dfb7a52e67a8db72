# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The files of a bake between their writing and their places: all of them get there, or none.

They are written into a folder inside the unfinished bake's. Once all are whole its key says so, and they are
moved out, one rename each. Killed amid these, the bake is gone on with by moving the rest.
"""

from __future__ import annotations

import shutil
from collections.abc import Collection
from pathlib import Path

from ..core.errors import BakeError
from ..formats.atomic import refusal, settle_names

_FOLDER = "written"


def waiting_place(unfinished: Path, path: Path) -> Path:
    """Where the file is written that is to become `path`, in a folder that is made if need be.

    Raises BakeError where the system refuses.
    """
    folder = unfinished / _FOLDER
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise BakeError(refusal(path, error)) from error
    return folder / path.name


def named_by_places(words: str, unfinished: Path) -> str:
    """What was said of files that wait, said of the places that they are to have."""
    return words.replace(str(unfinished / _FOLDER), str(unfinished.parent))


def move_out(unfinished: Path, names: Collection[str]) -> None:
    """Give those of the waiting files that have one of these `names` their places, the sidecar last.

    The disk has the new names before this returns. Raises BakeError where the system refuses.
    """
    folder = unfinished / _FOLDER
    if folder.is_symlink() or not folder.is_dir():
        return
    sidecar = unfinished.with_suffix(".json").name
    waiting = sorted(folder.iterdir(), key=lambda path: (path.name == sidecar, path.name))
    for path in waiting:
        place = unfinished.with_name(path.name)
        if path.name in names:
            try:
                path.replace(place)
            except OSError as error:
                raise BakeError(refusal(place, error)) from error
    settle_names(unfinished.parent)
    drop_waiting(unfinished)


def drop_waiting(unfinished: Path) -> None:
    """Remove what waits, and what a killed process was writing there. Raises OSError."""
    folder = unfinished / _FOLDER
    if folder.is_dir() and not folder.is_symlink():
        shutil.rmtree(folder)
