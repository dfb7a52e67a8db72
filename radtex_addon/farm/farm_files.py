# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The files in a farm's folder."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

SUFFIX = ".radtex-farm"
RUNNER = "render_frames.py"  # renders frames with the bpy module instead of Blender
OUTPUT = "//frames/####"  # where the farm.blend writes its pictures


def tasks_file(folder: Path) -> Path:
    """The file that lists the tasks of the farm in a folder."""
    return folder / "tasks.json"


def is_farm(folder: Path) -> bool:
    """Whether a folder holds a farm, of frames or of tasks."""
    return FarmFiles(folder).manifest.is_file() or tasks_file(folder).is_file()


@dataclass(frozen=True)
class FarmFiles:
    """Paths of the files in a farm's `folder`."""

    folder: Path

    @classmethod
    def of(cls, sidecar: Path) -> FarmFiles:
        """The farm beside the sidecar that its bake will have: `<name>.<kind>.radtex-farm`."""
        return cls(sidecar.with_suffix(SUFFIX))

    @property
    def blend(self) -> Path:
        """The .blend that renders a sheet per frame."""
        return self.folder / "farm.blend"

    @property
    def manifest(self) -> Path:
        return self.folder / "farm.json"

    @property
    def plan(self) -> Path:
        """The texels of the sheets, and their hidden cells."""
        return self.folder / "plan.npz"

    @property
    def preview(self) -> Path:
        """The scene with the baked copies, if a preview is wanted."""
        return self.folder / "preview.blend"

    @property
    def parts(self) -> Path:
        """The part of each of the copies' triangles, if the object is split."""
        return self.folder / "parts.npz"

    @property
    def frames(self) -> Path:
        return self.folder / "frames"

    @property
    def runner(self) -> Path:
        """A script that renders frames with the bpy module instead of Blender."""
        return self.folder / RUNNER

    def frame(self, number: int) -> Path:
        """The path to which Blender writes a frame."""
        return self.frames / f"{number:04d}.exr"
