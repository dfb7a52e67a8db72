# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Find volumes around an object: rays that a portal sends into a volume are traced as if outside it."""

from __future__ import annotations

import bpy

from ..objects import about_matrix, is_rendered, world_box

_OUTPUTS = ("OUTPUT_MATERIAL", "OUTPUT_WORLD")


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
