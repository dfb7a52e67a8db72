# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene is called dark where nothing in it could shine, and only there; what cannot shine is refused."""

from __future__ import annotations

from collections.abc import Callable
from math import inf, nan
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.core.errors import BakeError, InputError
from radtex_addon.cycles.passes import finite_light
from radtex_addon.forms.layered.files.layered_files import read_layered
from radtex_addon.job import bake_object, check_request
from radtex_addon.scene.checks.finite_light import refuse_unfinite_light
from radtex_addon.scene.lights.light import is_dark
from radtex_addon.settings.spec import BakeSpec, Layout
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


def linked(strength: Callable[[Any], Any]) -> None:
    """A card whose glow has the strength that nodes compute."""
    material = emission()
    tree: Any = material.node_tree
    made = next(node for node in tree.nodes if node.type == "EMISSION")
    tree.links.new(strength(tree), made.inputs["Strength"])
    card(material)


def number(tree: Any, value: float) -> Any:
    node = tree.nodes.new("ShaderNodeValue")
    node.outputs[0].default_value = value
    return node.outputs[0]


def computed(tree: Any, operation: str, *values: float) -> Any:
    node = tree.nodes.new("ShaderNodeMath")
    node.operation = operation
    for socket, value in zip(node.inputs, values, strict=False):
        socket.default_value = value
    return node.outputs[0]


def lit_world(strength: float, colour: float = 1) -> None:
    stage.world((colour, 1, 1))
    background = next(node for node in context.scene.world.node_tree.nodes if node.type == "BACKGROUND")
    background.inputs["Strength"].default_value = strength


def red_lamp(red: float) -> None:
    lamp(1).data.color = (red, 1, 1)


def instanced_lamp(energy: float) -> None:
    """Of a collection that is in the scene as an instance alone."""
    hidden = bpy.data.collections.new("Lamps")
    hidden.objects.link(bpy.data.objects.new("Far", bpy.data.lights.new("Far", "POINT")))
    hidden.objects[0].data.energy = energy
    empty = bpy.data.objects.new("Empty", None)
    empty.instance_type, empty.instance_collection = "COLLECTION", hidden
    context.scene.collection.objects.link(empty)


UNFINITE: dict[str, tuple[Callable[[], object], str]] = {
    "a glow": (
        lambda: card(emission(Strength=inf)),
        "material 'glow': Strength of its node 'Emission' is inf",
    ),
    "a glow that is no number": (
        lambda: card(emission(Strength=nan)),
        "material 'glow': Strength of its node 'Emission' is not a number, and Cycles drops such light: give",
    ),
    "a node's number": (
        lambda: linked(lambda tree: number(tree, inf)),
        "Strength of its node 'Emission' is inf",
    ),
    "a product": (
        lambda: linked(lambda tree: computed(tree, "MULTIPLY", 1e25, 1e25)),
        "Strength of its node 'Emission' is infinite",
    ),
    "a power": (
        lambda: linked(lambda tree: computed(tree, "POWER", 1e30, 30)),
        "Strength of its node 'Emission' is infinite",
    ),
    "a colour": (
        lambda: card(stage.material("Red", "ShaderNodeBsdfPrincipled", Base_Color=(nan, 0.5, 0.5, 1))),
        "material 'Red': Base Color of its node 'Principled BSDF' is not a number",
    ),
    "a world": (lambda: lit_world(nan), "world 'World': Strength of its node 'Background' is not a number"),
    "a world's colour": (lambda: lit_world(1, nan), "world 'World': Color of its node 'Background' is not a"),
    "a lamp": (
        lambda: lamp(inf),
        "lamp 'Point': its strength is infinite, and Cycles drops such light",
    ),
    "a lamp's colour": (lambda: red_lamp(nan), "lamp 'Point': its colour is not a number"),
    "an instanced lamp": (lambda: instanced_lamp(inf), "lamp 'Far': its strength is infinite"),
}


