# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Refuse what would bake wrongly: surfaces that Cycles moves, unbaked rigid bodies, see-through objects."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import bpy

from ...core.errors import InputError


def refuse_displacement(name: str, materials: Iterable[bpy.types.Material | None]) -> None:
    """Raise InputError if one of the `materials` of the object `name` displaces it by shader."""
    for material in materials:
        if material is not None and _displaces(material):
            raise InputError(
                f"object '{name}': material '{material.name}' displaces the surface:"
                f" set its Displacement to Bump Only, or apply it with a Displace modifier"
            )


def refuse_adaptive_subdivision(rendered: bpy.types.Object, scene: Any) -> None:
    """Raise InputError if Cycles subdivides the evaluated object of the evaluated scene adaptively."""
    modifier = _adaptive(rendered, scene)
    if modifier is not None:
        raise InputError(
            f"object '{rendered.name}': its modifier '{modifier.name}' subdivides adaptively, by the camera:"
            f" turn Adaptive Subdivision off"
        )


def refuse_unbaked_rigid_bodies(scene: bpy.types.Scene) -> None:
    """Raise InputError if rigid bodies have moved without a baked cache: a scene copy would reset them."""
    world = scene.rigidbody_world
    if world is None or not world.enabled or world.collection is None or world.point_cache.is_baked:
        return
    bodies = [item for item in world.collection.objects if item.rigid_body is not None]
    moving = [item.name for item in bodies if item.rigid_body.type == "ACTIVE"]
    if moving and scene.frame_current > world.point_cache.frame_start:
        raise InputError(
            f"scene '{scene.name}': rigid bodies such as '{moving[0]}' have moved, and their simulation"
            f" is not baked: bake it (Scene > Rigid Body World > Cache)"
        )


def refuse_see_through(layer: bpy.types.ViewLayer, item: bpy.types.Object) -> None:
    """Raise InputError if cameras do not see an object in renders of a view layer, or see through it."""
    remedy = _why_unseen(layer, item)
    if remedy is not None:
        raise InputError(f"a bake of object '{item.name}' would be see-through: {remedy}")


def _why_unseen(layer: bpy.types.ViewLayer, item: Any) -> str | None:
    panel = "(Object Properties > Visibility)"
    if not item.visible_camera:
        return f"cameras do not see it; enable Ray Visibility > Camera {panel}"
    if item.is_shadow_catcher:
        return f"it is a shadow catcher; disable that {panel}"
    if item.is_holdout:
        return f"it is a holdout; disable that {panel}"
    for is_so, flag, name in (
        (item.holdout_get, "holdout", "Holdout"),
        (item.indirect_only_get, "indirect_only", "Indirect Only"),
    ):
        if is_so(view_layer=layer):
            home = _flagged_home(layer.layer_collection, item, flag)
            of = "" if home is None else f" of its collection '{home}'"
            return f"in view layer '{layer.name}' {name}{of} is on; disable that (in the Outliner)"
    return None


def _flagged_home(shown: Any, item: bpy.types.Object, flag: str) -> str | None:
    """The name of the first collection that holds the object itself and has the flag in a view layer."""
    if getattr(shown, flag, False) and item in shown.collection.objects.values():
        return str(shown.name)
    return next((name for child in shown.children if (name := _flagged_home(child, item, flag))), None)


def _displaces(material: bpy.types.Material) -> bool:
    if material.displacement_method == "BUMP" or material.node_tree is None:
        return False
    output = material.node_tree.get_output_node("CYCLES")
    if output is None:
        return False
    return any(link.is_valid and not link.is_muted for link in output.inputs["Displacement"].links)


def _adaptive(rendered: Any, scene: Any) -> bpy.types.Modifier | None:
    """The last modifier, if it is a Subdivision Surface that Cycles dices (intern/cycles/blender/util.h)."""
    modifiers = [modifier for modifier in rendered.modifiers if modifier.show_render]
    if not modifiers or modifiers[-1].type != "SUBSURF":
        return None
    last = modifiers[-1]
    if hasattr(last, "use_adaptive_subdivision"):  # Blender 5
        return last if last.use_adaptive_subdivision else None
    experimental = scene.cycles.feature_set == "EXPERIMENTAL"
    return last if experimental and rendered.cycles.use_adaptive_subdivision else None
