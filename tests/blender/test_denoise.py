# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Denoised bakes: less noise, the same energy, borders as sharp as they were; and raw ones, as ever."""

from __future__ import annotations

import logging
from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.bake.layers import Layer
from radtex_addon.core.arrays import Floats
from radtex_addon.cycles.denoiser import image_denoiser
from radtex_addon.formats.bucket_files import read_layer
from radtex_addon.formats.containers.exr import read_buckets
from radtex_addon.formats.transfer_files import read_transfer
from radtex_addon.job import bake_object
from radtex_addon.settings.spec import BakeSpec, Kind
from tests.blender import stage
from tests.blender.fingerprint import differences, fingerprint

pytestmark = pytest.mark.usefixtures("temporary")
context: Any = bpy.context

TEXELS = 48
SPEC = BakeSpec(texels=TEXELS, bucket=3, samples=4, uv_layer="UVMap", half=False, denoise=True)
TRUTH = 64  # samples


def two_sided_card() -> None:
    """A square, dark on the left and bright on the right of u = 1/2, under a wide lamp that a box shades."""
    stage.world((0.1, 0.1, 0.1))
    stage.clamps_off()
    bpy.ops.mesh.primitive_plane_add(size=2)
    card = context.object
    card.name = "Card"
    for name, value in (("Dark", 0.15), ("Bright", 0.8)):
        card.data.materials.append(stage.material(name, "ShaderNodeBsdfDiffuse", Color=(value,) * 3 + (1,)))
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.subdivide()
    bpy.ops.object.mode_set(mode="OBJECT")
    for face in card.data.polygons:
        face.material_index = int(face.center.x > 0)
    bpy.ops.object.light_add(type="AREA", location=(0, 0, 2.5))
    context.object.data.size, context.object.data.energy = 3, 100
    bpy.ops.mesh.primitive_cube_add(size=0.7, location=(0.3, -0.5, 0.8))


def baked(spec: BakeSpec, folder: Path) -> Floats:
    """The buckets (H, W, n, n, 3) of the card."""
    pixels, facts = read_buckets(bake_object(context.scene, "Card", spec, folder).files.sidecar)
    assert facts.denoised == spec.denoise
    n = facts.bucket
    return pixels.reshape(facts.height, n, facts.width, n, -1).transpose(0, 2, 1, 3, 4)[..., :3]


def test_noise_goes_energy_stays_and_borders_are_sharp(out: Path) -> None:
    two_sided_card()
    raw = baked(replace(SPEC, denoise=False), out / "raw")
    ours = baked(SPEC, out / "denoised")
    np.testing.assert_array_equal(baked(SPEC, out / "again"), ours)
    assert '"denoised": true' in (out / "again" / "Card.radiance.json").read_text()
    assert "denoised" not in (out / "raw" / "Card.radiance.json").read_text(), "as of old"
    truth = baked(replace(SPEC, denoise=False, samples=TRUTH, seed=1), out / "truth")
    error = [float(((each - truth) ** 2).mean()) for each in (raw, ours)]
    assert error[1] < error[0] / 4
    np.testing.assert_allclose(ours.mean(axis=(0, 1, 2, 3)), raw.mean(axis=(0, 1, 2, 3)), rtol=0.01)
    middle = TEXELS // 2
    for side in (slice(middle - 1, middle), slice(middle, middle + 1)):  # the texels beside the border
        edges = [float(each[:, side].mean()) for each in (ours, truth)]
        np.testing.assert_allclose(edges[0], edges[1], rtol=0.05)
    bright = slice(middle + 2, None)
    steps = [np.abs(np.diff(each[:, bright].mean(axis=(2, 3, 4)), axis=0)).max() for each in (ours, truth)]
    assert steps[0] > 0.6 * steps[1], "the shadow's edge is as steep"


