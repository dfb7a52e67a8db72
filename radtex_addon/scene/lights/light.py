# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Find out whether a scene emits light, and copy materials and worlds without their light."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any, cast

import bpy

from ..nodes import NodeBuilder
from ..objects import is_rendered

# Shader nodes that emit light, in materials and worlds, with their sockets of colour and strength.
_EMITTERS = {
    "BACKGROUND": (("Color", "Strength"),),
    "EMISSION": (("Color", "Strength"),),
    "BSDF_PRINCIPLED": (("Emission Color", "Emission Strength"),),
    "PRINCIPLED_VOLUME": (("Emission Color", "Emission Strength"), ("Blackbody Tint", "Blackbody Intensity")),
}

_OF_CAMERA = "Is Camera Ray"  # an output of the Light Path node, 0 where a mirror sends the camera's rays on
_MIRRORED = frozenset({"Is Glossy Ray", "Is Singular Ray", "Is Reflection Ray"})  # 1 for these then
_DEEPER = frozenset({"Ray Depth", "Glossy Depth"})  # greater by 1 for all rays then


def is_dark(scene: bpy.types.Scene, layer: bpy.types.ViewLayer) -> bool:
    """Whether a scene has no rendered lamp, a black world, and no material that could emit light.

    A guess, good enough for a warning only: any linked socket counts as light.
    """
    layer.update()  # or it lists objects that a script has just removed
    shown = [item for item in layer.objects if is_rendered(item, layer)]
    if any(item.type == "LIGHT" and item.data.energy > 0 for item in shown):
        return False
    world = cast(Any, layer).world_override or scene.world
    if world is not None and _world_shines(world):
        return False
    materials = {slot.material for item in shown for slot in item.material_slots if slot.material}
    if any(map(glows, materials)):
        return False
    return not any(item.instance_type != "NONE" for item in shown)


def may_glow(layer: bpy.types.ViewLayer) -> bool:
    """Whether anything but a view layer's own lamps and the world might emit light; True if in doubt."""
    if any(map(glows, _used_materials())):
        return True
    instancing = (item.instance_type != "NONE" or _has_geometry_nodes(item) for item in layer.objects)
    return any(instancing)  # the instances may be lamps


def glows(material: bpy.types.Material) -> bool:
    """Whether a material could emit light: any linked socket counts as light."""
    return _has_nodes(material) and _shines(material.node_tree)


def _used_materials() -> list[bpy.types.Material]:
    """All materials with users: slots, or nodes that set them."""
    return [material for material in bpy.data.materials if material.users]


def _has_geometry_nodes(item: bpy.types.Object) -> bool:
    return any(modifier.type == "NODES" for modifier in item.modifiers)


def without_emission(material: bpy.types.Material) -> bpy.types.Material:
    """A copy of the material that emits no light; the material itself if it emits none."""
    if not glows(material):
        return material
    dark = cast(bpy.types.Material, material.copy())
    _change(dark.node_tree, _put_out, {})
    return dark


def dark_to_cameras(material: bpy.types.Material) -> bpy.types.Material:
    """A copy of the material whose emission cameras do not see; the material itself if it emits none."""
    if not glows(material):
        return material
    copy = cast(bpy.types.Material, material.copy())
    _change(copy.node_tree, _hide_emission, {})
    return copy


def _hide_emission(tree: Any) -> None:
    """Multiply every emitter's strength by 0 for camera rays."""
    build = NodeBuilder(tree)
    others = build.math("SUBTRACT", 1.0, build.node("ShaderNodeLightPath").outputs["Is Camera Ray"])
    for node in list(tree.nodes):
        for _, name in _EMITTERS.get(node.type, ()):
            strength = node.inputs[name]
            before = strength.links[0].from_socket if strength.is_linked else strength.default_value
            build.feed(strength, build.math("MULTIPLY", before, others))


def dark_world(world: bpy.types.World | None) -> bpy.types.World | None:
    """A copy of the world, with its volume, that emits no light; the world itself if it emits none."""
    if world is None or not _world_shines(world):
        return world
    dark = cast(bpy.types.World, world.copy())
    dark.color = 0, 0, 0
    if _has_nodes(dark):
        _change(dark.node_tree, _put_out, {})
    return dark


