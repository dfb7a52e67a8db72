# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames of an animation: numbered atlases on one unwrap."""

from __future__ import annotations

import logging
from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.cli.arguments import parse
from radtex_addon.core.errors import InputError
from radtex_addon.core.sampler import Filter
from radtex_addon.formats.containers.exr import read_buckets
from radtex_addon.formats.sidecar import read_sidecar
from radtex_addon.job import bake_object
from radtex_addon.prepare.unwrapping import Unwraps
from radtex_addon.settings.spec import BakeSpec, Unwrap
from tests.blender import stage
from tests.blender.batch_process import Batch
from tests.blender.fingerprint import differences, fingerprint

pytestmark = pytest.mark.usefixtures("temporary")
context: Any = bpy.context  # to the stubs, every pointer may be None

SPEC = BakeSpec(texels=24, bucket=4, samples=1, half=False, padding=1, frame=5, unwrap_at=1)


def growing_ball() -> None:
    """A ball that glows, 1 at frame 1 and 9 at frame 9, and bends meanwhile; the scene is at frame 3."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=12, ring_count=8)
    ball = context.object
    ball.name = "Ball"
    glow = stage.material("Glow", "ShaderNodeEmission", Color=(1, 1, 1, 1))
    ball.data.materials.append(glow)
    strength = next(n for n in glow.node_tree.nodes if n.type == "EMISSION").inputs["Strength"]
    bend = ball.modifiers.new("Bend", "SIMPLE_DEFORM")
    bend.deform_method, bend.angle = "BEND", 0
    for frame in (1, 9):
        strength.default_value, bend.angle, ball.location.x = frame, 0.1 * (frame - 1), frame
        strength.keyframe_insert("default_value", frame=frame)
        bend.keyframe_insert("angle", frame=frame)
        ball.keyframe_insert("location", frame=frame)
    actions = (glow.node_tree.animation_data.action, ball.animation_data.action)
    for action in actions:
        for curve in action.layers[0].strips[0].channelbags[0].fcurves:
            for key in curve.keyframe_points:
                key.interpolation = "LINEAR"
    context.scene.frame_set(3)


def test_a_frame_is_baked_as_it_is_then_and_the_scene_stays_where_it_is(out: Path) -> None:
    growing_ball()
    before = fingerprint()
    made = bake_object(context.scene, "Ball", SPEC, out)
    assert differences(before, fingerprint()) == {}
    assert made.files.sidecar == out / "Ball-0005.radiance.json"
    pixels, facts = read_buckets(made.files.sidecar)
    assert (facts.object_name, facts.frame) == ("Ball", 5)
    np.testing.assert_allclose(pixels[..., :3], 5, rtol=1e-5)
    plain = bake_object(context.scene, "Ball", replace(SPEC, frame=None, unwrap_at=None), out)
    assert plain.files.sidecar == out / "Ball.radiance.json"
    pixels, facts = read_buckets(plain.files.sidecar)
    assert facts.frame is None
    np.testing.assert_allclose(pixels[..., :3], 3, rtol=1e-5)


def baked_uv(preview: Path) -> tuple[Any, Any, float]:
    """UVs and places of the baked copy in a saved preview, and where it stands."""
    bpy.ops.wm.open_mainfile(filepath=str(preview))
    item = bpy.data.objects["Ball"]
    mesh: Any = item.data
    uv = np.empty(len(mesh.loops) * 2, dtype=np.float32)
    mesh.uv_layers.active.data.foreach_get("uv", uv)
    place = np.empty(len(mesh.vertices) * 3, dtype=np.float32)
    mesh.vertices.foreach_get("co", place)
    context.view_layer.update()
    return uv, place, item.matrix_world.translation.x


def test_frames_of_a_mesh_that_bends_share_the_first_ones_unwrap(out: Path) -> None:
    growing_ball()
    unwraps: Unwraps = {}
    spec = replace(SPEC, unwrap=Unwrap.UVUNWRAP)
    before = fingerprint()
    previews: list[Any] = [
        bake_object(
            context.scene, "Ball", replace(spec, frame=frame), out, preview=Filter.NEAREST, unwraps=unwraps
        ).files.preview
        for frame in (1, 9)
    ]
    assert differences(before, fingerprint()) == {}
    assert len(unwraps) == 1
    assert [path.name for path in previews] == ["Ball-0001.preview.blend", "Ball-0009.preview.blend"]
    (uv, place, x), (other_uv, other_place, other_x) = map(baked_uv, previews)
    np.testing.assert_array_equal(uv, other_uv)
    assert np.abs(place - other_place).max() > 0.1
    assert (x, other_x) == pytest.approx((1, 9))


def test_a_mesh_with_other_faces_is_unwrapped_anew_and_told(
    out: Path, caplog: pytest.LogCaptureFixture
) -> None:
    growing_ball()
    ball = bpy.data.objects["Ball"]
    build: Any = ball.modifiers.new("Build", "BUILD")
    build.frame_start, build.frame_duration = -8, 20
    with caplog.at_level(logging.WARNING):
        bake_object(context.scene, "Ball", SPEC, out)
    assert "object 'Ball' has other faces at frame 1 than at 5" in caplog.text


@pytest.mark.one_blender
def test_the_batch_bakes_frames_and_goes_on_with_those_that_lack(
    tmp_path: Path, out: Path, batch: Batch
) -> None:
    growing_ball()
    blend = tmp_path / "ball.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    small = ("--layout=buckets", "--texels=24", "--bucket=4", "--samples=1", "--padding=1")
    asked = (blend, "--object=Ball", *small, f"--out={out}", "--frames=2,4-5", "--progress=json")
    done = batch(*asked)
    assert done.code == 0, done.err
    names = [f"Ball-000{frame}.radiance.json" for frame in (2, 4, 5)]
    assert sorted(path.name for path in out.glob("*.json")) == names
    assert "Ball, frame 4 (2 of 3)" in done.out
    first, atlas = (out / names[0]).stat().st_mtime_ns, out / "Ball-0005.radiance.exr"
    light = atlas.read_bytes()
    for path in (out / names[2], atlas):
        path.unlink()
    again = batch(*asked, "--resume")
    assert again.code == 0, again.err
    assert (out / names[0]).stat().st_mtime_ns == first, "a finished frame is baked again"
    assert (atlas.read_bytes(), read_sidecar(out / names[2]).frame) == (light, 5)
    refused = batch(*asked)
    assert refused.code == 2
    assert "Ball-0002.radiance" in refused.err


def test_frames_are_read_from_lists_and_ranges() -> None:
    request = parse(["a.blend", "--object=A", "--frames=3,1-2,3"], inside_blender=False)
    assert request.bakes.frames == (3, 1, 2)
    assert [spec.frame for spec in request.bakes.specs(context.scene)] == [3, 1, 2]
    assert {spec.unwrap_at for spec in request.bakes.specs(context.scene)} == {3}
    alone = parse(["a.blend", "--object=A", "--frames=7"], inside_blender=False)
    assert [(spec.frame, spec.unwrap_at) for spec in alone.bakes.specs(context.scene)] == [(7, None)]
    named = parse(["a.blend", "--object=A", "--frames=1-2", "--uv=Map"], inside_blender=False)
    assert {spec.unwrap_at for spec in named.bakes.specs(context.scene)} == {None}


@pytest.mark.one_blender
@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["--frames=x"], "frames x: give frames' numbers"),
        (["--frames=5-1"], "frames 5-1: give frames' numbers"),
        (["--frames=1,"], "frames 1,: give frames' numbers"),
        (["--frames=1-99999999"], "give frames' numbers"),
        (["--unwrap-at=one"], "--unwrap-at one: give a frame's number"),
        (["--unwrap-at=1"], "unwrap at frame 1 is for frames"),
        (["--frames=1", "--unwrap-at=2", "--uv=Map"], "unwrap at frame 2 is for frames without a UV layer"),
        (["--frames=9999999"], "frame 9999999: give a whole number"),
    ],
)
def test_frames_that_are_none_are_refused(words: list[str], complaint: str) -> None:
    with pytest.raises(InputError, match=complaint):
        parse(["a.blend", "--object=A", *words], inside_blender=False)
