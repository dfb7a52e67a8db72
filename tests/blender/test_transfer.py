# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes of kind `transfer`: light of one sun at a time, in the surface's own frame, and nothing else."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest
from mathutils import Vector

from radtex_addon.bake.progress import Progress, Stage, finished
from radtex_addon.bake.transfer_buckets import mean_over_lights
from radtex_addon.core.arrays import Floats
from radtex_addon.core.errors import InputError
from radtex_addon.core.hemisphere import cell_centres, square_to_direction
from radtex_addon.formats.transfer_files import TransferSidecar, read_transfer
from radtex_addon.job import bake_object, bake_steps
from radtex_addon.settings.spec import BakeSpec, Kind, View
from tests.blender import stage
from tests.blender.fingerprint import differences, fingerprint
from tests.reference.relighting import sample_transfer

pytestmark = pytest.mark.usefixtures("temporary")
context: Any = bpy.context  # to the stubs, every pointer may be None

SMALL = BakeSpec(kind=Kind.TRANSFER, texels=6, samples=16)
WHITE = (0.8, 0.4, 0.2)


def card(rotation: tuple[float, float, float] = (0, 0, 0)) -> Any:
    bpy.ops.mesh.primitive_plane_add(size=2, rotation=rotation)
    made = context.object
    made.name = "Card"
    made.data.materials.append(stage.material("Card", "ShaderNodeBsdfDiffuse", Color=(*WHITE, 1)))
    return made


def bake(
    out: Path, spec: BakeSpec = SMALL, name: str = "Card", **options: Any
) -> tuple[Floats, TransferSidecar]:
    result = bake_object(context.scene, name, spec, out, **options)
    pixels, facts = read_transfer(result.files.sidecar)
    return pixels.astype(np.float32), facts


def under(pixels: Floats, facts: TransferSidecar, light: tuple[float, float, float]) -> Floats:
    """What the middle of the atlas shows under light from a direction in the frame."""
    shown: Floats = sample_transfer(pixels, facts.layout, np.array([[0.5, 0.5]]), np.array([light]))[0]
    return shown


def test_a_diffuse_card_shows_the_cosine_of_its_light(tmp_path: Path) -> None:
    card()
    before = fingerprint()
    pixels, facts = bake(tmp_path / "out")
    assert differences(before, fingerprint()) == {}
    assert (facts.suns, facts.bake.kind, facts.layout.bucket) == (81, "transfer", 9)
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"Card.transfer.exr", "Card.transfer.json"}
    full = np.array(WHITE) / np.pi
    for light, cosine in (
        ((0, 0, 1), 1.0),
        ((0.6, 0, 0.8), 0.8),
        ((0, -0.87, 0.5), 0.5),
        ((0.6, 0, -0.8), 0.0),
    ):
        np.testing.assert_allclose(under(pixels, facts, light)[:3], full * cosine, atol=0.05 * full[0])
    np.testing.assert_allclose(mean_over_lights(pixels, facts.layout)[3, 3, :3], WHITE, rtol=0.03)
    np.testing.assert_array_equal(pixels[..., 3], 1)


@pytest.mark.one_blender
def test_no_other_light_leaves_a_trace(tmp_path: Path) -> None:
    card()
    alone, facts = bake(tmp_path / "alone")
    stage.world()
    stage.lamps()
    bpy.ops.mesh.primitive_plane_add(size=1, location=(0, 0, -1))  # behind the card
    glow = stage.material("Glow", "ShaderNodeEmission", Color=(5, 5, 5, 1))
    context.object.data.materials.append(glow)
    lamps = bpy.data.collections.new("Instanced lamps")
    lamps.objects.link(bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "POINT")))
    instance = bpy.data.objects.new("Instance", None)
    instance.instance_type, instance.instance_collection = "COLLECTION", lamps
    instance.location.z = 1
    context.scene.collection.objects.link(instance)
    lit, _ = bake(tmp_path / "lit")
    # The same but for noise: light is sampled among more lamps.
    assert abs(float(lit.mean() / alone.mean()) - 1) < 0.02
    np.testing.assert_allclose(under(lit, facts, (0, 0, -1))[:3], 0, atol=0.01)


