# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials' own images as files beside the mesh, for engines that import textures one by one.

An engine imports a file in one way: as colours, as data or as a normal map, and repeated or not. So an image
that materials use in two ways is written twice. The mesh's file holds none of them then, and names none:
Unity's glTFast would make an uncompressed copy of each, which nobody shows.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..core.quoting import in_comment
from ..formats.containers.glb import Glb
from ..formats.containers.png import encode_png
from ..forms.hlsl_lookup import IMAGE_TEXTURES

REPEAT, EXTEND, MIRROR = 10497, 33071, 33648  # as glTF counts them
BASE, METAL, BUMP = IMAGE_TEXTURES
_HOLDS = {BASE: "base colour, sRGB", METAL: "roughness in green, metal in blue", BUMP: "normal map, y up"}
_NEUTRAL = {METAL: ("white", (1.0, 1.0, 1.0)), BUMP: ("flat", (0.5, 0.5, 1.0))}  # for materials without
_ENDINGS = {"image/png": "png", "image/jpeg": "jpg"}
_ENDING = re.compile(
    r"(\.(png|jpe?g|tga|tiff?|exr|webp|bmp))?(\.\d{3,})?$", re.IGNORECASE
)  # .001 is Blender's
_ODD = re.compile(r"\W+", re.ASCII)
_MOST_CHARACTERS = 80


class ImageFile(NamedTuple):
    """An image beside the mesh.

    `file` is called after the bake and `name`, which has ASCII letters, digits and _ alone. `texture` is the
    shader's, one of IMAGE_TEXTURES, and says what the image holds. `wrap` is what lies beyond its edges.
    """

    file: str
    name: str
    texture: str
    wrap: int


ImageFiles = Mapping[int, tuple[ImageFile, ...]]  # by material, one for each of IMAGE_TEXTURES
NO_IMAGES: ImageFiles = {}


def move_images(glb: Glb, numbers: Mapping[str, int], of_images: Collection[int], bake: Path) -> ImageFiles:
    """Move the images of materials that are shown by these out of a mesh into files.

    `numbers` are the materials' by their names, and `of_images` those that are shown by images. Files are
    called after `bake`, a path without an ending. The mesh's buffer is to be compacted. Raises OSError.
    """
    files = _Files(glb, bake)
    materials = glb.document["materials"]
    found = {numbers[each["name"]]: each for each in materials if numbers[each["name"]] in of_images}
    made = {number: files.of_material(each) for number, each in found.items()}
    for material in found.values():
        material.pop("normalTexture", None)
        for texture in ("baseColorTexture", "metallicRoughnessTexture"):
            material["pbrMetallicRoughness"].pop(texture, None)
    if found:
        _drop_unused(glb.document)
    return made


def lines_of(images: ImageFiles) -> list[str]:
    """A line on each file, for a README."""
    return [in_comment(f"{each.file}: {_HOLDS[each.texture]}") for each in every(images)]


def every(images: ImageFiles) -> list[ImageFile]:
    """All files, each once."""
    return list(dict.fromkeys(each for row in images.values() for each in row))


def _drop_unused(document: dict[str, Any]) -> None:
    """Remove textures that no material has, and what only these needed."""
    shadings = [each["pbrMetallicRoughness"] for each in document["materials"]]
    flat = [each["baseColorTexture"] for each in shadings if "baseColorTexture" in each]
    _keep(document, "textures", flat, "index")
    _keep(document, "images", document["textures"], "source")
    _keep(document, "samplers", document["textures"], "sampler")
    for name in ("textures", "images", "samplers"):
        if not document[name]:
            del document[name]
    used = {extension for each in flat for extension in each.get("extensions", {})}
    used |= {extension for each in document["materials"] for extension in each.get("extensions", {})}
    document["extensionsUsed"] = [each for each in document["extensionsUsed"] if each in used]
    if not used:
        del document["extensionsUsed"]


def _keep(document: dict[str, Any], name: str, users: Sequence[dict[str, Any]], key: str) -> None:
    """Keep those of a document's list that `users` name by their index under a key."""
    kept = sorted({each[key] for each in users})
    document[name] = [document[name][index] for index in kept]
    for each in users:
        each[key] = kept.index(each[key])


class _Use(NamedTuple):
    """An image of the document, or None for a neutral one, and how it is imported."""

    image: int | None
    texture: str
    wrap: int


@dataclass
class _Files:
    """Writes each image once for each way in which it is imported."""

    glb: Glb
    bake: Path
    made: dict[_Use, ImageFile] = field(default_factory=dict)

    def of_material(self, material: Mapping[str, Any]) -> tuple[ImageFile, ...]:
        """The files of a material of the document."""
        shading = material["pbrMetallicRoughness"]
        textures = {
            BASE: shading["baseColorTexture"],
            METAL: shading.get("metallicRoughnessTexture"),
            BUMP: material.get("normalTexture"),
        }
        return tuple(self._of(self._use(name, textures[name])) for name in IMAGE_TEXTURES)

    def _use(self, name: str, texture: Mapping[str, Any] | None) -> _Use:
        if texture is None:
            return _Use(None, name, REPEAT)
        document = self.glb.document
        facts = document["textures"][texture["index"]]
        return _Use(facts["source"], name, document["samplers"][facts["sampler"]]["wrapS"])

    def _of(self, use: _Use) -> ImageFile:
        if use not in self.made:
            called, ending, data = self._content(use)
            name = self._free_name(called)
            file = f"{self.bake.name}.image.{name}.{ending}"
            self.bake.with_name(file).write_bytes(data)
            self.made[use] = ImageFile(file, name, use.texture, use.wrap)
        return self.made[use]

    def _content(self, use: _Use) -> tuple[str, str, bytes]:
        """An image's name, its file's ending, and its bytes."""
        if use.image is None:
            name, colour = _NEUTRAL[use.texture]
            return name, "png", encode_png(np.full((4, 4, 3), colour, dtype=np.float32))
        image = self.glb.document["images"][use.image]
        view = self.glb.document["bufferViews"][image["bufferView"]]
        first = view.get("byteOffset", 0)
        data = bytes(self.glb.buffer[first : first + view["byteLength"]])
        return image["name"], _ENDINGS[image["mimeType"]], data

    def _free_name(self, called: str) -> str:
        """An image's name as files and assets may have it, and no other one has; letter case aside."""
        plain = _ODD.sub("_", _ENDING.sub("", called)).strip("_")[:_MOST_CHARACTERS] or "image"
        taken = {each.name.lower() for each in self.made.values()}
        name, count = plain, 1
        while name.lower() in taken:
            count += 1
            name = f"{plain}_{count}"
        return name
