# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The folders in which a .blend's bakes lie by default: each file has its own."""

from __future__ import annotations

import re
from pathlib import Path

import bpy

from ..formats.sidecar import safe_name

FOLDER = "radtex"  # beside the .blend; also where bakes of a scene that is in no file go
UNSAVED = Path()  # the path of a .blend that was never saved


def open_blend() -> Path:
    """The path of the open .blend; `UNSAVED` if it was never saved."""
    return Path(bpy.data.filepath) if bpy.data.filepath else UNSAVED


def blend_folder_name(blend: Path) -> str:
    """The name of a .blend's own folder of bakes: its own name, without .blend."""
    return safe_name(re.sub(r"\.blend$", "", blend.name, flags=re.IGNORECASE))


def own_folder(blend: Path) -> Path:
    """Where the bakes of a .blend go unless another folder is chosen: `radtex/NAME` beside it."""
    if not blend.name:
        return Path(FOLDER)
    return blend.parent / FOLDER / blend_folder_name(blend)


def former_folder(blend: Path) -> Path:
    """Where the bakes of all files of the folder lay in versions before each had its own."""
    return blend.parent / FOLDER
