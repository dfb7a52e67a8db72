# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Refuse numbers that no light can have: Cycles drops such light, and often that of everything else with it.

Looked at are lamps, the world, and materials of what a view layer renders: each node that feeds the output.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator
from typing import Any, cast

import bpy

from ...core.errors import InputError
from ..objects import is_rendered
from .see_through import materials_of, source_of, value_at

_MOST = 1e30  # of light: Blender stores 3.4e38 for infinity, and sums of such light overflow
_MOST_STOPS = 90.0
_LIGHT = {  # inputs of nodes that light
    "EMISSION": ("Color", "Strength"),
    "BACKGROUND": ("Color", "Strength"),
    "BSDF_PRINCIPLED": ("Emission Color", "Emission Strength"),
    "PRINCIPLED_VOLUME": ("Emission Color", "Emission Strength", "Blackbody Intensity"),
}
_CONSTANTS = ("VALUE", "RGB")  # nodes whose number is in their output


def refuse_unfinite_light(scene: bpy.types.Scene, layer: bpy.types.ViewLayer) -> None:
    """Raise InputError for the first number that is not finite, or is light of more than 1e30."""
    for item in _rendered(layer):
        if item.type == "LIGHT":
            _check_lamp(item)
        for material in materials_of(item):
            _check(f"material '{material.name}'", material)
    world = cast(Any, layer).world_override or scene.world
    if world is not None:
        _check(f"world '{world.name}'", world)


def black_bake(name: str) -> str:
    """The warning about a bake in which no light was captured at all."""
    return (
        f"no light at all comes from '{name}': its bake is black. If lamps or the world should light it, "
        "look for infinite values and NaN in what their nodes compute, and in their images"
    )


def _rendered(layer: bpy.types.ViewLayer) -> Iterator[Any]:
    """The objects that a view layer renders, and those of the collections that these instance."""
    layer.update()
    known: set[Any] = set()
    for item in layer.objects:
        if item in known or not is_rendered(item, layer):
            continue
        known.add(item)
        yield item
        if item.instance_type == "COLLECTION" and item.instance_collection is not None:
            for each in item.instance_collection.all_objects:
                if each not in known and not each.hide_render:
                    known.add(each)
                    yield each


def _check_lamp(item: Any) -> None:
    lamp = item.data
    exposure = getattr(lamp, "exposure", 0.0)  # of Blender 5
    _refuse(f"lamp '{item.name}': its strength", (lamp.energy,), _MOST)
    _refuse(f"lamp '{item.name}': its exposure", (exposure,), _MOST_STOPS)
    _refuse(f"lamp '{item.name}': its colour", lamp.color[:], _MOST)
    _check(f"lamp '{item.name}'", lamp)


def _uses_nodes(block: Any) -> bool:
    """Whether nodes are switched on; of lamps Blender 5.2 warns that Blender 6 will not say it."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        return bool(getattr(block, "use_nodes", True))


def _check(whose: str, block: Any) -> None:
    """Check the nodes that feed the output of a material, a world or a lamp."""
    tree, always = block.node_tree, bpy.app.version >= (5, 0, 0) and not isinstance(block, bpy.types.Light)
    if tree is None or not (always or _uses_nodes(block)):
        return
    output = tree.get_output_node("CYCLES")
    if output is not None:
        _check_feeding(whose, output, (), set())


def _check_feeding(whose: str, node: Any, groups: tuple[Any, ...], known: set[Any]) -> None:
    """Check the numbers of a node within `groups`, and of all nodes that feed it."""
    if (node, groups) in known:
        return
    known.add((node, groups))
    light = _LIGHT.get(node.type, ())
    for socket in node.inputs:
        of = f"{whose}: {socket.name} of its node '{node.name}'"
        found = source_of(socket, groups)
        if found is None:
            _refuse(of, _numbers(socket), _MOST if socket.name in light else math.inf)
            continue
        if socket.name in light and socket.type == "VALUE":
            _refuse(of, (value_at(socket, groups) or 0.0,), _MOST)
        behind, output, inside = found
        if behind.type in _CONSTANTS:
            most = _MOST if socket.name in light else math.inf
            _refuse(f"{whose}: its node '{behind.name}'", _numbers(output), most)
        _check_feeding(whose, behind, inside, known)


def _numbers(socket: Any) -> tuple[float, ...]:
    """The numbers of a socket that is not linked; none for shaders and words."""
    if socket.type in ("VALUE", "INT"):
        return (float(socket.default_value),)
    return tuple(socket.default_value[:]) if socket.type in ("RGBA", "VECTOR") else ()


def _refuse(what: str, values: tuple[float, ...], most: float) -> None:
    if any(math.isnan(value) for value in values):
        raise InputError(f"{what} is not a number, and Cycles drops such light: give it one")
    if any(math.isinf(value) or abs(value) >= most for value in values):
        raise InputError(f"{what} is infinite, and Cycles drops such light: give it a number")
