# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a material's own images give to the lookup, by nodes: `lookup.images.look_of_images`."""

from __future__ import annotations

from typing import Any

import bpy

from ....scene.image_materials import ImageMaterial, ImageSource
from ....scene.kept_images import ROLES, keep_facts
from ....scene.mesh.backs import TWIN
from ....scene.nodes import NodeBuilder, Operand, Socket
from ..lookup.images import ImageLook

_FLAT = (0.5, 0.5, 1.0)
_TOUCH = 1e-9  # of an image's alpha: enough for it to count as read


def keep_images(
    material: bpy.types.Material, tree: bpy.types.NodeTree, own: ImageMaterial, number: int
) -> None:
    """Give a material nodes with its own images, called after what they are, for it and for exports."""
    keep_facts(material, own, number)
    for role, source in zip(ROLES, own.sources, strict=True):
        if source is not None:
            node: Any = tree.nodes.new("ShaderNodeTexImage")
            node.name = node.label = role
            node.image, node.extension, node.interpolation = source.image, source.wrap, "Linear"


def given_by_images(
    build: NodeBuilder, own: ImageMaterial, look: ImageLook, twins: bool
) -> tuple[Operand, Operand, Operand]:
    """The diffuse colour, the lobes' tint and the shading normal in world space.

    With `twins`, some faces are those that others have for their backs, where a normal map lies as seen
    through these.
    """
    uv = build.uv_map(own.uv_map)
    base, metallic, roughness, normal = (
        _read(build, uv, role, source) for role, source in zip(ROLES, own.sources, strict=True)
    )
    metal = look.metallic if metallic is None else build.math("MULTIPLY", metallic, look.metallic)
    bare = build.math("SUBTRACT", 1.0, metal)
    if base is not None and own.base_alpha:
        base = _apart_from_alpha(build, base, build.tree.nodes[ROLES[0]].outputs["Alpha"])
    ours = (1.0, 1.0, 1.0) if base is None else base
    dull = build.vector("SCALE", build.vector("MULTIPLY", ours, look.diffuse), bare)
    shiny = build.vector("SCALE", build.vector("MULTIPLY", ours, look.metal), metal)
    rough = build.math("POWER", 1.0 if roughness is None else roughness, 4.0)
    kept = build.math("MULTIPLY", bare, build.math("MULTIPLY_ADD", rough, -look.fading, 1.0))
    tint = build.vector("MULTIPLY_ADD", look.dielectric, build.combine(kept, kept, kept), shiny)
    return dull, tint, _normal(build, own, normal, twins)


def _read(build: NodeBuilder, uv: Socket, role: str, source: ImageSource | None) -> Socket | None:
    """An image's colour or channel."""
    if source is None:
        return None
    node = build.tree.nodes[role]
    build.feed(node.inputs["Vector"], uv)
    colour = node.outputs["Color"]
    if source.channel is None:
        return colour
    return build.node("ShaderNodeSeparateColor", colour).outputs[source.channel]


def _apart_from_alpha(build: NodeBuilder, colour: Socket, alpha: Socket) -> Socket:
    """An image's colour without its alpha, by which Blender multiplies it unless the alpha is read, too."""
    touch = build.math("MULTIPLY", alpha, _TOUCH)
    return build.vector("ADD", colour, build.combine(touch, touch, touch))


def _normal(build: NodeBuilder, own: ImageMaterial, found: Socket | None, twins: bool) -> Socket:
    """The shading normal, in world space."""
    if found is None:
        return build.geometry("Normal")
    if twins:
        front = build.math("GREATER_THAN", build.attribute(TWIN, "Fac"), -1.5)
        side = build.math("MULTIPLY_ADD", front, 2.0, -1.0)
        turned = build.vector("SUBTRACT", found, _FLAT)
        found = build.vector("MULTIPLY_ADD", turned, build.combine(side, side, 1.0), _FLAT)
    node = build.node("ShaderNodeNormalMap", own.strength, found, space="TANGENT", uv_map=own.uv_map)
    return node.outputs["Normal"]
