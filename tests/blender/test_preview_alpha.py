# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What is partly clear: a preview lets through what the atlas does, and not its own far side once more."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
import numpy as np
import PIL.Image
import pytest

from radtex_addon.bake.spec import BakeSpec
from radtex_addon.core.sampler import Filter
from radtex_addon.job import bake_object
from radtex_addon.preview.picture import render_picture
from radtex_addon.scene.mesh.watertight import is_closed
from tests.blender import stage

pytestmark = pytest.mark.usefixtures("temporary")
context: Any = bpy.context  # to the stubs, every pointer may be None

HALF = 0.5


def half_clear(name: str) -> Any:
    """Green light of 0.5, and half of what is behind."""
    made: Any = stage.material(name, "ShaderNodeAddShader")
    tree = made.node_tree
    adding = next(node for node in tree.nodes if node.type == "ADD_SHADER")
    light, clear = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeBsdfTransparent")
    light.inputs["Color"].default_value = (0, HALF, 0, 1)
    clear.inputs["Color"].default_value = (HALF, HALF, HALF, 1)
    tree.links.new(light.outputs[0], adding.inputs[0])
    tree.links.new(clear.outputs[0], adding.inputs[1])
    return made


def test_a_preview_shows_the_far_side_once(out: Path) -> None:
    stage.world((1, 0, 0))
    bpy.ops.mesh.primitive_uv_sphere_add(segments=32, ring_count=16)
    ball: Any = context.object
    ball.name = "Ball"
    ball.data.materials.append(half_clear("Half"))
    bpy.ops.object.camera_add(location=(0, -6, 0), rotation=(np.pi / 2, 0, 0))
    context.scene.camera = context.object
    context.scene.view_settings.view_transform = "Raw"
    context.scene.render.film_transparent = True
    spec = BakeSpec(texels=32, bucket=4, samples=4)
    made = bake_object(context.scene, "Ball", spec, out, preview=Filter.QUADRILINEAR)
    assert made.files.preview is not None
    picture = out.parent / "picture.png"
    render_picture(made.files.preview, picture, pixels=64, samples=8)
    with PIL.Image.open(picture) as opened:
        seen = np.asarray(opened)[32, 32] / 255
    through = HALF * HALF
    assert seen[3] == pytest.approx(1 - through, abs=0.02), "walls are two, no more"
    assert seen[0] == pytest.approx(0, abs=0.02), "a world that the film leaves out"


def test_an_open_mesh_shows_both_its_sides(out: Path) -> None:
    """A card from behind: the film is transparent, the card is not."""
    stage.world((1, 0, 0))
    bpy.ops.mesh.primitive_plane_add(rotation=(np.pi / 2, 0, 0))  # its front looks at -y
    card: Any = context.object
    card.name = "Card"
    card.data.materials.append(stage.material("Card", "ShaderNodeEmission", Color=(0, HALF, 0, 1)))
    bpy.ops.object.camera_add(location=(0, 6, 0), rotation=(-np.pi / 2, np.pi, 0))
    context.scene.camera = context.object
    context.scene.view_settings.view_transform = "Raw"
    context.scene.render.film_transparent = True
    spec = BakeSpec(texels=16, bucket=4, samples=1)
    made = bake_object(context.scene, "Card", spec, out, preview=Filter.QUADRILINEAR)
    assert made.files.preview is not None
    picture = out.parent / "picture.png"
    render_picture(made.files.preview, picture, pixels=32, samples=4)
    with PIL.Image.open(picture) as opened:
        seen = np.asarray(opened)[16, 16] / 255
    np.testing.assert_allclose(seen, [0, HALF, 0, 1], atol=0.02)


@pytest.mark.parametrize(
    ("shape", "closed"),
    [("uv_sphere", True), ("cube", True), ("monkey", False), ("plane", False), ("circle", False)],
)
@pytest.mark.parametrize("split", [False, True], ids=["joined", "split along its edges"])
def test_closed_meshes_are_known(shape: str, closed: bool, split: bool) -> None:
    getattr(bpy.ops.mesh, f"primitive_{shape}_add")(location=(5, 0, 0))
    if split:
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.select_all(action="SELECT")
        bpy.ops.mesh.edge_split()
        bpy.ops.object.mode_set(mode="OBJECT")
    assert is_closed(context.object.data) is closed
