# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What every target starts from: a folder with the mesh, the textures and their manifest; and templates."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from ..core.errors import BakeError
from ..textures.export_spec import ExportSpec
from .export_manifest import Manifest

SHADERS = Path(__file__).parents[2] / "shaders"  # includes that games may ship
_LEFT = re.compile(r"@[A-Z_]+@")  # words of templates


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


def filled(template: Path, words: Mapping[str, str]) -> str:
    """The text of a template with each @WORD@ replaced by its value in `words`.

    Raises BakeError if a word is left.
    """
    text = template.read_text(encoding="utf-8")
    if unknown := {word[1:-1] for word in _LEFT.findall(text)} - set(words):
        raise BakeError(f"{template} asks for {', '.join(sorted(unknown))}: install RadTex again")
    return _LEFT.sub(lambda word: words[word[0][1:-1]], text)


def write_text_file(path: Path, text: str) -> None:
    """Write a file of the folder that is being made, in UTF-8, its lines ended as on Linux."""
    path.write_text(text, encoding="utf-8", newline="\n")
