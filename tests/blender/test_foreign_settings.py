# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of a user's scene that must not change what a bake measures, each against a bake without it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.formats.containers.exr import read_atlas
from radtex_addon.forms.layered.files.layered_files import read_layered
from radtex_addon.job import bake_object, check_request
from radtex_addon.scene.scratch import scratch_scene
from radtex_addon.settings.spec import BakeSpec, Layout
from tests.blender import stage

pytestmark = pytest.mark.usefixtures("temporary")
context: Any = bpy.context  # to the stubs, every pointer may be None

SPEC = BakeSpec(texels=8, bucket=4, samples=4, half=False, uv_layer="UVMap")
LAYERED = replace(SPEC, layout=Layout.LAYERED, texels=16, bucket=14, samples=1)


def lit_cube(shader: str = "ShaderNodeBsdfDiffuse", floor: bool = True) -> Any:
    """A cube "Body", perhaps above a floor, under two lamps and a dim world."""
    stage.world((0.3, 0.4, 0.5))
    stage.lamps()
    if floor:
        bpy.ops.mesh.primitive_plane_add(size=6, location=(0, 0, -1))
        blue = stage.material("floor", "ShaderNodeBsdfDiffuse", Color=(0.2, 0.5, 0.8, 1))
        context.object.data.materials.append(blue)
    bpy.ops.mesh.primitive_cube_add(size=1)
    context.object.name = "Body"
    context.object.data.materials.append(stage.material("body", shader, Color=(0.8, 0.6, 0.4, 1)))
    return context.object


def baked(out: Path, spec: BakeSpec = SPEC, scene: bpy.types.Scene | None = None) -> Floats:
    """The atlas's pixels."""
    result = bake_object(scene or context.scene, "Body", spec, out, overwrite=True)
    return read_atlas(result.files.atlas)[0]


def test_path_guiding_is_off_for_it_darkens_what_portals_show(out: Path) -> None:
    lit_cube()
    spec = replace(SPEC, texels=32, bucket=8)  # in smaller pictures nothing is learnt
    plain = baked(out, spec)
    context.scene.cycles.use_guiding = True
    np.testing.assert_array_equal(baked(out, spec), plain)


def test_a_grease_pencil_drawing_leaves_every_bit(out: Path) -> None:
    """Blender would draw it over each picture on the GPU, whose half floats round the light."""
    lit_cube()
    plain = baked(out)
    bpy.ops.object.grease_pencil_add(type="STROKE", location=(3, 0, 0))
    np.testing.assert_array_equal(baked(out), plain)
    assert context.view_layer.use_grease_pencil


def test_a_view_layers_own_world_is_the_scenes() -> None:
    lit_cube()
    own = context.scene.world
    context.view_layer.world_override = other = stage.world((1, 0.5, 0.2))
    context.scene.world = own
    with scratch_scene(context.scene) as scratch:
        assert scratch.world == other
        assert [layer.world_override for layer in scratch.view_layers] == [None]
    assert (context.scene.world, context.view_layer.world_override) == (own, other)


def test_the_layered_layout_knows_an_objects_random_number(out: Path) -> None:
    """Cycles makes it of the object's name: the copy that tells where paths end must have the same."""
    body = lit_cube("ShaderNodeEmission", floor=False)
    glow = body.data.materials[0].node_tree
    glow.links.new(glow.nodes.new("ShaderNodeObjectInfo").outputs["Random"], glow.nodes[0].inputs["Color"])
    number = float(baked(out)[0, 0, 0])
    shiny = body.data.materials[0] = stage.material("shiny", "ShaderNodeBsdfAnisotropic", Roughness=0.1)
    shader, found = shiny.node_tree.nodes[0], []
    shader.inputs["Color"].default_value = (number, number, number, 1)
    for _ in range(2):
        result = bake_object(context.scene, "Body", LAYERED, out, overwrite=True)
        found.append(read_layered(result.files.sidecar)[0].materials[0].weight)
        info = shiny.node_tree.nodes.new("ShaderNodeObjectInfo")
        shiny.node_tree.links.new(info.outputs["Random"], shader.inputs["Color"])
    assert found[0].max() > 0.1
    np.testing.assert_allclose(found[1], found[0], atol=1e-3)
    assert body.name == "Body"
    assert "Body" in bpy.data.objects


def node_group(name: str) -> Any:
    """A geometry node group that moves nothing yet: input, Set Position, output."""
    group: Any = bpy.data.node_groups.new(name, "GeometryNodeTree")
    group.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
    group.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    start, end = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
    move = group.nodes.new("GeometryNodeSetPosition")
    group.links.new(start.outputs[0], move.inputs["Geometry"])
    group.links.new(move.outputs[0], end.inputs[0])
    return group


def test_what_follows_the_active_camera_is_told(out: Path) -> None:
    body = lit_cube()
    group = node_group("Facing")
    body.modifiers.new("Face", "NODES").node_group = group
    assert check_request(context.scene, "Body", SPEC, out, False, False) == []
    camera, place = (group.nodes.new(f"GeometryNode{name}") for name in ("InputActiveCamera", "ObjectInfo"))
    group.links.new(camera.outputs[0], place.inputs["Object"])
    (told,) = check_request(context.scene, "Body", SPEC, out, False, False)
    assert str(told).startswith(
        "object 'Body' follows the active camera by its modifier 'Face', and a bake has"
    )
    outer = node_group("Outer")
    outer.nodes.new("GeometryNodeGroup").node_tree = group
    body.modifiers["Face"].node_group = outer
    assert check_request(context.scene, "Body", SPEC, out, False, False) == [told]
    body.modifiers["Face"].show_render = False
    assert check_request(context.scene, "Body", SPEC, out, False, False) == []


def test_a_scene_that_is_not_open_is_baked_at_its_own_frame(out: Path) -> None:
    body = lit_cube("ShaderNodeEmission")
    strength = body.data.materials[0].node_tree.nodes["Emission"].inputs["Strength"]
    for frame in (1, 11):
        strength.default_value = frame
        strength.keyframe_insert("default_value", frame=frame)
    scene = context.scene
    scene.frame_set(11)
    here = baked(out)
    context.window.scene = other = bpy.data.scenes.new("Other")
    np.testing.assert_array_equal(baked(out, scene=scene), here)
    assert (context.scene, other.frame_current, scene.frame_current) == (other, 1, 11)
