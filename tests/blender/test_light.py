# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene is called dark where nothing in it could shine, and only there."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import bpy
import pytest

from radtex_addon.scene.lights.light import is_dark
from tests.blender import stage

context: Any = bpy.context  # to the stubs, every pointer may be None
BEFORE_5 = bpy.app.version < (5, 0, 0)


def dark() -> bool:
    return is_dark(context.scene, context.scene.view_layers[0])


def card(material: bpy.types.Material | None = None) -> Any:
    bpy.ops.mesh.primitive_plane_add()
    if material is not None:
        context.object.data.materials.append(material)
    return context.object


def emission(**inputs: object) -> bpy.types.Material:
    return stage.material("glow", "ShaderNodeEmission", **inputs)


def lamp(energy: float) -> Any:
    bpy.ops.object.light_add(type="POINT")
    context.object.data.energy = energy
    return context.object


def strength_from_a_node() -> None:
    material = emission(Strength=0.0)
    tree = material.node_tree
    value = tree.nodes.new("ShaderNodeValue")
    tree.links.new(value.outputs[0], next(n for n in tree.nodes if n.type == "EMISSION").inputs["Strength"])
    card(material)


def glow_in_a_group() -> None:
    inner: Any = bpy.data.node_groups.new("glow", "ShaderNodeTree")
    inner.interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
    shader, end = inner.nodes.new("ShaderNodeEmission"), inner.nodes.new("NodeGroupOutput")
    inner.links.new(shader.outputs[0], end.inputs[0])
    material = stage.material("group", "ShaderNodeBsdfDiffuse")
    tree: Any = material.node_tree
    group = tree.nodes.new("ShaderNodeGroup")
    group.node_tree = inner
    output = next(node for node in tree.nodes if node.type == "OUTPUT_MATERIAL")
    tree.links.new(group.outputs[0], output.inputs["Surface"])
    card(material)


def world_of_emission() -> None:
    tree: Any = stage.world((0, 0, 0)).node_tree
    output = next(node for node in tree.nodes if node.type == "OUTPUT_WORLD")
    tree.links.new(tree.nodes.new("ShaderNodeEmission").outputs[0], output.inputs["Surface"])


def instances_of_a_collection() -> None:
    bpy.ops.object.empty_add()
    context.object.instance_type = "COLLECTION"


LIT: dict[str, Callable[[], object]] = {
    "a lamp": lambda: lamp(10.0),
    "a world": lambda: stage.world((0, 0, 0.1)),
    "an HDRI": lambda: stage.hdri(stage.world((0, 0, 0))),
    "a world of emission": world_of_emission,
    "an emitter": lambda: card(emission()),
    "a glowing Principled": lambda: card(
        stage.material("p", "ShaderNodeBsdfPrincipled", Emission_Strength=1.0, Emission_Color=(1, 1, 1, 1))
    ),
    "a fire": lambda: card(stage.material("v", "ShaderNodeVolumePrincipled", Blackbody_Intensity=1.0)),
    "a strength that a node sets": strength_from_a_node,
    "a glow in a group": glow_in_a_group,
    "who knows what is instanced": instances_of_a_collection,
}


@pytest.mark.parametrize("name", LIT)
def test_what_may_shine_is_light(name: str) -> None:
    card(stage.material("grey", "ShaderNodeBsdfDiffuse"))
    assert dark()
    LIT[name]()
    assert not dark()


def hide(item: Any) -> None:
    item.hide_render = True


def loose_emission() -> None:
    material = stage.material("grey", "ShaderNodeBsdfDiffuse")
    material.node_tree.nodes.new("ShaderNodeEmission")
    card(material)


def excluded_lamp() -> None:
    item = lamp(10)
    shelf = bpy.data.collections.new("shelf")
    context.scene.collection.children.link(shelf)
    shelf.objects.link(item)
    context.scene.collection.objects.unlink(item)
    context.scene.view_layers[0].layer_collection.children["shelf"].exclude = True
    context.scene.view_layers[0].update()


DARK: dict[str, Callable[[], object]] = {
    "nothing": lambda: None,
    "a black world": lambda: stage.world((0, 0, 0)),
    "a lamp that is off": lambda: lamp(0.0),
    "a lamp hidden from render": lambda: hide(lamp(10.0)),
    "a lamp that the view layer leaves out": excluded_lamp,
    "an emitter hidden from render": lambda: hide(card(emission())),
    "an emitter without strength": lambda: card(emission(Strength=0.0)),
    "a black emitter": lambda: card(emission(Color=(0, 0, 0, 1))),
    "an emitter that leads nowhere": loose_emission,
    "an emitting material that nothing wears": emission,
    "a slot without material": lambda: card().data.materials.append(None),
    "a Principled as it comes": lambda: card(stage.material("p", "ShaderNodeBsdfPrincipled")),
}


@pytest.mark.parametrize("name", DARK)
def test_what_cannot_shine_is_none(name: str) -> None:
    DARK[name]()
    assert dark()


@pytest.mark.skipif(not BEFORE_5, reason="Blender 5 always uses nodes")
def test_before_blender_5_nodes_may_be_off() -> None:
    glowing = card(emission())
    glowing.active_material.use_nodes = False
    assert dark(), "its nodes are there, but unused"
    world = stage.world((1, 1, 1))
    world.use_nodes = False
    world.color = (0, 0, 0)
    assert dark()
    world.color = (0, 0.2, 0)
    assert not dark()


def test_an_object_that_was_just_removed_is_no_light() -> None:
    lamp(100.0)
    bpy.data.objects.remove(context.object)
    assert dark()
