# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A glTF of many nodes, made of the baked copies one after the other; which nodes are levels of detail."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..core.errors import InputError
from ..formats.containers.glb import Glb
from .export_manifest import Manifest
from .exporting import ExportSource
from .gltf import BakedMesh, Pictures, add_flat, add_materials
from .gltf_images import GltfImages
from .quantised import compress

_LEVEL = re.compile(r"(.+)_LOD(\d{1,3})", re.IGNORECASE | re.DOTALL)
LEVELS = "MSFT_lod"
_MOST_BYTES = 2**32 - 2**26  # a .glb counts its bytes by 32 bits; the rest is for its JSON
_PLACE_OF_VIEW = ("buffer", "byteOffset", "byteLength")
_LISTS = ("nodes", "meshes", "materials", "accessors", "bufferViews", "images", "textures")


@dataclass(frozen=True)
class SceneNode:
    """A node of a scene: `surfaces` of the bake with this number in the list of bakes.

    Objects that share an atlas are a node each, so that each can be culled; a part is one node. `levels` are
    the same thing with fewer and fewer details, for larger distances: names of objects that end in _LOD1,
    _LOD2 and so on.
    """

    name: str
    bake: int
    surfaces: tuple[str, ...]
    levels: tuple[SceneNode, ...] = ()


def scene_nodes(bakes: Sequence[ExportSource]) -> tuple[SceneNode, ...]:
    """The nodes of these bakes, in their order, each with its levels of detail.

    Raises InputError if two bakes show the same thing, or would be written to files of the same name.
    """
    files: dict[str, ExportSource] = {}
    for bake in bakes:
        other = files.setdefault(bake.name.casefold(), bake)
        if other is not bake:
            raise InputError(
                f"{other.sidecar} and {bake.sidecar} would be written to the same files: leave one out"
            )
    nodes = [node for number, bake in enumerate(bakes) for node in _nodes_of(number, bake)]
    found: dict[str, SceneNode] = {}
    for node in nodes:
        other_node = found.setdefault(node.name, node)
        if other_node is not node:
            one, two = bakes[other_node.bake].sidecar, bakes[node.bake].sidecar
            raise InputError(f"{one} and {two} are both of '{node.name}': leave one of them out")
    return _with_levels(nodes)


def _nodes_of(number: int, bake: ExportSource) -> list[SceneNode]:
    facts = bake.bake
    if facts.part is not None:
        return [SceneNode(f"{facts.object_name}.{facts.part.name}", number, facts.surfaces)]
    return [SceneNode(name, number, (name,)) for name in facts.surfaces]


def _with_levels(nodes: Sequence[SceneNode]) -> tuple[SceneNode, ...]:
    """The nodes without those that are levels of detail of another, which has them."""
    groups: dict[str, list[tuple[int, SceneNode]]] = {}
    for node in nodes:
        named = _LEVEL.fullmatch(node.name)
        stem, level = (named[1], int(named[2])) if named else (f"{node.name}_LOD", 0)
        groups.setdefault(stem, []).append((level, node))
    found = []
    for group in groups.values():
        (_, first), *rest = sorted(group, key=lambda each: each[0])
        levels = tuple(node for _, node in rest)
        found.append(SceneNode(first.name, first.bake, first.surfaces, levels))
    return tuple(found)


class SceneGltf:
    """The glTF of a scene that is called `name`. Nodes are on one level, each with its place in the world."""

    def __init__(self, name: str, tool: str) -> None:
        lists: dict[str, list[Any]] = {key: [] for key in _LISTS}
        facts = {"asset": {"version": "2.0", "generator": tool}, "scene": 0, "scenes": [{"name": name}]}
        self._glb = Glb({**facts, **lists}, bytearray())
        self._images = GltfImages(self._glb)

    def add_flat(self, png: bytes, manifest: Manifest) -> int:
        """Add a bake's flat lightmap; returns the index of its texture."""
        return add_flat(self._images, png, manifest.flat)

    def add_node(
        self, mesh: BakedMesh, texture: int | None, manifest: Manifest, clear: bool, pictures: Pictures
    ) -> int:
        """Add a baked copy's node, mesh and materials; returns the node's index.

        `texture` is its flat lightmap's, for materials without `pictures`; if `clear`, its alpha is blended.
        """
        mesh.glb.compact()
        whole, part = self._glb.document, mesh.glb.document
        whole["asset"]["generator"] = part["asset"]["generator"]
        (node,), (shape,) = part["nodes"], part["meshes"]
        first = len(whole["materials"])
        for key in ("extensionsUsed", "extensionsRequired"):
            if key in part:
                whole[key] = sorted({*whole.get(key, []), *part[key]})
        add_materials(self._images, texture, manifest, mesh.numbers, node["name"], clear, pictures)
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

    def write(self, path: Path, shown: Sequence[tuple[int, Sequence[int]]], compressed: bool = False) -> None:
        """Write the file; `shown` are the indices of the scene's nodes, each with its levels of detail's.

        If `compressed`, meshes are so by EXT_meshopt_compression, which `baked_mesh` made them ready for.
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
        if compressed:
            compress(self._glb)
        self._glb.write(path)
