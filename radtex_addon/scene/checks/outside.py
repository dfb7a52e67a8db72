# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Refuse a scene whose file paths lead to pipes or devices: Blender would wait for a pipe for ever."""

from __future__ import annotations

from pathlib import Path
from typing import Any, cast

import bpy

from ...core.errors import InputError
from ...formats.disk.regular import FOLDER, other_kind


def check_outside_files() -> None:
    """Raise InputError, which names the data-block, if its file is a pipe, a device or a socket."""
    owner: Any
    for owner, paths in cast(Any, bpy.data).file_path_map().items():
        for written in sorted(paths):
            path = bpy.path.abspath(written, library=owner.library)
            kind = other_kind(Path(path))
            if kind not in (None, FOLDER):  # caches are folders
                raise InputError(
                    f"{owner.bl_rna.name.lower()} '{owner.name}' names {path}, which is {kind} and no file: "
                    "put a file there, or take it out of the scene"
                )
