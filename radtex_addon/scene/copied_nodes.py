# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Copy nodes from one tree to another, with their links, as the clipboard of the node editor does."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, cast

import bpy

_KEPT = ("name", "label", "location", "width")  # of what all nodes have


def copy_nodes(
    nodes: Iterable[bpy.types.Node], source: bpy.types.NodeTree, target: bpy.types.NodeTree
) -> dict[bpy.types.Node, bpy.types.Node]:
    """Copy some nodes of `source`, and the links among them, into `target`. Returns the copies.

    Nodes whose sockets Blender makes only later, as Script nodes' are, are not for this.
    """
    copies = {node: _copy(node, target) for node in nodes}
    for link in cast("Iterable[Any]", source.links):
        if link.from_node in copies and link.to_node in copies:
            start = copies[link.from_node].outputs[_place(link.from_node.outputs, link.from_socket)]
            end = copies[link.to_node].inputs[_place(link.to_node.inputs, link.to_socket)]
            target.links.new(start, end)
    return copies


def same_socket(socket: Any, copies: dict[bpy.types.Node, bpy.types.Node]) -> bpy.types.NodeSocket:
    """The output of a copied node that an output of the original became."""
    return copies[socket.node].outputs[_place(socket.node.outputs, socket)]


def _place(sockets: Any, wanted: Any) -> int:
    return next(number for number, socket in enumerate(sockets) if socket == wanted)


def _copy(node: bpy.types.Node, target: bpy.types.NodeTree) -> bpy.types.Node:
    copy = target.nodes.new(node.bl_idname)
    common = set(bpy.types.Node.bl_rna.properties.keys())
    own = [each for each in node.bl_rna.properties if each.identifier not in common and not each.is_readonly]
    for name in (*_KEPT, *(each.identifier for each in own)):
        setattr(copy, name, getattr(node, name))
    for before, after in zip(cast(Any, node.inputs), cast(Any, copy.inputs), strict=True):
        if hasattr(before, "default_value"):
            after.default_value = before.default_value
    return copy
