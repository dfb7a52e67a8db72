# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Volumes around the baked object are named before the bake."""

from __future__ import annotations

import bpy

from radtex_addon.scene.checks.enclosing_volumes import volumes_around
from tests.blender import stage


def cube(size: float, place: tuple[float, float, float], volume: bool) -> bpy.types.Object:
    bpy.ops.mesh.primitive_cube_add(size=size, location=place)
    item = bpy.context.object
    assert item is not None
    made = stage.material("m", "ShaderNodeBsdfDiffuse")
    if volume:
        tree = made.node_tree
        output = next(node for node in tree.nodes if node.type == "OUTPUT_MATERIAL")
        tree.links.new(tree.nodes.new("ShaderNodeVolumePrincipled").outputs[0], output.inputs["Volume"])
    item.data.materials.append(made)
    return item


def test_only_rendered_volumes_that_reach_the_object_are_named() -> None:
    baked = cube(1, (0, 0, 0), volume=True)  # its own volume begins behind its surface
    cube(4, (0.5, 0, 0), volume=True).name = "Fog"
    cube(1, (5, 0, 0), volume=True).name = "Far"
    cube(4, (0, 0, 0), volume=False).name = "Solid"
    hidden = cube(4, (0, 0, 0), volume=True)
    hidden.hide_render = True
    layer = bpy.context.view_layer
    assert layer is not None
    layer.update()
    assert volumes_around(layer, baked) == ["Fog"]
