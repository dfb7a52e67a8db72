# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects that a camera sees through, told without a render, and refused where their light is baked."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.core.errors import InputError
from radtex_addon.formats.containers.exr import read_buckets
from radtex_addon.job import bake_object, check_request
from radtex_addon.scene.checks.see_through import is_see_through, why_no_surface
from radtex_addon.settings.spec import BakeSpec, Kind, Layout
from tests.blender import stage

pytestmark = pytest.mark.usefixtures("temporary")
context: Any = bpy.context  # to the stubs, every pointer may be None
ANY_RAY = ("Is Shadow Ray", "Is Diffuse Ray", "Is Glossy Ray", "Is Transmission Ray")


def principled(**inputs: object) -> Any:
    return stage.material("Principled", "ShaderNodeBsdfPrincipled", **inputs)


def mixed(first: str, second: str, share: float | None = None, ray: str = "") -> Any:
    """Two shaders, mixed by a number, by a light path, or by a texture."""
    made: Any = stage.material("Mixed", "ShaderNodeMixShader")
    tree = made.node_tree
    mix = next(node for node in tree.nodes if node.type == "MIX_SHADER")
    for place, kind in enumerate((first, second), start=1):
        tree.links.new(tree.nodes.new(kind).outputs[0], mix.inputs[place])
    if share is not None:
        mix.inputs[0].default_value = share
    elif ray:
        tree.links.new(tree.nodes.new("ShaderNodeLightPath").outputs[ray], mix.inputs[0])
    else:
        tree.links.new(tree.nodes.new("ShaderNodeTexChecker").outputs["Fac"], mix.inputs[0])
    return made


def textured() -> Any:
    made = principled()
    tree = made.node_tree
    shader = next(node for node in tree.nodes if node.type == "BSDF_PRINCIPLED")
    tree.links.new(tree.nodes.new("ShaderNodeTexChecker").outputs["Fac"], shader.inputs["Alpha"])
    return made


def behind(kind: str, shader: str = "ShaderNodeBsdfTransparent") -> Any:
    """A shader behind a reroute, a muted node or a group."""
    made = principled()
    tree = made.node_tree
    output = next(node for node in tree.nodes if node.type == "OUTPUT_MATERIAL")
    if kind == "group":
        inner = bpy.data.node_groups.new("Inner", "ShaderNodeTree")
        interface: Any = inner.interface
        interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
        inner.links.new(inner.nodes.new(shader).outputs[0], inner.nodes.new("NodeGroupOutput").inputs[0])
        node = tree.nodes.new("ShaderNodeGroup")
        node.node_tree = inner
    else:
        node = tree.nodes.new("NodeReroute" if kind == "reroute" else "ShaderNodeMixShader")
        tree.links.new(tree.nodes.new(shader).outputs[0], node.inputs[0 if kind == "reroute" else 1])
        node.mute = kind == "muted"
    tree.links.new(node.outputs[0], output.inputs["Surface"])
    return made


def unlinked() -> Any:
    """A transparent shader that leads nowhere."""
    made = principled()
    made.node_tree.nodes.new("ShaderNodeBsdfTransparent")
    return made


def in_group(alpha: float) -> Any:
    """A Principled BSDF in a group, whose alpha is the group's input."""
    made = behind("group", "ShaderNodeBsdfPrincipled")
    node = next(one for one in made.node_tree.nodes if one.type == "GROUP")
    inner = node.node_tree
    inner.interface.new_socket("Alpha", in_out="INPUT", socket_type="NodeSocketFloat")
    shader = next(one for one in inner.nodes if one.type == "BSDF_PRINCIPLED")
    inner.links.new(inner.nodes.new("NodeGroupInput").outputs["Alpha"], shader.inputs["Alpha"])
    node.inputs["Alpha"].default_value = alpha
    return made


