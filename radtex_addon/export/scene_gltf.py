# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A glTF of many nodes, made of the baked copies one after the other."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ..core.errors import InputError
from ..formats.containers.glb import Glb
from .export_manifest import Manifest
from .gltf import BakedMesh, add_flat, add_materials

LEVELS = "MSFT_lod"
_MOST_BYTES = 2**32 - 2**26  # a .glb counts its bytes by 32 bits; the rest is for its JSON
_PLACE_OF_VIEW = ("buffer", "byteOffset", "byteLength")
_LISTS = ("nodes", "meshes", "materials", "accessors", "bufferViews", "images", "textures")


class SceneGltf:
    """The glTF of a scene that is called `name`. Nodes are on one level, each with its place in the world."""

    def __init__(self, name: str, tool: str) -> None:
        lists: dict[str, list[Any]] = {key: [] for key in _LISTS}
        facts = {"asset": {"version": "2.0", "generator": tool}, "scene": 0, "scenes": [{"name": name}]}
        self._glb = Glb({**facts, **lists}, bytearray())

    def add_flat(self, png: bytes, manifest: Manifest) -> int:
        """Add a bake's flat lightmap; returns the index of its texture."""
        return add_flat(self._glb, png, manifest.flat)

    def add_node(self, mesh: BakedMesh, texture: int, manifest: Manifest, clear: bool) -> int:
        """Add a baked copy's node, mesh and materials; returns the node's index.

        `texture` is its flat lightmap's; if `clear`, that one's alpha is blended.
        """
        mesh.glb.compact()
        whole, part = self._glb.document, mesh.glb.document
        whole["asset"]["generator"] = part["asset"]["generator"]
        (node,), (shape,) = part["nodes"], part["meshes"]
        first = len(whole["materials"])
        add_materials(self._glb, texture, manifest, mesh.numbers, node["name"], clear)
        accessor = self._add_accessors(mesh.glb)
        for primitive in shape["primitives"]:
            attributes = primitive["attributes"]
            primitive["attributes"] = {name: index + accessor for name, index in attributes.items()}
            primitive["indices"] += accessor
            primitive["material"] += first
        whole["meshes"].append(shape)
        whole["nodes"].append({**node, "mesh": len(whole["meshes"]) - 1})
        return len(whole["nodes"]) - 1

    def _add_accessors(self, part: Glb) -> int:
        """Add all accessors of a glTF, with their data; returns the index of the first."""
        views = []
        for view in part.document["bufferViews"]:
            facts = {key: value for key, value in view.items() if key not in _PLACE_OF_VIEW}
            begin = view.get("byteOffset", 0)
            views.append(self._glb.add_view(bytes(part.buffer[begin : begin + view["byteLength"]]), **facts))
        accessors = self._glb.document["accessors"]
        first = len(accessors)
        accessors += [
            {**each, "bufferView": views[each["bufferView"]]} for each in part.document["accessors"]
        ]
        return first

    def write(self, path: Path, shown: Sequence[tuple[int, Sequence[int]]]) -> None:
        """Write the file; `shown` are the indices of the scene's nodes, each with its levels of detail's.

        Raises InputError if it would be larger than a .glb can be.
        """
        if len(self._glb.buffer) > _MOST_BYTES:
            raise InputError(f"{path.name} would be larger than 4 GiB: export fewer objects at once")
        document = self._glb.document
        document["scenes"][0]["nodes"] = [index for index, _ in shown]
        for index, levels in shown:
            if levels:
                document["nodes"][index]["extensions"] = {LEVELS: {"ids": list(levels)}}
                document["extensionsUsed"] = sorted({*document["extensionsUsed"], LEVELS})
        self._glb.write(path)
