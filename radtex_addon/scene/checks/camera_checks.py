# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Find what depends on the camera: a bake has its own, whose rays are short and start at the object."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, TypeAlias

import bpy

from .see_through import materials_of

_INPUT = "GeometryNodeInputActiveCamera"
Outputs: TypeAlias = Mapping[str, frozenset[str]]  # names of output sockets by node type

_ASKS: Outputs = {
    "CAMERA": frozenset({"View Vector", "View Z Depth", "View Distance"}),
    "LIGHT_PATH": frozenset({"Ray Length", "Portal Depth"}),
    "TEX_COORD": frozenset({"Camera", "Window"}),
}


def camera_dependent(layer: bpy.types.ViewLayer) -> list[str]:
    """Warnings about rendered objects of a view layer whose modifiers follow the active camera."""
    layer.update()  # or it lists objects that a script has just removed
    return [
        f"object '{item.name}' follows the active camera by its modifier '{name}', and a bake has "
        "a camera of its own: name the camera in an Object Info node instead"
        for item in layer.objects
        if not item.hide_render
        for name in _objects_asking(item)
    ]


def _objects_asking(item: bpy.types.Object) -> Iterator[str]:
    modifiers: Any = item.modifiers
    for modifier in modifiers:
        if modifier.type == "NODES" and modifier.show_render and _asks(modifier.node_group, set()):
            yield modifier.name


def _asks(tree: Any, seen: set[Any]) -> bool:
    if tree is None or tree in seen:
        return False
    seen.add(tree)
    for node in tree.nodes:
        if node.mute:
            continue
        if node.bl_idname == _INPUT and any(output.is_linked for output in node.outputs):
            return True
        if node.type == "GROUP" and _asks(node.node_tree, seen):
            return True
    return False


def camera_materials(item: bpy.types.Object) -> list[str]:
    """Warnings about nodes of an object's materials whose output depends on the camera's place.

    Nodes that depend on the viewing angle only, such as Layer Weight, and Is Camera Ray bake correctly.
    """
    return [
        f"material '{material.name}' of object '{item.name}' takes '{output}' of its node '{node}', and a "
        "bake has a camera of its own: feed a fixed value instead"
        for material in materials_of(item)
        for node, output in nodes_asked(material, _ASKS)
    ]


def nodes_asked(material: bpy.types.Material, outputs: Outputs) -> list[tuple[str, str]]:
    """The nodes that a material uses by one of the `outputs`: names of node and output."""
    tree: Any = material.node_tree
    return [] if tree is None else list(_asking(tree.get_output_node("CYCLES"), outputs, set()))


def _asking(node: Any, outputs: Outputs, known: set[Any]) -> Iterator[tuple[str, str]]:
    if node is None or node in known:
        return
    known.add(node)
    for link in (link for socket in node.inputs for link in socket.links if not link.is_muted):
        source, name = link.from_node, link.from_socket.name
        if source.mute:
            continue
        if name in outputs.get(source.type, ()) and (source, name) not in known:
            known.add((source, name))
            yield source.name, name
        if source.type == "GROUP" and source.node_tree is not None:
            for end in source.node_tree.nodes:
                if end.type == "GROUP_OUTPUT":
                    yield from _asking(end, outputs, known)
        yield from _asking(source, outputs, known)