@pytest.mark.one_blender
def test_what_glows_shows_nothing_of_itself(tmp_path: Path) -> None:
    made = card()
    made.data.materials[0] = stage.material("Glow", "ShaderNodeEmission", Color=(5, 5, 5, 1))
    pixels, _ = bake(tmp_path)
    np.testing.assert_array_equal(pixels[..., :3], 0)


@pytest.mark.one_blender
def test_a_turned_object_has_the_same_buckets(tmp_path: Path) -> None:
    """Within noise, and what 9 x 9 cells tell apart: so it may turn at run time."""
    made = card()
    made.data.materials[0] = stage.material("Gloss", "ShaderNodeBsdfAnisotropic", Roughness=0.6)
    straight, facts = bake(tmp_path / "straight")
    made.rotation_euler = (2.0, -0.7, 0.4)
    turned, _ = bake(tmp_path / "turned")
    for light in ((0, 0, 1), (0.5, 0.1, 0.85), (-0.4, 0.7, 0.6), (0, 0.3, -0.95)):
        one, other = (float(under(pixels, facts, light)[0]) for pixels in (straight, turned))
        assert one == pytest.approx(other, abs=0.08 * float(straight.max()))


@pytest.mark.one_blender
def test_light_comes_through_from_behind(tmp_path: Path) -> None:
    made = card()
    made.data.materials[0] = stage.material("Leaf", "ShaderNodeBsdfTranslucent", Color=(0.5, 1, 0.5, 1))
    pixels, facts = bake(tmp_path)
    np.testing.assert_allclose(
        under(pixels, facts, (0, 0, -1))[:3], np.array([0.5, 1, 0.5]) / np.pi, rtol=0.08
    )
    np.testing.assert_allclose(under(pixels, facts, (0, 0, 1))[:3], 0, atol=0.01)


@pytest.mark.one_blender
def test_a_bake_goes_on_between_suns_and_is_the_same_bit_by_bit(tmp_path: Path) -> None:
    card()
    whole, _ = bake(tmp_path / "whole")
    steps = bake_steps(context.scene, "Card", SMALL, tmp_path / "cut")
    captured: list[Progress] = []
    for step in steps:
        captured += [step] if step.stage is Stage.CAPTURE else []
        if len(captured) == 20:
            break
    steps.close()
    assert captured[-1].total == 81 * captured[1].done  # 81 suns, all texels each
    pieces = list((tmp_path / "cut" / "Card.transfer.radtex-unfinished").glob("sun-*"))
    assert len(pieces) == 19
    moved = [path.stat().st_mtime_ns for path in pieces]
    rest = bake_steps(context.scene, "Card", SMALL, tmp_path / "cut", resume=True)
    first = next(step for step in rest if step.stage is Stage.FIT)
    assert first.done == 0
    assert moved == [path.stat().st_mtime_ns for path in pieces]
    finished(rest)
    again, _ = read_transfer(tmp_path / "cut" / "Card.transfer.json")
    np.testing.assert_array_equal(whole, again.astype(np.float32))


@pytest.mark.one_blender
@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        ({"layout": "layered"}, "kind transfer does not go with the layered layout: choose layout buckets"),
        ({"capture": "panoramic"}, "kind transfer does not go with capture panoramic: capture by portal"),
    ],
)
def test_what_it_cannot_be_is_refused(wrong: dict[str, Any], says: str) -> None:
    with pytest.raises(InputError, match=says):
        BakeSpec(kind=Kind.TRANSFER, **wrong)


def changing_card() -> None:
    """A matt card whose colour is (1 + I.x) / 2 to a viewer in the world's direction I."""
    bpy.ops.mesh.primitive_plane_add(size=2)
    made = context.object
    made.name = "Card"
    painted: Any = stage.material("Changing", "ShaderNodeBsdfDiffuse")
    tree = painted.node_tree
    towards, paint = tree.nodes.new("ShaderNodeNewGeometry"), tree.nodes.new("ShaderNodeVectorMath")
    paint.operation = "DOT_PRODUCT"
    paint.inputs[1].default_value = (0.5, 0, 0)
    lighter = tree.nodes.new("ShaderNodeMath")
    lighter.inputs[1].default_value = 0.5
    tree.links.new(towards.outputs["Incoming"], paint.inputs[0])
    tree.links.new(paint.outputs["Value"], lighter.inputs[0])
    diffuse = next(node for node in tree.nodes if node.type == "BSDF_DIFFUSE")
    tree.links.new(lighter.outputs[0], diffuse.inputs["Color"])
    made.data.materials.append(painted)