CLEAR, GLASS, MATT = "ShaderNodeBsdfTransparent", "ShaderNodeBsdfGlass", "ShaderNodeBsdfDiffuse"
MATERIALS: dict[str, tuple[Callable[[], Any], bool]] = {
    "opaque": (principled, False),
    "glass": (lambda: stage.material("Glass", GLASS), False),
    "alpha of a half": (lambda: principled(Alpha=0.5), True),
    "alpha from a texture": (textured, True),
    "transparent": (lambda: stage.material("Clear", CLEAR), True),
    "holdout": (lambda: stage.material("Hole", "ShaderNodeHoldout"), True),
    "mixed by a texture": (lambda: mixed(MATT, CLEAR), True),
    "mixed, wholly matt": (lambda: mixed(MATT, CLEAR, share=0.0), False),
    "mixed, wholly clear": (lambda: mixed(MATT, CLEAR, share=1.0), True),
    "clear to cameras": (lambda: mixed(MATT, CLEAR, ray="Is Camera Ray"), True),
    **{f"glass but for {ray}": (lambda ray=ray: mixed(GLASS, CLEAR, ray=ray), False) for ray in ANY_RAY},  # type: ignore[misc]
    "behind a reroute": (lambda: behind("reroute"), True),
    "behind a muted node": (lambda: behind("muted"), True),
    "in a group": (lambda: behind("group"), True),
    "a group's alpha of a half": (lambda: in_group(0.5), True),
    "a group's alpha of one": (lambda: in_group(1.0), False),
    "linked to nothing": (unlinked, False),
}


@pytest.mark.parametrize("case", MATERIALS)
def test_materials_are_judged_by_what_cameras_meet(case: str) -> None:
    make, clear = MATERIALS[case]
    assert is_see_through(make()) is clear


def plane(*materials: Any) -> Any:
    bpy.ops.mesh.primitive_plane_add(size=2)
    for one in materials:
        context.object.data.materials.append(one)
    return context.object


def with_volume() -> Any:
    made = principled()
    tree = made.node_tree
    output = next(node for node in tree.nodes if node.type == "OUTPUT_MATERIAL")
    tree.links.new(tree.nodes.new("ShaderNodeVolumeScatter").outputs[0], output.inputs["Volume"])
    return made


def grown() -> Any:
    item = plane()
    item.modifiers.new("Fur", "PARTICLE_SYSTEM").particle_system.settings.type = "HAIR"
    return item


def curved() -> Any:
    item = plane()
    curves: Any = bpy.data.hair_curves.new("Tufts")
    curves.surface = item
    context.scene.collection.objects.link(bpy.data.objects.new("Tufts", curves))
    return item


def by_nodes() -> Any:
    """A plane whose geometry nodes make it of another material than its slot's."""
    item = plane(principled())
    tree: Any = bpy.data.node_groups.new("BakeOutput", "GeometryNodeTree")
    node = tree.nodes.new("GeometryNodeSetMaterial")
    node.inputs["Material"].default_value = stage.material("Veil", CLEAR)
    item.modifiers.new("BakeOutput", "NODES").node_group = tree
    return item


def by_input() -> Any:
    """The same by an input of the modifier."""
    item = plane(principled())
    tree: Any = bpy.data.node_groups.new("BakeOutput", "GeometryNodeTree")
    socket = tree.interface.new_socket("Cloth", in_out="INPUT", socket_type="NodeSocketMaterial")
    socket.default_value = stage.material("Veil", CLEAR)
    item.modifiers.new("BakeOutput", "NODES").node_group = tree
    return item


def through_glass(film: bool) -> Any:
    context.scene.render.film_transparent = film
    context.scene.cycles.film_transparent_glass = True
    return plane(principled(Transmission_Weight=1.0))


BY_NODES = "its material 'Veil', set by geometry nodes, lets through what is behind it"
OBJECTS: dict[str, tuple[Callable[[], Any], str]] = {
    "opaque": (lambda: plane(principled()), ""),
    "without a material": (plane, ""),
    "the second of its materials": (
        lambda: plane(principled(), stage.material("Veil", CLEAR)),
        "",
    ),
    "a volume": (lambda: plane(with_volume()), "its material 'Principled' has a volume"),
    "particle hair": (grown, "it has hair, 'Fur'"),
    "hair curves": (curved, "it has hair, 'Tufts'"),
    "geometry nodes": (by_nodes, BY_NODES),
    "an input of geometry nodes": (by_input, BY_NODES),
    "glass before a film": (lambda: through_glass(film=False), ""),
    "glass that a film shows through": (
        lambda: through_glass(film=True),
        "its material 'Principled' is glass, which the transparent film makes clear",
    ),
}


@pytest.mark.parametrize("case", OBJECTS)
def test_an_object_says_why(case: str) -> None:
    make, reason = OBJECTS[case]
    assert why_no_surface(context.scene, make()) == reason


def test_hair_that_does_not_render_is_none() -> None:
    item = grown()
    item.modifiers["Fur"].show_render = False
    assert why_no_surface(context.scene, item) == ""
    other = curved()
    bpy.data.objects["Tufts"].hide_render = True
    assert why_no_surface(context.scene, other) == ""


