# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The objects that a hull shows in their place: those inside it, a collection, or everything."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, cast

import bpy
import numpy as np

from ..core.arrays import Floats
from ..core.errors import InputError
from .objects import about_matrix, is_rendered, world_box
from .regroup import regroup

_UNSEEN = ("LIGHT", "LIGHT_PROBE", "CAMERA", "SPEAKER", "ARMATURE", "LATTICE")
EVERYTHING = "*"  # as a hull's content: all objects but the hull
_LEAST = 0.5  # an object is inside if this share of its bounding box is in the hull's bounding box
_SLACK = 0.01  # times the size of the hull's box: tolerance for hair that sticks out

Bounds = tuple[Floats, Floats]  # lowest and highest corner (3,), in world space


def find_content(
    layer: bpy.types.ViewLayer, hull: bpy.types.Object, content: str | None
) -> tuple[bpy.types.Object, ...]:
    """The objects that `hull` shows in a view layer, sorted by name, without `hull` itself.

    If `content` is None, the objects with at least half of their bounding box in the hull's; else the objects
    in the collection called `content`, or all with EVERYTHING. Lamps never count. Raises InputError if there
    are no such objects.
    """
    layer.update()  # or it lacks objects that were linked since
    shown = [item for item in layer.objects if item != hull and item.type not in _UNSEEN]
    shown = [item for item in shown if is_rendered(item, layer)]
    if content is None:
        found = _inside(layer, hull)
        shown = [item for item in shown if item in found]
        remedy = "put it around what it shall show, or choose the content: a collection, or * for everything"
        complaint = f"object '{hull.name}' has nothing inside it: {remedy}"
    elif content == EVERYTHING:
        complaint = (
            f"object '{hull.name}' is alone in the scene, and would show nothing: add what it shall show"
        )
    else:
        named = bpy.data.collections.get(content)
        if named is None:
            raise InputError(f"there is no collection '{content}': name one that holds what the hull shows")
        members = set(named.all_objects)
        shown = [item for item in shown if item in members]
        complaint = f"collection '{content}' has nothing that renders: add what '{hull.name}' shall show"
    if not shown:
        raise InputError(complaint)
    return tuple(sorted(shown, key=lambda item: item.name))


def show_content_only(
    scratch: bpy.types.Scene, hull: bpy.types.Object, content: str | None
) -> tuple[str, ...]:
    """Remove `hull` from a scratch scene, hide all but its content from cameras; return the content's names.

    Hidden objects still cast shadows and light, and appear in the content's reflections. With EVERYTHING no
    object is hidden, no name is returned, and the world is seen too; else the film is transparent. Raises
    InputError as `find_content` does.
    """
    layer = next(layer for layer in scratch.view_layers if layer.use)
    found = set(find_content(layer, hull, content))
    rest = [item for item in layer.objects if item != hull and item not in found and is_rendered(item, layer)]
    holdouts = {item for item in layer.objects if item.holdout_get(view_layer=layer)}
    indirect = {item for item in layer.objects if item.indirect_only_get(view_layer=layer)}
    everything = content == EVERYTHING
    settings = regroup(
        scratch,
        {
            "RadTex content": [item for item in found if item not in holdouts | indirect],
            "RadTex holdouts": [item for item in found if item in holdouts],
            "RadTex others": [*rest, *(item for item in found if item in indirect)],
        },
    )
    settings["RadTex holdouts"].holdout = settings["RadTex others"].indirect_only = True
    if not everything:
        scratch.render.film_transparent = True
    layer.update()
    return () if everything else tuple(sorted(item.name for item in found))


def _inside(layer: bpy.types.ViewLayer, hull: bpy.types.Object) -> set[bpy.types.Object]:
    """The objects that lie in the hull's box; an object's box includes the instances that it makes."""
    boxes: dict[bpy.types.Object, Bounds] = {}
    for owner, (low, high) in _boxes(layer):
        least, most = boxes.get(owner, (low, high))
        boxes[owner] = np.minimum(low, least), np.maximum(high, most)
    boxes.pop(hull, None)
    low, high = world_box(hull, about_matrix(hull, layer))
    slack = _SLACK * float(np.max(high - low))
    return {owner for owner, box in boxes.items() if _share(box, (low - slack, high + slack)) >= _LEAST}


def _boxes(layer: bpy.types.ViewLayer) -> Iterator[tuple[bpy.types.Object, Bounds]]:
    """Objects with their boxes, or that of an instance they make; those hidden in viewports without these."""
    graph = cast(bpy.types.Depsgraph, layer.depsgraph)
    for item in layer.objects:
        if not cast(Any, item.evaluated_get(graph)).is_evaluated and item.type != "EMPTY":
            yield item, world_box(item, about_matrix(item, layer))
    for instance in graph.object_instances:
        owner = instance.parent if instance.is_instance and instance.parent else instance.object
        box = world_box(instance.object, instance.matrix_world)
        if instance.object.type != "EMPTY" and np.isfinite(box).all():
            yield cast(bpy.types.Object, owner.original), box


def _share(box: Bounds, hull: Bounds) -> float:
    """The share of a box's volume in the hull's box; a side of length 0 counts as in or out."""
    size = box[1] - box[0]
    common = np.minimum(box[1], hull[1]) - np.maximum(box[0], hull[0])
    parts = np.where(size > 0, np.clip(common, 0, None) / np.where(size > 0, size, 1), common >= 0)
    return float(np.prod(parts))
