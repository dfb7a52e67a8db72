# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Layers of a baked object: its light passes add up to the whole, and so do base and rest."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.bake import session
from radtex_addon.bake.layers import LIGHT, Layer
from radtex_addon.core.arrays import Floats
from radtex_addon.core.errors import InputError
from radtex_addon.core.sampler import Filter
from radtex_addon.formats.bucket_files import read_layer
from radtex_addon.formats.containers.exr import read_buckets
from radtex_addon.job import bake_object
from radtex_addon.preview.swap import switch_off, switch_on
from radtex_addon.settings.spec import BakeSpec
from tests.blender import stage
from tests.blender.fingerprint import differences, fingerprint
from tests.blender.lookup_stage import render_exr, set_up_render

pytestmark = pytest.mark.usefixtures("temporary")
context: Any = bpy.context  # to the stubs, every pointer may be None


def busy_object() -> Any:
    """A ball with something of every lobe, among lamps, glowing and clear things, in a world."""
    stage.hdri(stage.world())
    stage.lamps()
    stage.clamps_off()
    bpy.ops.mesh.primitive_uv_sphere_add(segments=16, ring_count=8, radius=0.6)
    ball = context.object
    ball.name = "Ball"
    shader = stage.material("all", "ShaderNodeBsdfPrincipled")
    node = next(node for node in shader.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    for name, value in (
        ("Base Color", (0.8, 0.5, 0.2, 1)),
        ("Transmission Weight", 0.4),
        ("Subsurface Weight", 0.3),
        ("Coat Weight", 0.5),
        ("Emission Color", (0.1, 0.6, 0.3, 1)),
        ("Emission Strength", 0.5),
        ("Alpha", 0.7),
    ):
        node.inputs[name].default_value = value
    ball.data.materials.append(shader)
    fog = bpy.data.materials.new("fog")
    if fog.node_tree is None:
        fog.use_nodes = True
    tree = fog.node_tree
    tree.nodes.clear()
    output, scatter = tree.nodes.new("ShaderNodeOutputMaterial"), tree.nodes.new("ShaderNodeVolumeScatter")
    tree.links.new(scatter.outputs[0], output.inputs["Volume"])
    bpy.ops.mesh.primitive_cube_add(size=0.5)
    context.object.data.materials.append(fog)
    return ball


def expanded(base: Floats, n: int) -> Floats:
    return base.repeat(n, axis=0).repeat(n, axis=1).astype(np.float32)


def test_light_passes_add_up_to_the_whole_and_base_and_rest_do(out: Path) -> None:
    busy_object()
    layers = (*LIGHT, Layer.NORMAL, Layer.BASE, Layer.REST)
    spec = BakeSpec(texels=16, bucket=4, samples=8, half=False, layers=layers)
    made = bake_object(context.scene, "Ball", spec, out)
    assert {file.name for file in out.iterdir()} == {
        "Ball.radiance.json",
        "Ball.radiance.exr",
        *(f"Ball.radiance.{layer}.exr" for layer in layers),
    }
    whole = read_buckets(made.files.sidecar)[0][..., :3]
    found = {layer: read_layer(made.files.sidecar, layer).astype(np.float32) for layer in layers}
    parts = np.sum([found[layer] for layer in LIGHT], axis=0)
    error = np.abs(parts - whole).max() / whole.max()
    print(f"\nsum of passes against the whole: {error:.1e} of {whole.max():.1f}")
    for layer in LIGHT:
        print(f"  {layer}: mean {found[layer].mean():.4f} of {whole.mean():.4f}")
        assert found[layer].mean() > 1e-3, layer
    assert error < 1e-3
    together = expanded(found[Layer.BASE], 4) + found[Layer.REST]
    print(f"base and rest against the whole: {np.abs(together - whole).max():.1e}")
    assert np.abs(together - whole).max() < 1e-3
    length = np.linalg.norm(found[Layer.NORMAL], axis=-1)
    assert length.max() < 1.001
    assert length.mean() > 0.5


@pytest.mark.one_blender
def test_neither_the_clock_nor_layers_change_what_stands_in_a_volume(
    out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Tiles of any height would, in Blender 5: Cycles learns volumes from neighbouring pixels."""
    busy_object()
    spec = BakeSpec(texels=16, bucket=4, samples=2, seed=3)

    def baked(name: str, layers: tuple[Layer, ...] = ()) -> Floats:
        made = bake_object(context.scene, "Ball", replace(spec, layers=layers), out / name)
        return read_buckets(made.files.sidecar)[0]

    first = baked("first")
    assert np.array_equal(first, baked("layers", (Layer.BASE, Layer.GLOSSY)))
    for seconds in (1e-4, 100.0):
        monkeypatch.setattr(session, "SECONDS_PER_TILE", seconds)
        assert np.array_equal(first, baked(str(seconds))), seconds


@pytest.mark.one_blender
def test_rest_of_a_diffuse_thing_is_next_to_nothing(out: Path) -> None:
    stage.world()
    bpy.ops.mesh.primitive_plane_add(size=2)
    context.object.name = "Card"
    context.object.data.materials.append(
        stage.material("d", "ShaderNodeBsdfDiffuse", Color=(0.8, 0.8, 0.8, 1))
    )
    spec = BakeSpec(texels=8, bucket=4, samples=16, layers=(Layer.BASE, Layer.REST))
    made = bake_object(context.scene, "Card", spec, out)
    np.testing.assert_allclose(read_layer(made.files.sidecar, "base"), 0.8, atol=2e-3)
    np.testing.assert_allclose(read_layer(made.files.sidecar, "rest"), 0, atol=2e-2)


def glowing_ball(out: Path) -> Path:
    """The sidecar of a bake, with a preview and layers, of a green glow over a red diffuse surface."""
    stage.world((1, 1, 1))
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=2)
    ball = context.object
    ball.name = "Ball"
    shader = stage.material("Ball", "ShaderNodeBsdfPrincipled")
    node = next(node for node in shader.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    for name, value in (
        ("Base Color", (1, 0, 0, 1)),
        ("Emission Color", (0, 1, 0, 1)),
        ("Specular IOR Level", 0),
    ):
        node.inputs[name].default_value = value
    node.inputs["Emission Strength"].default_value = 0.5
    ball.data.materials.append(shader)
    layers = (Layer.EMISSION, Layer.BASE)
    spec = BakeSpec(texels=16, bucket=2, samples=4, layers=layers)
    return bake_object(context.scene, "Ball", spec, out, preview=Filter.QUADRILINEAR).files.sidecar


def seen_from_above(path: Path) -> Floats:
    """The middle of what Cycles sees of the scene."""
    bpy.ops.object.camera_add(location=(0, 0, 5))
    camera = context.object
    context.scene.camera = camera
    camera.data.type, camera.data.ortho_scale = "ORTHO", 0.2
    set_up_render(context.scene, "CYCLES")
    context.scene.render.resolution_x = context.scene.render.resolution_y = 4
    seen = render_exr(context.scene, path)
    bpy.data.objects.remove(camera)
    return seen[..., :3].mean(axis=(0, 1))


def test_the_preview_shows_a_layer_alone(out: Path) -> None:
    sidecar = glowing_ball(out)
    ball = bpy.data.objects["Ball"]
    before = fingerprint()
    expected = {None: (1, 0.5, 0), "emission": (0, 0.5, 0), "base": (1, 0, 0)}
    for number, (layer, light) in enumerate(expected.items()):
        switch_on(ball, sidecar, layer)
        found = seen_from_above(out.parent / f"{number}.exr")
        np.testing.assert_allclose(found, light, atol=0.1, err_msg=str(layer))
        names = [image.name for image in bpy.data.images if image.type == "IMAGE"]
        assert names == [f"Ball.radiance{'.' + layer if layer else ''}.exr"]
    shown = fingerprint()
    with pytest.raises(InputError, match="has no layer glossy, its layers are: emission, base"):
        switch_on(ball, sidecar, "glossy")
    assert differences(shown, fingerprint()) == {}
    switch_off(ball)
    assert not bpy.data.images.get("Ball.radiance.base.exr")
    assert {path for path in differences(before, fingerprint()) if path.startswith("objects")} == set()
