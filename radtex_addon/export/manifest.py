# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The manifest of an exported folder, `<name>.export.json`: which file is which, and how it is laid out.

Its keys are a contract with other programs: docs/format.md, "Exported textures".
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any

from ..core.errors import FormatError
from ..formats.atomic import write_text
from ..formats.json_reader import Facts, json_text, shown
from ..formats.packing import layer_names
from ..formats.shared_sidecar import LAYOUT as SHARED
from ..formats.shared_sidecar import SharedSidecar
from ..formats.sidecar import LAYOUT as BUCKETS
from ..formats.sidecar import Sidecar, read_text
from ..formats.texture import MOST_LAYERS, MOST_PIXELS, PixelFormat, most_levels
from ..formats.transfer_files import LAYOUT as SPHERE
from ..formats.transfer_files import TransferSidecar

VERSION = 1
EXTENSION = "export.json"


class Container(StrEnum):
    """What kind of file a texture is."""

    EXR = "exr"
    KTX2 = "ktx2"
    DDS = "dds"


class Arranged(StrEnum):
    """What a texture's pixels are: a bucket matrix, its slices, an image of the shared layout, or bits."""

    MATRIX = "matrix"
    SLICES = "slices"
    IMAGE = "image"
    WORDS = "words"


@dataclass(frozen=True)
class TextureEntry:
    """One texture: its `file` in the folder, and how it is stored.

    `size` is the width and height in pixels of a layer's level 0. `texels` are the bake's, `stored` those in
    the file with what fills it up; of an image both count pixels. A matrix in several layers is cut into
    `pages`, columns and rows, of `page_texels` each; else there is one page of all that is stored.
    """

    file: str
    container: Container
    format: PixelFormat
    zstd: bool
    arrangement: Arranged
    size: tuple[int, int]
    layers: int
    texels: tuple[int, int]
    stored: tuple[int, int]
    levels: int
    pages: tuple[int, int]
    page_texels: tuple[int, int]

    def facts(self) -> dict[str, Any]:
        """What the JSON says, in its order."""
        return {
            "file": self.file,
            "container": str(self.container),
            "format": str(self.format),
            "zstd": self.zstd,
            "arrangement": str(self.arrangement),
            "size": list(self.size),
            "layers": self.layers,
            "texels": list(self.texels),
            "stored": list(self.stored),
            "levels": self.levels,
            "pages": list(self.pages),
            "page_texels": list(self.page_texels),
        }

    @classmethod
    def from_facts(cls, facts: Facts) -> TextureEntry:
        """Read what `facts` wrote. Raises FormatError for a missing or mistyped key or impossible sizes."""
        size = facts.size("size", MOST_PIXELS)
        entry = cls(
            file=file_of(facts, "file"),
            container=Container(facts.choice("container", tuple(Container))),
            format=PixelFormat(facts.choice("format", tuple(PixelFormat))),
            zstd=facts.truth("zstd"),
            arrangement=Arranged(facts.choice("arrangement", tuple(Arranged))),
            size=size,
            layers=facts.whole_number("layers", 1, MOST_LAYERS),
            texels=facts.size("texels"),
            stored=facts.size("stored"),
            levels=facts.whole_number("levels", 1, most_levels(*size)),
            pages=facts.size("pages", MOST_LAYERS),
            page_texels=facts.size("page_texels", MOST_PIXELS),
        )
        paged = tuple(count * side for count, side in zip(entry.pages, entry.page_texels, strict=True))
        if paged != entry.stored or any(map(int.__gt__, entry.texels, entry.stored)):
            raise FormatError(f"{facts.source} has pages that do not hold its texels: export it again")
        if (
            entry.arrangement not in (Arranged.SLICES, Arranged.WORDS)
            and entry.layers != entry.pages[0] * entry.pages[1]
        ):
            raise FormatError(f"{facts.source} has other layers than pages: export it again")
        return entry


@dataclass(frozen=True)
class Manifest:
    """What a folder holds: the mesh, the flat lightmap, and the textures by layer.

    `textures` has the layers' names as keys for the shared layout, else the kind, "radiance" for one, and the
    layers that lie beside the whole. `bake` is the sidecar's JSON. The flat lightmap's light was multiplied
    by `flat_scale` before it was encoded.
    """

    tool: str
    name: str
    mesh: str
    flat: str
    bake: Mapping[str, Any]
    textures: Mapping[str, TextureEntry]
    flat_scale: float = 1.0

    def facts(self) -> dict[str, Any]:
        """What the JSON says, in its order."""
        return {
            "version": VERSION,
            "tool": self.tool,
            "name": self.name,
            "mesh": self.mesh,
            "flat": self.flat,
            "flat_scale": self.flat_scale,
            "bake": dict(self.bake),
            "textures": {layer: entry.facts() for layer, entry in self.textures.items()},
        }

    def to_json(self) -> str:
        """The contract's JSON, in ASCII and with a newline at its end."""
        return json_text(self.facts())

    @classmethod
    def from_json(cls, text: str, source: str = "the manifest") -> Manifest:
        """Read `to_json`'s text; `source` names it in errors. Keys that it does not know are ignored.

        Raises FormatError for what is no JSON object, another version, a missing or mistyped key, a file
        outside the folder, a sidecar that RadTex does not read, and for textures that are not the bake's.
        """
        facts = Facts.parse(text, source, "RadTex export")
        version = facts.whole_number("version", 1)
        if version != VERSION:
            raise FormatError(f"{source} is of version {version}, this RadTex reads {VERSION}: update RadTex")
        bake, textures = facts.inner("bake"), facts.inner("textures")
        layers = layers_of(bake)
        if bake.text("layout") == BUCKETS:
            layers += tuple(layer for layer in bake.texts("layers") if layer in textures.values)
        if set(textures.values) != set(layers):
            found, expected = (shown(", ".join(names), 200) or "none" for names in (textures.values, layers))
            raise FormatError(f"{source} has the textures {found}, expected {expected}")
        return cls(
            tool=facts.text("tool"),
            name=facts.text("name"),
            mesh=file_of(facts, "mesh"),
            flat=file_of(facts, "flat"),
            bake=bake.values,
            textures={layer: TextureEntry.from_facts(textures.inner(layer)) for layer in layers},
            flat_scale=facts.positive("flat_scale"),
        )


def layers_of(bake: Facts) -> tuple[str, ...]:
    """The textures of a bake by what its sidecar says. Raises FormatError as reading the sidecar does."""
    if bake.text("layout") == SPHERE:
        return (TransferSidecar.from_facts(bake).bake.kind,)
    if bake.text("layout") != SHARED:
        return (Sidecar.from_facts(bake).kind,)
    shared = SharedSidecar.from_json(json.dumps(bake.values), bake.source)
    return layer_names(shared.lobes, shared.condensed is not None)


def file_of(facts: Facts, key: str) -> str:
    """The name of a file in the manifest's folder. Raises FormatError for one that lies elsewhere."""
    name = facts.text(key)
    if not name or name.startswith(".") or any(mark in name for mark in "/\\:\0"):
        raise FormatError(
            f'{facts.source}: "{key}" is {shown(json.dumps(name))}, expected a file of the same folder'
        )
    return name


def write_manifest(path: Path, manifest: Manifest) -> None:
    """Write the manifest's file, whole or not at all. Raises BakeError where the system refuses."""
    write_text(path, manifest.to_json())


def read_manifest(path: Path) -> Manifest:
    """Read a manifest's file. Raises FormatError, with the path, if it is missing or not one of ours."""
    return Manifest.from_json(read_text(path), str(path))
