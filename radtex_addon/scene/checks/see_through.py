# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Find objects that a camera sees through, in places or everywhere, because of their materials or hair.

Materials are judged by the nodes that feed their output for camera rays: nodes that are not linked, or that a
Mix Shader leaves out for camera rays, do not count. The materials are those in the object's slots, and those
that its geometry nodes set. Volumes around an object are found, too: rays that a portal sends into one are
traced as if outside it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any, TypeAlias, cast

import bpy

from ..objects import about_matrix, is_rendered, world_box
from ..scratch import find_view_layer

_OUTPUTS = ("OUTPUT_MATERIAL", "OUTPUT_WORLD")


def _power(base: float, exponent: float) -> float:
    try:
        found = base**exponent
    except OverflowError:
        return math.inf
    except ZeroDivisionError:
        return 0.0
    return found if isinstance(found, float) else 0.0  # of a number below 0


_CLEAR = frozenset({"BSDF_TRANSPARENT", "HOLDOUT", "BSDF_RAY_PORTAL", "SCRIPT"})
_GLASS = frozenset({"BSDF_GLASS", "BSDF_REFRACTION"})
_ARITHMETIC: dict[str, Callable[[float, float], float]] = {
    "ADD": lambda a, b: a + b,
    "SUBTRACT": lambda a, b: a - b,
    "MULTIPLY": lambda a, b: a * b,
    "DIVIDE": lambda a, b: a / b if b else 0.0,  # as Cycles does
    "POWER": _power,
    "MAXIMUM": max,
    "MINIMUM": min,
}

Groups: TypeAlias = tuple[Any, ...]  # the group nodes that a socket lies in, outermost first


def why_no_surface(scene: bpy.types.Scene, item: bpy.types.Object) -> str:
    """Why a surface with an alpha cannot stand for the mesh object `item`, as the end of a sentence about it.

    It has a volume, hair, glass that a transparent film makes clear, or a clear material that is in none of
    its slots but set by geometry nodes. Empty if a surface can.
    """
    glass = scene.render.film_transparent and cast(Any, scene).cycles.film_transparent_glass
    in_slots = {slot.material for slot in item.material_slots}
    for material in materials_of(item):
        if fills_volume(material):
            return f"its material '{material.name}' has a volume"
        clear = is_see_through(material)
        if glass and not clear and is_see_through(material, glass):
            return f"its material '{material.name}' is glass, which the transparent film makes clear"
        if clear and material not in in_slots:
            return f"its material '{material.name}', set by geometry nodes, lets through what is behind it"
    hair = next(_hair(scene, item), None)
    return "" if hair is None else f"it has hair, '{hair}'"


def materials_of(item: bpy.types.Object) -> list[bpy.types.Material]:
    """The materials of the object's slots and of its geometry nodes, each once."""
    found = [slot.material for slot in item.material_slots]
    for modifier in cast("list[Any]", item.modifiers):
        if modifier.type == "NODES" and modifier.node_group is not None and modifier.show_render:
            found += _given_to(modifier)
            found += _set_by(modifier.node_group, set())
    return list(dict.fromkeys(one for one in found if isinstance(one, bpy.types.Material)))


def is_see_through(material: bpy.types.Material, glass: bool = False) -> bool:
    """Whether camera rays may pass through the material; with `glass`, glass counts too."""
    output = _output(material)
    return output is not None and _is_clear(output.inputs["Surface"], (), glass)


def fills_volume(material: bpy.types.Material) -> bool:
    """Whether the material has a volume."""
    output = _output(material)
    return output is not None and source_of(output.inputs["Volume"], ()) is not None


def _output(material: bpy.types.Material) -> Any:
    return None if material.node_tree is None else material.node_tree.get_output_node("CYCLES")


def _is_clear(socket: Any, groups: Groups, glass: bool) -> bool:
    """Whether the shader that feeds the input `socket` may be clear."""
    found = source_of(socket, groups)
    if found is None:
        return False
    node, _, groups = found
    if node.type == "MIX_SHADER":
        share = value_at(node.inputs[0], groups)
        mixed = [node.inputs[1 + index] for index in (0, 1) if share != 1 - index]
        return any(_is_clear(one, groups, glass) for one in mixed)
    if node.type == "ADD_SHADER":
        return any(_is_clear(one, groups, glass) for one in node.inputs)
    if node.type == "BSDF_PRINCIPLED":
        alpha, through = (value_at(node.inputs[name], groups) for name in ("Alpha", "Transmission Weight"))
        return alpha is None or alpha < 1 or (glass and through != 0)
    return node.type in _CLEAR or (glass and node.type in _GLASS)


def value_at(socket: Any, groups: Groups) -> float | None:
    """The number at an input `socket` for camera rays; None if nodes compute it in a way not known here."""
    found = source_of(socket, groups)
    if found is None:
        return float(socket.default_value) if not socket.is_linked else None
    node, output, groups = found
    if node.type in ("VALUE", "GROUP"):  # an unlinked input of a group
        return float(output.default_value) if output.type in ("VALUE", "INT") else None
    if node.type == "LIGHT_PATH" and output.name.startswith("Is "):
        return 1.0 if output.name == "Is Camera Ray" else 0.0
    if node.type == "MATH" and node.operation in _ARITHMETIC:
        first, second = (value_at(one, groups) for one in list(node.inputs)[:2])
        if first is None or second is None:
            return None
        result = _ARITHMETIC[node.operation](first, second)
        return min(max(result, 0.0), 1.0) if node.use_clamp else result
    return None