def world_in_reflections(world: bpy.types.World | None) -> bpy.types.World | None:
    """The world as camera rays see it in a copy if mirrored rays see it otherwise, or the world itself.

    A world may be hidden from some rays, or be another one to them by a Light Path node.
    """
    if world is None:
        return None
    seen = cast(Any, world).cycles_visibility
    if seen.camera == seen.glossy and not _reads_light_path(world.node_tree):
        return world
    copy = cast(bpy.types.World, world.copy())
    cast(Any, copy).cycles_visibility.camera = seen.glossy
    if _has_nodes(copy):
        _change(copy.node_tree, _reflect, {})
    return copy


@contextmanager
def materials_in_reflections() -> Iterator[None]:
    """Within the context, camera rays see all materials as mirrored rays do.

    Materials that read a Light Path node, such as that of a card which hides from the camera, are exchanged
    for copies; at the end all users have their own again. What is linked from another file keeps its own.
    """
    changed = [material for material in _used_materials() if _reads_light_path(material.node_tree)]
    copies = [cast(bpy.types.Material, material.copy()) for material in changed]
    try:
        for material, copy in zip(changed, copies, strict=True):
            _change(copy.node_tree, _reflect, {})
            material.user_remap(copy)
        yield
    finally:
        for material, copy in zip(changed, copies, strict=True):
            copy.user_remap(material)


def _reads_light_path(tree: Any) -> bool:
    return tree is not None and any(
        node.type == "LIGHT_PATH" or (node.type == "GROUP" and _reads_light_path(node.node_tree))
        for node in tree.nodes
    )


def _reflect(tree: Any) -> None:
    """Let a tree's Light Path nodes tell of rays that a mirror sent on."""
    build = NodeBuilder(tree)
    for node in list(tree.nodes):
        for output in node.outputs if node.type == "LIGHT_PATH" else ():
            links = list(output.links)
            mirrored = _mirrored(build, output, node.outputs[_OF_CAMERA]) if links else output
            for socket in [link.to_socket for link in links]:
                build.feed(socket, mirrored)


def _mirrored(build: NodeBuilder, output: Any, of_camera: Any) -> Any:
    """What an output of a Light Path node tells of rays that a mirror sent on."""
    if output.name == _OF_CAMERA:
        return build.math("MULTIPLY", output, 0.0)
    if output.name in _MIRRORED:
        return build.math("MAXIMUM", output, of_camera)
    return build.math("ADD", output, 1.0) if output.name in _DEEPER else output


def _put_out(tree: Any) -> None:
    """Link every emitter's strength to 0, which overrides drivers too."""
    nothing = tree.nodes.new("ShaderNodeValue").outputs[0]
    nothing.default_value = 0.0
    for node in list(tree.nodes):
        for _, strength in _EMITTERS.get(node.type, ()):
            tree.links.new(nothing, node.inputs[strength])


def _change(tree: Any, change: Callable[[Any], None], copied: dict[bpy.types.ID, bpy.types.ID]) -> None:
    """Change a node tree, and the groups in it, which are copied, each once."""
    change(tree)
    for node in list(tree.nodes):
        if node.type == "GROUP" and node.node_tree is not None:
            if node.node_tree not in copied:
                copy = copied[node.node_tree] = node.node_tree.copy()
                _change(copy, change, copied)
            node.node_tree = copied[node.node_tree]


def _world_shines(world: bpy.types.World) -> bool:
    return (
        _shines(world.node_tree) if _has_nodes(world) else any(component > 0 for component in world.color[:])
    )


def _has_nodes(block: bpy.types.World | bpy.types.Material) -> bool:
    return bpy.app.version >= (5, 0, 0) or block.use_nodes


def _shines(tree: bpy.types.NodeTree | None) -> bool:
    if tree is None:
        return False
    nodes: Iterable[Any] = tree.nodes  # the stubs lack groups' trees and sockets' values
    for node in nodes:
        if node.type == "GROUP":
            if _shines(node.node_tree):
                return True
        elif any(_bright(node.inputs[colour], node.inputs[strength]) for colour, strength in _sockets(node)):
            return True
    return False


def _sockets(node: Any) -> tuple[tuple[str, str], ...]:
    return _EMITTERS.get(node.type, ()) if any(output.is_linked for output in node.outputs) else ()


def _bright(colour: Any, strength: Any) -> bool:
    coloured: bool = colour.is_linked or max(colour.default_value[:3]) > 0
    strong: bool = strength.is_linked or strength.default_value > 0
    return coloured and strong
