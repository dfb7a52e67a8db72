# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What every target starts from: a folder with the mesh, the textures and their manifest."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from ..textures.export_spec import ExportSpec
from .export_manifest import Manifest

SHADERS = Path(__file__).parents[2] / "shaders"  # includes that games may ship


@dataclass(frozen=True, eq=False)
class Pack:
    """A folder that holds `<name>.glb`, the flat lightmap, the textures and `<name>.export.json`.

    `name` is the stem of the files' names, valid on every filesystem; `manifest` lists the files.
    """

    name: str
    manifest: Manifest
    folder: Path
    spec: ExportSpec

    @property
    def manifests(self) -> tuple[Manifest, ...]:
        """The manifest, as a scene of several bakes has them."""
        return (self.manifest,)