def camera(place: tuple[float, float, float], kind: str) -> None:
    data: Any = bpy.data.cameras.new("Eye")
    data.type = kind
    made = bpy.data.objects.new("Eye", data)
    made.location = place
    made.rotation_euler = Vector(place).to_track_quat("Z", "Y").to_euler()
    context.scene.collection.objects.link(made)
    context.scene.camera = made
    context.view_layer.update()


PLACE = (1.5, -0.5, 1.0)
UV = np.array([[0.3, 0.3], [0.5, 0.5], [0.8, 0.6]])
ABOVE = np.tile([[0.0, 0.0, 1.0]], (len(UV), 1))


def to_eye(far: bool) -> Floats:
    """Unit vectors from the card, whose UV layer lies along x and y, to PLACE: (K, 3)."""
    points = np.concatenate([2 * UV - 1, np.zeros((len(UV), 1))], axis=1)
    away = np.array(PLACE) - points * (not far)
    return np.asarray(away / np.linalg.norm(away, axis=1, keepdims=True))


@pytest.mark.one_blender
@pytest.mark.parametrize(("kind", "below"), [("PERSP", False), ("ORTHO", False), ("PERSP", True)])
def test_a_cameras_view_shows_what_the_camera_sees(tmp_path: Path, kind: str, below: bool) -> None:
    """What faces away from the camera is seen from before it."""
    changing_card()
    x, y, z = PLACE
    camera((x, y, -z if below else z), kind)
    pixels, facts = bake(tmp_path, replace(SMALL, view=View.CAMERA, texels=12, uv_layer="UVMap"))
    away = to_eye(kind == "ORTHO")
    assert (facts.view, facts.views) == ("camera", 1)
    assert facts.eye is not None
    if not below:
        eye = (*away[0], False) if kind == "ORTHO" else (*PLACE, True)
        np.testing.assert_allclose(facts.eye, eye, atol=1e-5)
    shown = sample_transfer(pixels, facts.layout, UV, ABOVE)[:, 0]
    np.testing.assert_allclose(shown, (1 + away[:, 0]) / 2 / np.pi, rtol=0.04)


@pytest.mark.one_blender
def test_views_from_around_blend_between_nine(tmp_path: Path) -> None:
    changing_card()
    pixels, facts = bake(tmp_path, replace(SMALL, view=View.AROUND, uv_layer="UVMap"))
    assert (facts.view, facts.views, facts.eye) == ("around", 3, None)
    assert pixels.shape == (6 * 3 * 9, 6 * 3 * 9, 4)
    middles = square_to_direction(cell_centres(3).reshape(-1, 2))
    uv, above = np.full((9, 2), 0.5), np.tile([[0.0, 0.0, 1.0]], (9, 1))
    shown = sample_transfer(pixels, facts.layout, uv, above, middles, facts.views)[:, 0]
    np.testing.assert_allclose(shown, (1 + middles[:, 0]) / 2 / np.pi, atol=0.012)
    tilted = np.tile([[0.5, 0.0, np.sqrt(0.75)]], (9, 1))  # between the middle one and its neighbour
    between = sample_transfer(pixels, facts.layout, uv, above, tilted, facts.views)[0, 0]
    np.testing.assert_allclose(between, 0.75 / np.pi, atol=0.012)


@pytest.mark.one_blender
def test_a_view_that_cannot_be_is_refused(tmp_path: Path) -> None:
    card()
    with pytest.raises(InputError, match="scene 'Scene' has no camera to be seen from: add one"):
        bake(tmp_path / "out", replace(SMALL, view=View.CAMERA))
    assert not (tmp_path / "out").exists()
    with pytest.raises(
        InputError, match=r"radiance is not baked for a view, such as camera: leave the view out"
    ):
        BakeSpec(view=View.CAMERA)
    with pytest.raises(InputError, match="makes 81000 pixels a side"):
        BakeSpec(kind=Kind.TRANSFER, view=View.AROUND, texels=3000)