@pytest.mark.one_blender
def test_layers_still_add_up(out: Path) -> None:
    """Each layer is denoised by itself: diffuse light is all there is, so that it is the whole, nearly."""
    two_sided_card()
    spec = replace(SPEC, layers=(Layer.DIFFUSE, Layer.BASE, Layer.REST))
    sidecar = bake_object(context.scene, "Card", spec, out).files.sidecar
    whole, facts = read_buckets(sidecar)
    diffuse, base, rest = (read_layer(sidecar, layer) for layer in spec.layers)
    n = facts.bucket
    both = base.repeat(n, axis=0).repeat(n, axis=1) + rest
    np.testing.assert_allclose(both, whole[..., :3], atol=1e-5)
    np.testing.assert_allclose(diffuse, whole[..., :3], rtol=0.02, atol=2e-3)


@pytest.mark.one_blender
def test_a_transfer_is_denoised(out: Path) -> None:
    two_sided_card()
    spec = BakeSpec(kind=Kind.TRANSFER, texels=32, bucket=3, samples=2, uv_layer="UVMap", half=False)
    raw, ours, truth = (
        read_transfer(bake_object(context.scene, "Card", each, out / name).files.sidecar)[0][..., :3]
        for name, each in (
            ("raw", spec),
            ("ours", replace(spec, denoise=True)),
            ("truth", replace(spec, samples=128, seed=1)),
        )
    )
    assert ((ours - truth) ** 2).mean() < ((raw - truth) ** 2).mean() / 2
    off = [abs(float(each.mean()) / float(truth.mean()) - 1) for each in (raw, ours)]
    assert off[1] < 0.02, f"raw noise that the fit cuts off below 0 adds light: {off[0]:.1%}"


@pytest.mark.one_blender
def test_what_is_added_to_a_denoised_bake_is_told(out: Path, caplog: pytest.LogCaptureFixture) -> None:
    two_sided_card()
    baked(SPEC, out)
    with caplog.at_level(logging.WARNING):
        result = bake_object(context.scene, "Card", replace(SPEC, accumulate=True), out)
    assert "Card.radiance.exr is denoised" in caplog.text
    _, facts = read_buckets(result.files.sidecar)
    assert (facts.samples, facts.denoised) == (2 * SPEC.samples, True)


@pytest.mark.parametrize(("texels", "bucket"), [(1, 2), (1, 3), (2, 2), (5, 2)])
def test_the_smallest_pictures_are_denoised_too(out: Path, texels: int, bucket: int) -> None:
    """Blender renders none below 4 pixels a side."""
    stage.world()
    bpy.ops.mesh.primitive_plane_add(size=2)
    context.object.name = "Card"
    white = stage.material("White", "ShaderNodeBsdfDiffuse", Color=(0.8, 0.8, 0.8, 1))
    context.object.data.materials.append(white)
    light = baked(BakeSpec(texels=texels, bucket=bucket, samples=16, uv_layer="UVMap"), out)
    assert light.shape == (texels, texels, bucket, bucket, 3)
    np.testing.assert_allclose(light, 0.8, rtol=0.02)


@pytest.mark.one_blender
def test_only_light_in_buckets_is_denoised() -> None:
    assert BakeSpec(kind=Kind.PROXY, denoise=True).denoise
    for other in ({"kind": Kind.SHADOW}, {"kind": Kind.AO}, {"layout": "layered"}, {"refresh": True}):
        assert not BakeSpec(denoise=True, **other).denoise


def test_a_denoiser_leaves_the_file_as_it_was(tmp_path: Path) -> None:
    stage.world()
    before = fingerprint()
    rng = np.random.default_rng(1)
    light = rng.gamma(1, 2.0, (40, 60, 3)).astype(np.float32)
    with image_denoiser(tmp_path) as denoiser:
        assert denoiser is not None
        up = np.broadcast_to(np.array([0, 0, 1], dtype=np.float32), light.shape)
        ours = denoiser(light, np.ones_like(light), up)
    assert ours.shape == light.shape
    assert ours.var() < light.var() / 50
    changed = differences(before, fingerprint())
    others = {key for key in changed if "Render Result" not in key + str(changed[key])}
    assert others == set(), "a render's result stays, as after any render"
