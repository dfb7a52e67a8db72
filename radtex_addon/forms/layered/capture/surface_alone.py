# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""An object's surface as a camera sees it with nothing behind: what an engine's shader gives, and its alpha.

Materials that let camera rays go on are replaced by copies in which Transparent shaders, and the
transparency of Principled ones, are black to camera rays; all other rays pass as before, so light through
the object and its shadow stay. The light that a camera then sees is premultiplied by the surface's alpha.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, TypeAlias, cast

import bpy

from ....scene.checks.see_through import is_see_through
from ....scene.lights.light import without_emission
from ....scene.mesh.panes import Panes, as_pane
from ....scene.nodes import NodeBuilder, Socket, operand_of

_UNKNOWN = frozenset({"HOLDOUT", "BSDF_RAY_PORTAL", "SCRIPT"})  # they may be clear in ways of their own
_WHITE = (1.0, 1.0, 1.0, 1.0)

Clear: TypeAlias = Mapping[bpy.types.Material, bpy.types.Material]
_Change: TypeAlias = Callable[[NodeBuilder, Any], None]  # of a node that is clear, in its tree


@contextmanager
def surface_alone(
    items: Sequence[bpy.types.Object],
    meshes: Sequence[bpy.types.Mesh] = (),
    panes: Sequence[Panes] = (),
) -> Iterator[Clear]:
    """Let camera rays end at the surfaces of `items`, whose slots have their own materials again at the end.

    `meshes` are copies of their meshes, whose materials are exchanged likewise. Each object's materials that
    make flat `panes` are clear, too: see `as_pane`.

    Yields their see-through materials, as they are now, each with one that emits to the camera what is seen
    through it of an evenly white background, and nothing else. Those with shaders whose transparency is
    unknown, Holdout, Ray Portal or a script, stay as they are, and are not among them.
    """
    flat = panes or [frozenset[bpy.types.Material]()] * len(items)
    before = [[slot.material for slot in item.material_slots] for item in items]
    of_meshes = [list(mesh.materials) for mesh in meshes]
    made: dict[tuple[bpy.types.Material, bool], bpy.types.Material] = {}
    clear: dict[bpy.types.Material, bpy.types.Material] = {}

    def alone(material: bpy.types.Material | None, flat: Panes) -> bpy.types.Material | None:
        if material is None:
            return None
        key = material, material in flat
        if key not in made:
            made[key] = own = as_pane(material) if material in flat else material
            if is_see_through(own) and not _has_unknown(own.node_tree):
                made[key] = stopped = _changed(own, _stop_rays)
                clear[stopped] = _changed(without_emission(own), _show_background)
                cast(Any, clear[stopped]).cycles.emission_sampling = "NONE"
        return made[key]

    try:
        for item, own, some in zip(items, before, flat, strict=True):
            _assign(item, [alone(material, some) for material in own])
        for mesh, own, some in zip(meshes, of_meshes, flat, strict=False):
            _assign_to_mesh(mesh, [alone(material, some) for material in own])
        yield clear
    finally:
        for item, own in zip(items, before, strict=True):
            _assign(item, own)
        for mesh, own in zip(meshes, of_meshes, strict=True):
            _assign_to_mesh(mesh, own)


def _assign(item: bpy.types.Object, materials: list[bpy.types.Material | None]) -> None:
    for slot, material in zip(item.material_slots, materials, strict=True):
        if slot.material != material:
            slot.material = material


def _assign_to_mesh(mesh: bpy.types.Mesh, materials: list[bpy.types.Material | None]) -> None:
    for index, material in enumerate(materials):
        if mesh.materials[index] != material:
            mesh.materials[index] = material


def _has_unknown(tree: Any) -> bool:
    if tree is None:
        return False
    return any(
        node.type in _UNKNOWN or (node.type == "GROUP" and _has_unknown(node.node_tree))
        for node in tree.nodes
    )


def _changed(material: bpy.types.Material, change: _Change) -> bpy.types.Material:
    copy = cast(bpy.types.Material, material.copy())
    _change_nodes(copy.node_tree, change, {})
    return copy


def _change_nodes(tree: Any, change: _Change, changed: dict[Any, Any]) -> None:
    """Change what is clear in a tree; groups are copied, each once."""
    build = NodeBuilder(tree)
    for node in list(tree.nodes):
        if node.mute:
            continue
        if node.type == "GROUP" and node.node_tree is not None:
            if node.node_tree not in changed:
                copy = changed[node.node_tree] = node.node_tree.copy()
                _change_nodes(copy, change, changed)
            node.node_tree = changed[node.node_tree]
        elif node.type == "BSDF_TRANSPARENT" or (node.type == "BSDF_PRINCIPLED" and _may_be_clear(node)):
            change(build, node)


def _may_be_clear(principled: Any) -> bool:
    alpha = principled.inputs["Alpha"]
    return bool(alpha.is_linked or alpha.default_value < 1)


def _stop_rays(build: NodeBuilder, node: Any) -> None:
    """Make a node's transparency black to camera rays."""
    camera = build.node("ShaderNodeLightPath").outputs["Is Camera Ray"]
    if node.type == "BSDF_TRANSPARENT":
        colour = node.inputs["Color"]
        others = build.math("SUBTRACT", 1.0, camera)
        build.feed(colour, build.vector("SCALE", operand_of(colour), others))
        return
    alpha = _alpha(build, node)
    share = build.mix(camera, 1.0, alpha, kind="FLOAT")
    build.feed(node.inputs["Alpha"], build.math("MAXIMUM", alpha, camera))
    _replace(build, node, lambda shown: _mixed(build, share, None, shown))


def _show_background(build: NodeBuilder, node: Any) -> None:
    """Let a node emit to the camera what it lets through, of white: a path that goes on would meet more."""
    camera = build.node("ShaderNodeLightPath").outputs["Is Camera Ray"]
    if node.type == "BSDF_TRANSPARENT":
        through = build.vector("SCALE", operand_of(node.inputs["Color"]), 1.0)
        emission = build.node("ShaderNodeEmission", through, camera).outputs[0]
        _replace(build, node, lambda _: emission)
        return
    alpha = _alpha(build, node)
    build.feed(node.inputs["Alpha"], build.math("MAXIMUM", alpha, 1.0))
    white = build.node("ShaderNodeEmission", _WHITE, camera).outputs[0]
    _replace(build, node, lambda shown: _mixed(build, alpha, white, shown))


def _alpha(build: NodeBuilder, principled: Any) -> Socket:
    """A Principled node's alpha, within 0 and 1 as Cycles takes it."""
    return build.math("MINIMUM", build.math("MAXIMUM", operand_of(principled.inputs["Alpha"]), 0.0), 1.0)


def _mixed(build: NodeBuilder, share: Socket, at_zero: Socket | None, at_one: Socket) -> Socket:
    """A mix of shaders; None is black."""
    node = build.node("ShaderNodeMixShader", share)
    if at_zero is not None:
        build.feed(node.inputs[1], at_zero)
    build.feed(node.inputs[2], at_one)
    return node.outputs[0]


def _replace(build: NodeBuilder, node: Any, made: Callable[[Socket], Socket]) -> None:
    """Put the shader that `made` makes of a node's where that one goes."""
    fed = [link.to_socket for link in node.outputs[0].links]
    shader = made(node.outputs[0])
    for socket in fed:
        build.tree.links.new(shader, socket)
