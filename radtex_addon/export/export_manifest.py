# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The manifest of an exported folder, `<name>.export.json`: its files, and how the textures are laid out.

Its keys are a contract with other programs: docs/format.md, "Exported textures".
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..core.errors import FormatError
from ..formats.containers.texture import MOST_PIXELS
from ..formats.disk.atomic import write_text
from ..formats.file_names import is_plain_stem
from ..formats.json_reader import Facts, json_text, shown
from ..formats.sidecar_file import read_text
from ..forms import Form, form_in
from ..textures.entry import MOST_TEXELS, TextureEntry, file_of
from .mirror import Mirror

VERSION = 1
EXTENSION = "export.json"


@dataclass(frozen=True)
class Manifest:
    """The contents of a folder: the mesh, the flat lightmap, and the textures by layer.

    The keys of `textures` are the layers' names for the layered layout; else the kind, such as "radiance",
    and the names of additional layers. `bake` is the sidecar's JSON. The flat lightmap's light was
    multiplied by `flat_scale` before it was encoded. `culled`: only front faces are drawn, since those that
    are seen from behind have others for their backs. `mirror` is what a moving mirror ball needs. With
    `images` the mesh's file or the folder holds the images of materials that can be shown by these; if all
    can, `textures` lack what they replace.
    """

    tool: str
    name: str
    mesh: str
    flat: str
    bake: Mapping[str, Any]
    textures: Mapping[str, TextureEntry]
    flat_scale: float = 1.0
    culled: bool = False
    mirror: Mirror | None = None
    images: bool = False

    @property
    def form(self) -> Form:
        """How the bake is stored."""
        return form_in(Facts(dict(self.bake), self.name))

    @property
    def shader(self) -> dict[str, Any] | None:
        """What shaders are told of the bake; None if nothing."""
        return self.form.shader_facts(self.bake, self.textures, self.images)

    def facts(self) -> dict[str, Any]:
        """The JSON's keys and values, in order."""
        shader = self.shader
        return {
            "version": VERSION,
            "tool": self.tool,
            "name": self.name,
            "mesh": self.mesh,
            "flat": self.flat,
            "flat_scale": self.flat_scale,
            **({"culled": True} if self.culled else {}),
            **({"images": True} if self.images else {}),
            "bake": dict(self.bake),
            **({} if shader is None else {"shader": shader}),
            "textures": {layer: entry.facts() for layer, entry in self.textures.items()},
            **({} if self.mirror is None else {"mirror": self.mirror.facts()}),
        }

    def to_json(self) -> str:
        """The contract's JSON, in ASCII and with a newline at its end."""
        return json_text(self.facts())

    @classmethod
    def from_json(cls, text: str, source: str = "the manifest") -> Manifest:
        """Read the text of `to_json`; `source` names it in errors. Unknown keys are ignored.

        Raises FormatError if it is no JSON object, for another version, a missing or mistyped key, a file
        outside the folder, a sidecar that RadTex does not read, and if the textures are not the bake's.
        """
        facts = Facts.parse(text, source, "RadTex export")
        version = facts.whole_number("version", 1)
        if version != VERSION:
            raise FormatError(f"{source} is of version {version}, this RadTex reads {VERSION}: update RadTex")
        bake, textures = facts.inner("bake"), facts.inner("textures")
        bake.size("texels", MOST_TEXELS)
        bake.whole_number("bucket", 1, MOST_PIXELS)
        images = facts.truth("images") if "images" in facts.values else False
        layers = form_in(bake).textures_of(bake, textures.values)
        if "shader" in facts.values and not images:
            layers = bake.texts("layers")
        if set(textures.values) != set(layers):
            found, expected = (shown(", ".join(names), 200) or "none" for names in (textures.values, layers))
            raise FormatError(f"{source} has the textures {found}, expected {expected}")
        return cls(
            tool=facts.text("tool"),
            name=_stem_in(facts),
            mesh=file_of(facts, "mesh", "glb"),
            flat=file_of(facts, "flat", "png"),
            bake=bake.values,
            textures={layer: TextureEntry.from_facts(textures.inner(layer)) for layer in layers},
            flat_scale=facts.positive("flat_scale"),
            culled=facts.truth("culled") if "culled" in facts.values else False,
            mirror=Mirror.from_facts(facts.inner("mirror")) if "mirror" in facts.values else None,
            images=images,
        )


def _stem_in(facts: Facts) -> str:
    """The common name of the export's files."""
    name = facts.text("name")
    if not is_plain_stem(name):
        found = shown(json.dumps(name))
        raise FormatError(f'{facts.source}: "name" is {found}, expected what its files are called')
    return name


def write_manifest(path: Path, manifest: Manifest) -> None:
    """Write the manifest's file, whole or not at all. Raises BakeError where the system refuses."""
    write_text(path, manifest.to_json())


def read_manifest(path: Path) -> Manifest:
    """Read a manifest's file. Raises FormatError, with the path, if it is missing or not one of ours."""
    return Manifest.from_json(read_text(path), str(path))
