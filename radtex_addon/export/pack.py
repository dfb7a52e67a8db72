# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What every target starts from: a folder with the mesh, the textures and their manifest; and templates.

The keys of a scene's manifest are a contract with other programs: docs/format.md, "A whole scene".
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..core.errors import BakeError
from ..formats.disk.atomic import write_text
from ..formats.json_reader import json_text
from ..textures.export_spec import ExportSpec
from .export_manifest import EXTENSION, VERSION, Manifest

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


@dataclass(frozen=True)
class SceneEntry:
    """A `node` of the scene's glTF, the manifest of its bake, and its levels of detail, the finest first."""

    node: str
    manifest: Manifest
    levels: tuple[SceneEntry, ...] = ()

    def facts(self) -> dict[str, Any]:
        """The JSON's keys and values: the manifest's, with the node in the place of the mesh's file."""
        facts = {
            "node" if key == "mesh" else key: self.node if key == "mesh" else value
            for key, value in self.manifest.facts().items()
        }
        return facts | ({"lods": [level.facts() for level in self.levels]} if self.levels else {})


@dataclass(frozen=True, eq=False)
class ScenePack:
    """A folder that holds a scene: `<name>.glb`, `<name>.export.json`, and the files of each bake.

    `name` is the stem of the scene's files, valid on every filesystem.
    """

    name: str
    entries: Sequence[SceneEntry]
    folder: Path
    spec: ExportSpec

    @property
    def mesh(self) -> str:
        """The glTF's file name."""
        return f"{self.name}.glb"

    @property
    def manifests(self) -> tuple[Manifest, ...]:
        """The manifest of each bake, once."""
        every = [each.manifest for entry in self.entries for each in (entry, *entry.levels)]
        return tuple({manifest.name: manifest for manifest in every}.values())

    def facts(self) -> dict[str, Any]:
        """The manifest's keys and values, in order."""
        return {
            "version": VERSION,
            "tool": self.manifests[0].tool,
            "name": self.name,
            "mesh": self.mesh,
            "scene": [entry.facts() for entry in self.entries],
        }

    def write_manifest(self) -> None:
        """Write the manifest's file. Raises BakeError where the system refuses."""
        write_text(self.folder / f"{self.name}.{EXTENSION}", json_text(self.facts()))


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
