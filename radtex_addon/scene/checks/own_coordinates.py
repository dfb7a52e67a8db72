# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether a material looks different when its object is joined with others: it reads where its object is.

That are generated and object coordinates, what Object Info and the instancer tell, and all that Cycles takes
from generated coordinates where an input has no link.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import bpy

_BY_UV = frozenset(("TEX_IMAGE", "TEX_ENVIRONMENT", "TEX_SKY", "TEX_IES", "TEX_WHITE_NOISE", "TEX_COORD"))
_OF_MESH = ("Random Per Island", "Tangent")  # of the geometry
_OF_OBJECT = frozenset(("Generated", "Normal", "Object"))  # of texture coordinates


def reads_its_place(material: bpy.types.Material) -> bool:
    """Whether what the material shows depends on its object's own place, extent, name or instancer."""
    return _reads(material.node_tree, set(), _node_reads)


def reads_instancer(material: bpy.types.Material) -> bool:
    """Whether the material reads what geometry nodes, or particles, tell of each instance."""
    return _reads(material.node_tree, set(), _of_instancer)


def _reads(tree: bpy.types.NodeTree | None, known: set[Any], reads: Callable[[Any], bool]) -> bool:
    """Whether any node of a tree, or of its groups, reads that."""
    if tree is None or tree in known:
        return False
    known.add(tree)
    return any(
        _reads(node.node_tree, known, reads) if node.type == "GROUP" else reads(node)
        for node in list[Any](tree.nodes)
        if not node.mute and any(output.is_linked for output in node.outputs)
    )


def _of_instancer(node: Any) -> bool:
    if node.type == "ATTRIBUTE":
        return bool(node.attribute_type == "INSTANCER")
    return node.type == "PARTICLE_INFO" or getattr(node, "from_instancer", False)


def _node_reads(node: Any) -> bool:
    """Whether a node whose output is used reads its object's place."""
    kind: str = node.type
    if kind in _READS:
        return bool(_READS[kind](node))
    if kind.startswith("TEX_") and kind not in _BY_UV:
        return _is_unlinked(node, "Vector")
    return kind.startswith("BSDF_") and _is_brushed(node)


def _coordinates(node: Any) -> bool:
    linked = {output.name for output in node.outputs if output.is_linked}
    return node.from_instancer or (node.object is None and not linked.isdisjoint(_OF_OBJECT))


def _of_objects_space(node: Any) -> bool:
    return "OBJECT" in str(node.space)


_READS: dict[str, Callable[[Any], object]] = {  # by the node's type
    "AMBIENT_OCCLUSION": lambda node: node.only_local,
    "ATTRIBUTE": lambda node: node.attribute_type in {"OBJECT", "INSTANCER"},
    "BEVEL": lambda _: True,
    "DISPLACEMENT": _of_objects_space,
    "NEW_GEOMETRY": lambda node: any(node.outputs[name].is_linked for name in _OF_MESH),
    "NORMAL_MAP": _of_objects_space,
    "OBJECT_INFO": lambda _: True,
    "PARTICLE_INFO": lambda _: True,
    "SCRIPT": lambda _: True,
    "TANGENT": lambda node: node.direction_type == "RADIAL",
    "TEX_COORD": _coordinates,
    "TEX_IMAGE": lambda node: node.projection == "BOX",
    "UVMAP": lambda node: node.from_instancer,
    "VECTOR_DISPLACEMENT": _of_objects_space,
    "VECT_TRANSFORM": lambda node: "OBJECT" in (node.convert_from, node.convert_to),
}


def _is_brushed(node: Any) -> bool:
    """Whether a shader's highlights follow the tangent that Cycles makes of generated coordinates."""
    if not _is_unlinked(node, "Tangent"):
        return False
    strength = node.inputs.get("Anisotropic") or node.inputs.get("Anisotropy")
    return strength is not None and (strength.is_linked or strength.default_value != 0)


def _is_unlinked(node: Any, name: str) -> bool:
    socket = node.inputs.get(name)
    return socket is not None and not socket.is_linked