TINY = BakeSpec(texels=16, bucket=2, samples=1, half=False)


def card() -> Any:
    """A plane that glows, in a collection "Inner" of a collection "Home"."""
    bpy.ops.mesh.primitive_plane_add(size=2)
    made = context.object
    made.name = "Card"
    made.data.materials.append(stage.material("Glow", "ShaderNodeEmission", Color=(1, 1, 1, 1)))
    home, inner = bpy.data.collections.new("Home"), bpy.data.collections.new("Inner")
    context.scene.collection.children.link(home)
    home.children.link(inner)
    inner.objects.link(made)
    context.scene.collection.objects.unlink(made)
    stage.world()
    return made


def home() -> Any:
    return context.view_layer.layer_collection.children["Home"]


def no_camera(item: Any) -> None:
    item.visible_camera = False


def catcher(item: Any) -> None:
    item.is_shadow_catcher = True


def holdout(item: Any) -> None:
    item.is_holdout = True


def held_out(_: Any) -> None:
    home().children["Inner"].holdout = True


def indirect(_: Any) -> None:
    home().children["Inner"].indirect_only = True


UNSEEN = [
    (no_camera, r"cameras do not see it; enable Ray Visibility > Camera \(Object Properties > Visibility\)"),
    (catcher, "it is a shadow catcher; disable that"),
    (holdout, "it is a holdout; disable that"),
    (held_out, "in view layer 'ViewLayer' Holdout of its collection 'Inner' is on; disable that"),
    (indirect, "in view layer 'ViewLayer' Indirect Only of its collection 'Inner' is on; disable that"),
]


@pytest.mark.parametrize(
    "spec",
    [TINY, replace(TINY, layout=Layout.LAYERED, bucket=14), replace(TINY, kind=Kind.TRANSFER, bucket=3)],
    ids=["plain", "layered", "transfer"],
)
@pytest.mark.parametrize(("hide", "words"), UNSEEN)
def test_what_cameras_see_through_is_refused(
    hide: Callable[[Any], None], words: str, spec: BakeSpec, out: Path
) -> None:
    item = card()
    hide(item)
    context.view_layer.update()
    with pytest.raises(InputError, match=f"^a bake of object 'Card' would be see-through: {words}"):
        bake_object(context.scene, "Card", spec, out)
    assert not out.exists()


@pytest.mark.one_blender
@pytest.mark.parametrize("kind", [Kind.INCIDENT, Kind.REFLECTION, Kind.AO, Kind.SHADOW])
@pytest.mark.parametrize(("hide", "_words"), UNSEEN)
def test_what_asks_no_camera_is_baked_all_the_same(
    hide: Callable[[Any], None], _words: str, kind: Kind, out: Path
) -> None:
    hide(card())
    context.view_layer.update()
    check_request(
        context.scene, "Card", replace(TINY, kind=kind, half=True), out, preview=False, overwrite=False
    )


def test_a_hull_need_not_be_seen_and_neither_need_who_wears_another_s_light(out: Path) -> None:
    item = card()
    bpy.ops.mesh.primitive_cube_add(size=4)
    context.object.name, context.object.visible_camera = "Hull", False
    hull = replace(TINY, kind=Kind.PROXY)
    made = bake_object(context.scene, "Hull", hull, out).files.sidecar
    assert read_buckets(made)[0][..., 0].max() == pytest.approx(1)
    worn = replace(TINY, texels=24, source="Card", extrusion=5.0)
    made = bake_object(context.scene, "Hull", worn, out).files.sidecar
    np.testing.assert_allclose(read_buckets(made)[0][..., :3].max(), 1)
    item.is_shadow_catcher = True
    with pytest.raises(InputError, match="a bake of object 'Card' would be see-through: it is a shadow catc"):
        bake_object(context.scene, "Hull", worn, out, overwrite=True)


def test_a_frame_is_asked_for_what_is_seen_then(out: Path) -> None:
    item = card()
    for frame, seen in ((1, True), (2, False)):
        item.visible_camera = seen
        item.keyframe_insert("visible_camera", frame=frame)
    context.scene.frame_set(2)
    made = bake_object(context.scene, "Card", replace(TINY, frame=1), out).files.sidecar
    np.testing.assert_allclose(read_buckets(made)[0], 1)
    context.scene.frame_set(1)
    with pytest.raises(InputError, match="a bake of object 'Card' would be see-through: cameras do not see"):
        bake_object(context.scene, "Card", replace(TINY, frame=2), out)
