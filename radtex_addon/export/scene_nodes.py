# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Which nodes a scene of several bakes has, and which of them are levels of detail of another."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from ..core.errors import InputError
from .exporting import ExportSource

_LEVEL = re.compile(r"(.+)_LOD(\d{1,3})", re.IGNORECASE | re.DOTALL)


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