def colour_at(socket: Any, groups: Groups) -> tuple[float, float, float] | None:
    """The colour at an input `socket`, linear; None if nodes compute it in a way not known here."""
    found = source_of(socket, groups)
    if found is None:
        value = None if socket.is_linked else socket.default_value
    else:
        node, output, _ = found  # a group's is an unlinked input
        value = output.default_value if node.type in ("RGB", "GROUP") and output.type == "RGBA" else None
    if value is None:
        return None
    red, green, blue = list(value)[:3]
    return red, green, blue


def source_of(socket: Any, groups: Groups) -> tuple[Any, Any, Groups] | None:
    """The node and output that feed an input, followed through reroutes, muted nodes and groups; or None.

    If an unlinked input of a group node feeds it: that node and input.
    """
    while True:
        link = next((one for one in socket.links if one.is_valid and not one.is_muted), None)
        if link is None:
            return None
        node, output = link.from_node, link.from_socket
        if node.type == "GROUP_INPUT" and groups:
            inside, groups = groups[-1], groups[:-1]
            socket = next(one for one in inside.inputs if one.identifier == output.identifier)
            if not socket.is_linked:
                return inside, socket, groups
            continue
        following = _behind(node, output)
        if following is None:
            return node, output, groups
        socket = following
        if node.type == "GROUP" and not node.mute:
            groups = (*groups, node)


def _behind(node: Any, output: Any) -> Any:
    """The input that a reroute, a muted node or a group passes on to `output`; None for other nodes."""
    if node.mute:
        return next((one.from_socket for one in node.internal_links if one.to_socket == output), None)
    if node.type == "REROUTE":
        return node.inputs[0]
    if node.type == "GROUP" and node.node_tree is not None:
        ends = [one for one in node.node_tree.nodes if one.type == "GROUP_OUTPUT" and one.is_active_output]
        inputs = [one for end in ends for one in end.inputs if one.identifier == output.identifier]
        return inputs[0] if inputs else None
    return None


def _given_to(modifier: Any) -> Iterator[Any]:
    """Values of the inputs of a geometry nodes modifier."""
    names = [one.identifier for one in modifier.node_group.interface.items_tree if one.item_type == "SOCKET"]
    given = getattr(modifier, "properties", None)
    if given is None:  # Blender 4.5
        yield from (modifier[name] for name in names if name in modifier)
    else:
        yield from (getattr(getattr(given.inputs, name, None), "value", None) for name in names)


def _set_by(tree: Any, known: set[Any]) -> Iterator[Any]:
    """Values of a geometry node tree's material inputs, including those of its groups."""
    if tree is None or tree in known:
        return
    known.add(tree)
    for node in tree.nodes:
        yield from (one.default_value for one in node.inputs if one.type == "MATERIAL")
        yield getattr(node, "material", None)
        if node.type == "GROUP":
            yield from _set_by(node.node_tree, known)


def _hair(scene: bpy.types.Scene, item: bpy.types.Object) -> Iterator[str]:
    """Names of particle systems and curves that render as hair on the object."""
    for modifier in cast("list[Any]", item.modifiers):
        if modifier.type == "PARTICLE_SYSTEM" and modifier.show_render:
            system = modifier.particle_system
            if system.settings.type == "HAIR" and system.settings.render_type == "PATH":
                yield system.name
    grown = [curves for curves in bpy.data.hair_curves if curves.surface == item]
    if grown:
        layer = find_view_layer(scene, None)
        shown = (one for one in scene.objects if one.data in grown and is_rendered(one, layer))
        yield from (one.name for one in shown)


def volumes_around(layer: bpy.types.ViewLayer, item: bpy.types.Object) -> list[str]:
    """Names of the rendered volume domains, except `item`, whose bounding boxes meet that of `item`.

    A domain is a volume object, or a mesh whose material has a volume. (The world's volume bakes correctly.)
    """
    layer.update()  # or it lists objects that a script has just removed
    low, high = world_box(item, about_matrix(item, layer))
    found = []
    for other in layer.objects:
        if other == item or not _holds_volume(other) or not is_rendered(other, layer):
            continue
        other_low, other_high = world_box(other, about_matrix(other, layer))
        if (low <= other_high).all() and (other_low <= high).all():
            found.append(other.name)
    return found


def has_volumes(scene: bpy.types.Scene) -> bool:
    """Whether rays may meet a volume: any in the file, or the world's.

    Blender 5's Cycles learns from neighbouring pixels how to sample volumes: a picture's bits then depend on
    how it is cut into tiles.
    """
    trees = [material.node_tree for material in bpy.data.materials]
    if scene.world is not None:
        trees.append(scene.world.node_tree)
    return len(bpy.data.volumes) > 0 or any(_puts_volume_out(tree) for tree in trees)


def _holds_volume(item: bpy.types.Object) -> bool:
    if item.type == "VOLUME":
        return True
    return any(_puts_volume_out(slot.material.node_tree) for slot in item.material_slots if slot.material)


def _puts_volume_out(tree: bpy.types.NodeTree | None) -> bool:
    outputs = [node for node in tree.nodes if node.type in _OUTPUTS] if tree else []
    return any(node.inputs["Volume"].is_linked for node in outputs)
