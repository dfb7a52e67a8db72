# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames as Blender's command line names them, and the commands that render them."""

from __future__ import annotations

from collections.abc import Iterable

from ..core.quoting import quoted
from .farm_files import FarmFiles


def frame_list(frames: Iterable[int]) -> str:
    """Frame numbers as `blender -f` takes them, such as 3,7..9."""
    runs: list[list[int]] = []
    for frame in sorted(set(frames)):
        if runs and frame == runs[-1][1] + 1:
            runs[-1][1] = frame
        else:
            runs.append([frame, frame])
    return ",".join(f"{first}" if first == last else f"{first}..{last}" for first, last in runs)


def commands(files: FarmFiles, frames: Iterable[int]) -> tuple[str, str]:
    """The commands that render the frames: with Blender, and with the bpy module."""
    listed, folder = frame_list(frames), files.folder.absolute()
    return (
        quoted(["blender", "-b", str(folder / files.blend.name), "-f", listed]),
        quoted(["python", str(folder / files.runner.name), "-f", listed]),
    )
