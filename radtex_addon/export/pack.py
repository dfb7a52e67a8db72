# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What every target starts from: a folder with the mesh, the textures and their manifest."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from ..textures.spec import ExportSpec
from .manifest import Manifest

SHADERS = Path(__file__).parents[2] / "shaders"  # what games may ship


@dataclass(frozen=True, eq=False)
class Pack:
    """A folder that holds `<name>.glb`, the flat lightmap, the textures and `<name>.export.json`.

    `name` is the file name's stem, safe on every filesystem; `manifest` says which file is which.
    """

    name: str
    manifest: Manifest
    folder: Path
    spec: ExportSpec
