# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Output files that wait until all of a bake's files are written: all get their final names, or none.

They are written into a folder inside the unfinished bake's folder. Once all are complete the key records it,
and they are moved out by one rename each. If the bake is killed meanwhile, resuming it moves the others.
"""

from __future__ import annotations

import shutil
from collections.abc import Collection
from pathlib import Path

from ..core.errors import BakeError
from ..formats.disk.atomic import flush_folder, refusal

_FOLDER = "written"


def waiting_place(unfinished: Path, path: Path) -> Path:
    """Where to write the file that will become `path`; makes the folder if need be.

    Raises BakeError where the system refuses.
    """
    folder = unfinished / _FOLDER
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise BakeError(refusal(path, error)) from error
    return folder / path.name


def with_final_paths(words: str, unfinished: Path) -> str:
    """Replace the waiting files' paths in a message by their final ones."""
    return words.replace(str(unfinished / _FOLDER), str(unfinished.parent))


def move_out(unfinished: Path, names: Collection[str]) -> None:
    """Move the waiting files with these `names` to their final places, the sidecar last; delete the others.

    The new names are on disk before this returns. Raises BakeError where the system refuses.
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
    flush_folder(unfinished.parent)
    drop_waiting(unfinished)


def drop_waiting(unfinished: Path) -> None:
    """Delete the waiting files, and temporary files of killed processes beside them. Raises OSError."""
    folder = unfinished / _FOLDER
    if folder.is_dir() and not folder.is_symlink():
        shutil.rmtree(folder)
