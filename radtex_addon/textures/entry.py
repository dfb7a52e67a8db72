# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A manifest's entry for one texture: its file, its format and how its pixels are arranged."""

from __future__ import annotations

import json
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from ..core.errors import FormatError
from ..formats.containers.texture import MOST_LAYERS, MOST_PIXELS, PixelFormat, most_levels
from ..formats.file_names import is_plain_file
from ..formats.json_reader import Facts, shown

MOST_TEXELS = 2**24  # along a side of an atlas: whole numbers that every reader holds exactly


class Container(StrEnum):
    """The kind of file that a texture is stored in."""

    EXR = "exr"
    KTX2 = "ktx2"
    DDS = "dds"


class Arranged(StrEnum):
    """What a texture contains: a bucket matrix, its slices, a layered bake's image, bits, or triangles."""

    MATRIX = "matrix"
    SLICES = "slices"
    IMAGE = "image"
    WORDS = "words"
    TREE = "tree"


@dataclass(frozen=True)
class TextureEntry:
    """One texture: its `file` in the folder, and how it is stored.

    `size` is the width and height in pixels of a layer's mip level 0. `texels` are the bake's width and
    height, `stored` the file's, which include padding; for an image both are in pixels. A matrix in several
    layers is cut into `pages`, columns and rows, of `page_texels` each; otherwise there is one page. A value
    is a texel times `scale` plus `offset`; the layout says of which channels.
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
    scale: float = 1.0
    offset: float = 0.0

    def facts(self) -> dict[str, Any]:
        """The JSON's keys and values, in order."""
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
            **({"range": [self.scale, self.offset]} if (self.scale, self.offset) != (1, 0) else {}),
        }

    @classmethod
    def from_facts(cls, facts: Facts) -> TextureEntry:
        """Inverse of `facts`. Raises FormatError for a missing or mistyped key or impossible sizes."""
        size = facts.size("size", MOST_PIXELS)
        container = Container(facts.choice("container", tuple(Container)))
        scale, offset = facts.numbers("range", 2) if "range" in facts.values else (1.0, 0.0)
        entry = cls(
            file=file_of(facts, "file", container),
            container=container,
            format=PixelFormat(facts.choice("format", tuple(PixelFormat))),
            zstd=facts.truth("zstd"),
            arrangement=Arranged(facts.choice("arrangement", tuple(Arranged))),
            size=size,
            layers=facts.whole_number("layers", 1, MOST_LAYERS),
            texels=facts.size("texels", MOST_TEXELS),
            stored=facts.size("stored", MOST_TEXELS),
            levels=facts.whole_number("levels", 1, most_levels(*size)),
            pages=facts.size("pages", MOST_LAYERS),
            page_texels=facts.size("page_texels", MOST_PIXELS),
            scale=scale,
            offset=offset,
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


def file_of(facts: Facts, key: str, ending: str) -> str:
    """The name of a file in the manifest's folder. Raises FormatError for any other name."""
    name = facts.text(key)
    if not is_plain_file(name, (ending,)):
        raise FormatError(
            f'{facts.source}: "{key}" is {shown(json.dumps(name))}, expected a file of the same folder '
            f"that ends in .{ending}"
        )
    return name