@pytest.mark.parametrize("name", UNFINITE)
def test_light_that_is_no_number_is_refused_by_name(name: str, tmp_path: Path) -> None:
    """Where Cycles shows black there, or drops the light of other lamps with it."""
    make, words = UNFINITE[name]
    make()
    card().name = "Baked"
    with pytest.raises(InputError, match=words) as refused:
        check_request(context.scene, "Baked", BakeSpec(samples=1), tmp_path, False, False)
    assert "\n" not in str(refused.value)


FINITE: dict[str, Callable[[], object]] = {
    "a division by 0": lambda: linked(lambda tree: computed(tree, "DIVIDE", 1, 0)),
    "a root of a number below 0": lambda: linked(lambda tree: computed(tree, "POWER", -2, 0.5)),
    "a strong lamp": lambda: lamp(1e12),
    "a lamp that is hidden": lambda: setattr(lamp(inf), "hide_render", True),
    "a node that nothing uses": lambda: number(stage.world().node_tree, nan),
    "a limit that is no light": lambda: computed(stage.world().node_tree, "MAXIMUM", 3e38),
}


@pytest.mark.parametrize("name", FINITE)
def test_what_cycles_shows_all_the_same_is_not_refused(name: str) -> None:
    FINITE[name]()
    refuse_unfinite_light(context.scene, context.scene.view_layers[0])


@pytest.mark.one_blender
@pytest.mark.parametrize("layout", Layout)
def test_a_bake_without_any_light_says_so(
    layout: Layout, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """Of a world whose nodes are not followed: Cycles drops the light of e to the power of a thousand."""
    tree: Any = stage.world().node_tree
    background = next(node for node in tree.nodes if node.type == "BACKGROUND")
    tree.links.new(computed(tree, "EXPONENT", 1000), background.inputs["Strength"])
    card(stage.material("White", "ShaderNodeBsdfDiffuse")).name = "Baked"
    spec = BakeSpec(layout=layout, texels=8, samples=1, uv_layer="UVMap")
    bake_object(context.scene, "Baked", spec, tmp_path / "out")
    assert "no light at all comes from 'Baked': its bake is black. If lamps or the world" in caplog.text


@pytest.mark.one_blender
def test_light_of_which_much_is_infinite_fails() -> None:
    """A few such pixels, which faulty shaders make, are black as in Cycles."""
    light = np.ones((40, 10, 3), dtype=np.float32)
    light[0, 0], light[1, 1, 2], light[2, 2] = inf, nan, 1e38
    found = finite_light(light)
    assert found[[0, 1, 2], [0, 1, 2]].max() == 0
    assert found.sum() == 3 * 397
    light[3] = inf
    with pytest.raises(BakeError, match=r"^3% of the light that Cycles found is not a finite number"):
        finite_light(light)


@pytest.mark.one_blender
def test_pixels_of_the_world_that_are_no_numbers_spoil_no_bake(tmp_path: Path) -> None:
    """Cycles drops their light, and shows all else."""
    image: Any = bpy.data.images.new("Sky", 64, 32, float_buffer=True)
    pixels = np.full((32, 64, 4), 0.5, dtype=np.float32)
    pixels[..., 3], pixels[24, 20, :3], pixels[12, 40, :3] = 1, inf, 1e38
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    made: Any = stage.world()
    made.cycles.sampling_method, made.cycles.sample_map_resolution = "MANUAL", 64  # as fine as the picture
    tree: Any = made.node_tree
    environment = tree.nodes.new("ShaderNodeTexEnvironment")
    environment.image = image
    background = next(node for node in tree.nodes if node.type == "BACKGROUND")
    tree.links.new(environment.outputs["Color"], background.inputs["Color"])
    card(stage.material("Mirror", "ShaderNodeBsdfGlossy", Roughness=0.3)).name = "Baked"
    spec = BakeSpec(layout=Layout.LAYERED, texels=8, samples=1, uv_layer="UVMap")
    sidecar = bake_object(context.scene, "Baked", spec, tmp_path / "out").files.sidecar
    atlas, _ = read_layered(sidecar)
    for values in (atlas.colour, atlas.irradiance, atlas.own, atlas.rest, *atlas.around.world.levels):
        assert np.isfinite(values).all()
    assert np.median(atlas.around.world.levels[0]) == pytest.approx(0.5, abs=0.01)
