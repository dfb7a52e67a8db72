# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The farm's folder, and what lies in it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

_SUFFIX = ".radtex-farm"


@dataclass(frozen=True)
class FarmFiles:
    """What lies in a farm's `folder`."""

    folder: Path

    @classmethod
    def of(cls, sidecar: Path) -> FarmFiles:
        """Of the farm beside the sidecar that its bake will have: `<name>.<kind>.radtex-farm`."""
        return cls(sidecar.with_suffix(_SUFFIX))

    @property
    def blend(self) -> Path:
        """Renders one sheet a frame."""
        return self.folder / "farm.blend"

    @property
    def manifest(self) -> Path:
        return self.folder / "farm.json"

    @property
    def plan(self) -> Path:
        """Which texels the sheets hold, and which cells of them nobody sees."""
        return self.folder / "plan.npz"

    @property
    def preview(self) -> Path:
        """The scene with the baked copies in it, where a preview is wanted."""
        return self.folder / "preview.blend"

    @property
    def parts(self) -> Path:
        """Which part each of the copies' triangles belongs to, where they are split."""
        return self.folder / "parts.npz"

    @property
    def frames(self) -> Path:
        return self.folder / "frames"

    @property
    def runner(self) -> Path:
        """Renders frames where there is the bpy module and no Blender."""
        return self.folder / "render_frames.py"

    def frame(self, number: int) -> Path:
        """Where Blender puts a frame."""
        return self.frames / f"{number:04d}.exr"
