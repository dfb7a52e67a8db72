# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Previews of `shadow` and `ao`, and of what is partly clear, rendered by Cycles."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
import numpy as np
import PIL.Image
import pytest
from mathutils import Vector

from radtex_addon.core.arrays import Floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.sampler import Filter
from radtex_addon.formats.containers.exr import read_buckets, read_render
from radtex_addon.formats.shadow_files import read_shadow_of
from radtex_addon.job import BakeResult, bake_object
from radtex_addon.preview.lit_material import DIRECTION
from radtex_addon.preview.save import render_picture
from radtex_addon.scene.mesh.watertight import is_closed
from radtex_addon.settings.spec import BakeSpec
from tests.blender import stage
from tests.reference.shadows import visibility

pytestmark = pytest.mark.usefixtures("temporary")
context: Any = bpy.context
PIXELS = 32
TOWARDS = Vector((0.5, -0.3, 0.9)).normalized()


def baked(kind: str, out: Path, sun: bool = True) -> BakeResult:
    """A floor of 2 x 2 with a ball above it and a sun of 2 W/m²; opens the preview."""
    bpy.ops.mesh.primitive_plane_add(size=2)
    context.object.name = "Floor"
    bpy.ops.mesh.primitive_ico_sphere_add(radius=0.35, subdivisions=3, location=(0.1, 0.1, 0.5))
    context.object.visible_camera = False
    if sun:
        bpy.ops.object.light_add(type="SUN")
        context.object.data.energy = 2
        context.object.rotation_euler = TOWARDS.to_track_quat("Z", "Y").to_euler()
    spec = BakeSpec(kind=kind, texels=24, bucket=8, samples=4, uv_layer="UVMap")  # type: ignore[arg-type]
    result = bake_object(context.scene, "Floor", spec, out, preview=Filter.QUADRILINEAR)
    bpy.ops.wm.open_mainfile(filepath=str(result.files.preview))
    return result


def picture(folder: Path) -> Floats:
    """The floor from straight above, one colour a pixel, v up: (PIXELS, PIXELS, 3)."""
    scene = context.scene
    data = bpy.data.cameras.new("Above")
    data.type, data.ortho_scale = "ORTHO", 2
    scene.camera = bpy.data.objects.new("Above", data)
    scene.collection.objects.link(scene.camera)
    scene.camera.location.z = 3
    scene.render.engine = "CYCLES"
    scene.render.resolution_x = scene.render.resolution_y = PIXELS
    scene.cycles.samples, scene.cycles.use_denoising = 1, False
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "GAUSSIAN", 0.01
    if hasattr(scene.render.image_settings, "media_type"):
        scene.render.image_settings.media_type = "IMAGE"
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    scene.render.filepath = str(folder / "above.exr")
    bpy.ops.render.render(write_still=True)
    return read_render(folder / "above.exr")[""][..., :3]


def places() -> Floats:
    """Texture coordinates of the pictures' pixels: (PIXELS², 2)."""
    steps = (np.arange(PIXELS) + 0.5) / PIXELS
    return np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)


def expected(result: BakeResult, towards: Vector) -> Floats:
    words, facts = read_shadow_of(result.files.sidecar)
    layout = AtlasLayout(facts.width, facts.height, facts.bucket)
    ways = np.broadcast_to(np.array(towards), (PIXELS**2, 3))
    return visibility(words, layout, places(), ways, Filter.QUADRILINEAR).reshape(PIXELS, PIXELS)


def test_a_shadow_shows_white_in_the_suns_light_and_follows_it(out: Path, tmp_path: Path) -> None:
    result = baked("shadow", out)
    share = expected(result, TOWARDS)
    assert share.min() < 0.1
    assert share.max() > 0.99
    np.testing.assert_allclose(picture(tmp_path)[..., 1], share * TOWARDS.z * 2 / np.pi, atol=2e-3)
    turned = Vector((-0.6, 0.1, 0.7)).normalized()
    sun = next(item for item in bpy.data.objects if item.type == "LIGHT")
    sun.rotation_euler, sun.data.energy = turned.to_track_quat("Z", "Y").to_euler(), 3
    context.view_layer.update()
    np.testing.assert_allclose(
        picture(tmp_path)[..., 1], expected(result, turned) * turned.z * 3 / np.pi, atol=2e-3
    )


def test_without_a_sun_the_direction_may_be_set_by_hand(out: Path, tmp_path: Path) -> None:
    result = baked("shadow", out, sun=False)
    tree = context.scene.objects["Floor"].material_slots[0].material.node_tree
    for axis in range(3):
        tree.nodes[DIRECTION].inputs[axis].default_value = TOWARDS[axis]
    share = expected(result, TOWARDS)
    np.testing.assert_allclose(picture(tmp_path)[..., 0], share * TOWARDS.z * 3 / np.pi, atol=2e-3)


def test_ambient_occlusion_shows_grey(out: Path, tmp_path: Path) -> None:
    result = baked("ao", out)
    pixels, facts = read_buckets(result.files.sidecar)
    shown = picture(tmp_path)
    np.testing.assert_allclose(shown[..., 0], shown[..., 2], atol=1e-6)
    uv = places()
    nearest = pixels[(uv[:, 1] * facts.height).astype(int), (uv[:, 0] * facts.width).astype(int), 3]
    off = np.abs(shown[..., 0].ravel() - nearest)
    assert off.mean() < 0.02  # blended between texels, which differ little
    assert 0.1 < nearest.min() < 0.8


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


def middle_of_preview(name: str, spec: BakeSpec, out: Path, pixels: int, samples: int) -> Floats:
    """The colour and alpha in the middle of a preview's picture, (4,), by the active object, a camera."""
    context.scene.camera = context.object
    context.scene.view_settings.view_transform = "Raw"
    context.scene.render.film_transparent = True
    made = bake_object(context.scene, name, spec, out, preview=Filter.QUADRILINEAR)
    assert made.files.preview is not None
    picture = out.parent / "picture.png"
    render_picture(made.files.preview, picture, pixels=pixels, samples=samples)
    with PIL.Image.open(picture) as opened:
        found: Floats = np.asarray(opened)[pixels // 2, pixels // 2] / 255
    return found


def test_a_preview_shows_the_far_side_once(out: Path) -> None:
    stage.world((1, 0, 0))
    bpy.ops.mesh.primitive_uv_sphere_add(segments=32, ring_count=16)
    ball: Any = context.object
    ball.name = "Ball"
    ball.data.materials.append(half_clear("Half"))
    bpy.ops.object.camera_add(location=(0, -6, 0), rotation=(np.pi / 2, 0, 0))
    spec = BakeSpec(texels=32, bucket=4, samples=4)
    seen = middle_of_preview("Ball", spec, out, pixels=64, samples=8)
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
    spec = BakeSpec(texels=16, bucket=4, samples=1)
    seen = middle_of_preview("Card", spec, out, pixels=32, samples=4)
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
