# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Some lamps alone: what is baked holds their light and no other, and adds up to the whole; layered, too."""

from __future__ import annotations

from dataclasses import replace
from math import pi
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.cli.arguments import parse
from radtex_addon.core.arrays import Floats
from radtex_addon.core.errors import InputError
from radtex_addon.core.fragments import Fragments
from radtex_addon.formats.containers.exr import read_buckets
from radtex_addon.formats.sidecar import read_sidecar
from radtex_addon.forms.layered.files.layered_files import read_layered
from radtex_addon.forms.layered.lookup.atlas import sample_layered
from radtex_addon.forms.layered.lookup.environment import MOST_LAMPS
from radtex_addon.forms.layered.shader_values import definitions
from radtex_addon.job import bake_object
from radtex_addon.prepare.unwrapping import Unwraps
from radtex_addon.scene.lights.lamps import each_light, lit_by_lamps_alone
from radtex_addon.scene.scratch import scratch_scene
from radtex_addon.settings.spec import BakeSpec, CaptureMethod, Kind, Layer, Layout, Unwrap
from tests.blender import stage
from tests.blender.batch_process import Batch
from tests.blender.fingerprint import differences, fingerprint

pytestmark = pytest.mark.usefixtures("temporary")
context: Any = bpy.context  # to the stubs, every pointer may be None

SPEC = BakeSpec(texels=8, bucket=4, samples=4, half=False)
WHITE = (0.8, 0.4, 0.2)
SUNS = {"Noon": (0.0, (1.0, 0.5, 0.25)), "Evening": (1.0, (0.2, 0.4, 2.0))}  # angle from the zenith, light


def floor(bounces: int = 0, glow: float = 5) -> Any:
    """A diffuse floor under two suns, a lamp in a collection of its own, a world, and a thing that glows."""
    bpy.ops.mesh.primitive_plane_add(size=2)
    made = context.object
    made.name = "Floor"
    made.data.materials.append(stage.material("Floor", "ShaderNodeBsdfDiffuse", Color=(*WHITE, 1)))
    for name, (angle, colour) in SUNS.items():
        bpy.ops.object.light_add(type="SUN", rotation=(0, angle, 0))
        context.object.name = name
        context.object.data.energy, context.object.data.angle = 3, 0
        context.object.data.color = [part / 2 for part in colour]
    bpy.ops.object.light_add(type="AREA", location=(0, 0, 2))
    context.object.name = "Panel"
    context.object.data.size, context.object.data.energy = 1, 40
    group = bpy.data.collections.new("Indoors")
    context.scene.collection.children.link(group)
    group.objects.link(context.object)
    context.scene.collection.objects.unlink(context.object)
    bpy.ops.mesh.primitive_cube_add(size=0.4, location=(0, 2, 1))
    context.object.data.materials.append(
        stage.material("Glow", "ShaderNodeEmission", Color=(1, 1, 1, 1), Strength=glow)
    )
    stage.world((0.1, 0.2, 0.3))
    stage.clamps_off()
    context.scene.cycles.max_bounces = bounces
    return made


def bake(out: Path, spec: BakeSpec, **options: Any) -> Floats:
    return read_buckets(bake_object(context.scene, "Floor", spec, out, **options).files.sidecar)[0]


@pytest.mark.one_blender
def test_one_lamp_alone_gives_its_light_and_no_other(out: Path) -> None:
    floor(glow=0)
    name = "Evening"
    before = fingerprint()
    made = bake_object(context.scene, "Floor", replace(SPEC, lights=(name,)), out)
    assert differences(before, fingerprint()) == {}
    assert made.files.sidecar == out / f"Floor-{name}.radiance.json"
    image, facts = read_buckets(made.files.sidecar)
    assert (facts.object_name, facts.lights) == ("Floor", (name,))
    angle, colour = SUNS[name]
    expected = np.array(WHITE) / np.pi * 3 * np.array(colour) / 2 * np.cos(angle)
    gap = np.abs(image[..., :3] - expected).max() / expected.max()
    print(f"\n{name} is off by {gap:.1e}")
    assert gap < 1e-3
    np.testing.assert_array_equal(image[..., 3], 1)


@pytest.mark.one_blender
def test_what_glows_leaves_no_light(out: Path) -> None:
    floor()
    image = bake(out, replace(SPEC, lights=("Noon",), samples=64))
    expected = np.array(WHITE) / np.pi * 3 * np.array(SUNS["Noon"][1]) / 2
    noise = image[..., :3].std(axis=(0, 1)) / np.sqrt(image[..., 0].size)
    assert (np.abs(image[..., :3].mean(axis=(0, 1)) - expected) < 4 * noise + 1e-4).all()
    assert (noise < 0.02 * expected).all()


@pytest.mark.one_blender
def test_all_lamps_and_the_world_add_up_to_the_whole(out: Path) -> None:
    floor(bounces=2)
    lights = each_light(context.view_layer)
    assert lights == (("Evening",), ("Noon",), ("Panel",), ("world",))
    spec = replace(SPEC, samples=64, unwrap=Unwrap.UVUNWRAP)
    unwraps: Unwraps = {}
    parts = [bake(out, replace(spec, lights=light), unwraps=unwraps) for light in lights]
    assert len(unwraps) == 1
    assert min(part[..., :3].mean() for part in parts) > 0.01
    whole = bake(out, spec, unwraps=unwraps)
    both = bake(out, replace(spec, lights=("Noon", "world")), unwraps=unwraps)
    total = np.sum(parts, axis=0)
    for name, found, expected in (("all", total, whole), ("Noon+world", parts[1] + parts[3], both)):
        gap = (found - expected)[..., :3]
        mean, noise = np.abs(gap.mean(axis=(0, 1))).max(), gap.std()
        print(
            f"\n{name}: off by {mean / expected.mean():.1e} in the mean, {noise / expected.mean():.1e} a cell"
        )
        assert mean < 2e-3 * expected.mean()
        assert noise < 0.04 * expected.mean()


@pytest.mark.one_blender
def test_arriving_light_shows_the_lamp_itself_and_no_world(out: Path) -> None:
    floor()
    spec = replace(SPEC, kind=Kind.INCIDENT, texels=3, bucket=9, samples=64, padding=0, lights=("Indoors",))
    image = bake(out, spec)
    assert (out / "Floor-Indoors.incident.json").is_file()
    middle = image[9:18, 9:18, :3]
    assert middle[4, 4] == pytest.approx(40 / np.pi, rel=0.01)  # an area lamp's radiance is power / pi / area
    assert middle[0].max() == 0, "the world is seen"


def test_lamps_are_copies_that_follow_what_drives_them(out: Path) -> None:
    floor(glow=0)
    sun = bpy.data.objects["Noon"]
    driver = sun.driver_add("rotation_euler", 1).driver
    driver.type, driver.expression = "SCRIPTED", "1.0"
    empty = bpy.data.objects.new("Empty", None)
    context.scene.collection.objects.link(empty)
    sun.parent = empty
    empty.rotation_euler.y = 0.2
    before = fingerprint()
    image = bake(out, replace(SPEC, lights=("Noon",)))
    assert differences(before, fingerprint()) == {}
    expected = np.array(WHITE) / np.pi * 3 * np.array(SUNS["Noon"][1]) / 2 * np.cos(1.2)
    assert np.abs(image[..., :3] - expected).max() < 1e-3


@pytest.mark.one_blender
def test_more_samples_are_of_the_same_lamps(out: Path) -> None:
    floor(bounces=1)
    context.scene.cycles.sampling_pattern = "TABULATED_SOBOL"
    spec = replace(SPEC, lights=("Noon", "Panel"), samples=8)
    whole = bake(out / "whole", replace(spec, samples=16))
    bake(out, spec)
    assert np.abs(bake(out, replace(spec, accumulate=True)) - whole).max() < 1e-5
    sidecar = out / "Floor-Noon+Panel.radiance.json"
    sidecar.rename(out / "Floor-Noon.radiance.json")
    sidecar.with_suffix(".exr").rename(out / "Floor-Noon.radiance.exr")
    with pytest.raises(InputError, match="light of Noon, Panel, not of object 'Floor', light of Noon:"):
        bake(out, replace(spec, lights=("Noon",), accumulate=True))


@pytest.mark.one_blender
def test_a_lamp_that_was_dimmed_is_refreshed_and_others_leave_it_alone(out: Path) -> None:
    floor(glow=0)
    spec = replace(SPEC, lights=("Noon",))
    before = bake(out, spec)
    bpy.data.objects["Evening"].data.energy = 50
    np.testing.assert_array_equal(bake(out, replace(spec, refresh=True)), before)
    bpy.data.objects["Noon"].data.energy /= 2
    np.testing.assert_allclose(
        bake(out, replace(spec, refresh=True))[..., :3], before[..., :3] / 2, rtol=1e-4
    )


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("Nobody", "there is no lamp or collection 'Nobody': the lamps that render are 'Evening', 'Noon'"),
        ("Floor", "there is no lamp or collection 'Floor'"),
        ("Panel", "lamp 'Panel' does not render: enable it"),
        ("Indoors", "collection 'Indoors' has no lamp that renders"),
    ],
)
def test_what_lights_nothing_is_named(out: Path, name: str, words: str) -> None:
    floor()
    bpy.data.objects["Panel"].hide_render = True
    with pytest.raises(InputError, match=words):
        bake(out, replace(SPEC, lights=("Noon", name)))
    assert not out.exists()


def test_without_lamps_or_with_a_word_for_a_name_there_is_no_each() -> None:
    with pytest.raises(InputError, match="the scene renders no lamp"):
        each_light(context.view_layer)
    floor()
    bpy.data.objects["Noon"].name = "world"
    with pytest.raises(InputError, match="lamp 'world' has a name that means something else"):
        each_light(context.view_layer)


@pytest.mark.one_blender
@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"lights": ("",)}, "a light's name is empty"),
        ({"kind": Kind.SHADOW}, "kind shadow cannot be baked for some lamps alone"),
        ({"kind": Kind.TRANSFER}, "kind transfer cannot be baked for some lamps alone"),
        ({"layers": (Layer.DIFFUSE,)}, "layers cannot be baked for some lamps alone"),
        (
            {"kind": Kind.INCIDENT, "capture": CaptureMethod.PANORAMIC},
            "capture panoramic cannot be baked for some lamps alone",
        ),
    ],
)
def test_what_has_no_lamps_of_its_own_is_refused(wrong: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        replace(SPEC, **{"lights": ("Noon",)} | wrong)


@pytest.mark.one_blender
def test_the_batch_bakes_each_lamp_and_goes_on_with_those_that_lack(tmp_path: Path, batch: Batch) -> None:
    floor()
    blend = tmp_path / "floor.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    out = tmp_path / "out"
    options = [
        "--object=Floor",
        "--layout=buckets",
        "--texels=4",
        "--bucket=4",
        "--samples=1",
        "--padding=0",
        f"--out={out}",
    ]
    asked = [
        str(blend),
        *options,
        "--lights=each",
        "--lights=Noon, Indoors",
        "--lights=all",
        "--progress=json",
    ]
    done = batch(*asked)
    assert done.code == 0, done.err
    names = ("Evening", "Noon", "Panel", "world", "Noon+Indoors")
    files = {name: out / f"Floor-{name}.radiance.json" for name in names}
    assert set(out.glob("*.json")) == {*files.values(), out / "Floor.radiance.json"}
    assert "Floor, light of Noon (2 of 6)" in done.out
    assert read_sidecar(files["Noon+Indoors"]).lights == ("Noon", "Indoors")
    first = files["Evening"].stat().st_mtime_ns
    atlas = files["Noon"].with_suffix(".exr")
    before = atlas.read_bytes()
    files["Noon"].unlink()
    atlas.unlink()
    again = batch(*asked, "--resume")
    assert again.code == 0, again.err
    assert files["Evening"].stat().st_mtime_ns == first, "a finished lamp is baked again"
    assert atlas.read_bytes() == before
    refused = batch(*asked)
    assert refused.code == 2
    assert "Floor-Evening.radiance" in refused.err


@pytest.mark.one_blender
def test_lights_are_read_from_lists(out: Path) -> None:
    floor()
    words = ["--lights=A", '--lights="B, C",D', "--frames=1,2"]
    request = parse(["a.blend", "--object=A", *words], inside_blender=False)
    assert request.bakes.lights == (("A",), ("B, C", "D"))
    found = request.bakes.specs(context.scene)
    assert [(spec.frame, spec.lights) for spec in found] == [
        (frame, lights) for frame in (1, 2) for lights in request.bakes.lights
    ]
    every = parse(["a.blend", "--object=A", "--lights=each", "--lights=all"], inside_blender=False)
    found = every.bakes.specs(context.scene)
    assert [spec.lights for spec in found] == [("Evening",), ("Noon",), ("Panel",), ("world",), ()]


@pytest.mark.one_blender
@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["--lights="], "--lights : give names of lamps"),
        (["--lights=A,,B"], "--lights A,,B: give names of lamps"),
        (["--lights=A,each"], "--lights A,each: all and each stand alone"),
        (["--lights=each", "--kind=shadow"], "kind shadow cannot be baked for some lamps alone"),
    ],
)
def test_lights_that_are_none_are_refused(words: list[str], complaint: str) -> None:
    with pytest.raises(InputError, match=complaint):
        parse(["a.blend", "--object=A", *words], inside_blender=False)


LAYERED = BakeSpec(layout=Layout.LAYERED, texels=8, samples=4, uv_layer="UVMap")
NOON = (1.5, 0.75, 0.375)  # irradiance on what faces the sun
COUNT = 64


def lit_floor(roughness: float = 1.0) -> None:
    """A floor under a sun, a panel, another sun that an empty instances, a world, and a thing that glows."""
    bpy.ops.mesh.primitive_plane_add(size=2)
    context.object.name = "Floor"
    material = stage.material("Floor", "ShaderNodeBsdfDiffuse", Color=(*WHITE, 1))
    if roughness < 1:
        material = stage.material("Floor", "ShaderNodeBsdfPrincipled", Roughness=roughness)
    context.object.data.materials.append(material)
    suns = {"Noon": [part / 3 for part in NOON], "Hidden": (1.0, 1.0, 1.0)}
    for name, colour in suns.items():
        bpy.ops.object.light_add(type="SUN")
        context.object.name = name
        context.object.data.energy, context.object.data.angle = 3, 0
        context.object.data.color = colour
    instanced = bpy.data.collections.new("Instanced")
    instanced.objects.link(context.object)
    context.scene.collection.objects.unlink(context.object)
    bpy.ops.object.empty_add()
    context.object.instance_type, context.object.instance_collection = "COLLECTION", instanced
    bpy.ops.object.light_add(type="AREA", location=(0, 0, 2))
    context.object.name = "Panel"
    context.object.data.size, context.object.data.energy = 1, 40
    bpy.ops.mesh.primitive_cube_add(size=0.4, location=(0, 1.5, 0.6))
    glow = stage.material("Glow", "ShaderNodeEmission", Color=(1, 1, 1, 1), Strength=5)
    context.object.data.materials.append(glow)
    stage.world((0.1, 0.2, 0.3))
    stage.clamps_off()


def lit(out: Path, lights: tuple[str, ...], unwraps: Unwraps | None = None) -> Floats:
    """Light (N, 3) at random places of the floor, to random viewers."""
    made = bake_object(context.scene, "Floor", replace(LAYERED, lights=lights), out, unwraps=unwraps)
    atlas, facts = read_layered(made.files.sidecar)
    assert facts.bake.lights == lights
    rng = np.random.default_rng(7)
    uv = rng.uniform(0.25, 0.75, (COUNT, 2))
    viewer = rng.normal(size=(COUNT, 3))
    viewer[:, 2] = np.abs(viewer[:, 2]) + 0.3
    viewer /= np.linalg.norm(viewer, axis=1, keepdims=True)
    place = np.concatenate([2 * uv - 1, np.zeros((COUNT, 1))], axis=1)
    x, up = np.tile([1.0, 0, 0], (COUNT, 1)), np.tile([0, 0, 1.0], (COUNT, 1))
    y = np.tile([0, 1.0, 0], (COUNT, 1))
    at = Fragments(uv, up, viewer, place, np.zeros(COUNT, dtype=int), x, y)
    return sample_layered(atlas, at.single())


def test_one_lamp_alone_gives_its_light_and_no_other_in_the_layered_layout(out: Path) -> None:
    lit_floor()
    before = fingerprint()
    found = lit(out, ("Noon",))
    assert differences(before, fingerprint()) == {}
    expected = np.array(WHITE) / pi * np.array(NOON)
    print(f"\noff by {np.abs(found / expected - 1).max():.1%}")
    assert np.abs(found / expected - 1).max() < 0.02


@pytest.mark.one_blender
def test_all_lamps_and_the_world_add_up_to_the_whole_in_the_layered_layout(out: Path) -> None:
    lit_floor(roughness=0.3)
    lights = each_light(context.view_layer)
    assert lights == (("Noon",), ("Panel",), ("world",))
    unwraps: Unwraps = {}
    parts = [lit(out, light, unwraps) for light in lights]
    whole = lit(out, (), unwraps)
    mean = np.sum([part.mean(axis=0) for part in parts], axis=0) / whole.mean(axis=0)
    print(f"\nthe sum of the means is {mean} of the whole's")
    assert min(part.mean() for part in parts) > 0.01
    assert np.abs(mean - 1).max() < 0.05


def test_what_another_file_lights_is_refused_and_nothing_is_left_dark(tmp_path: Path) -> None:
    lit_floor()
    library = tmp_path / "lamps.blend"
    cube = next(item for item in context.scene.objects if item.type == "MESH" and item.name != "Floor")
    bpy.data.libraries.write(str(library), {cube}, fake_user=True)
    bpy.data.objects.remove(cube)
    bpy.data.materials.remove(bpy.data.materials["Glow"])
    libraries: Any = bpy.data.libraries
    with libraries.load(str(library), link=True) as (there, taken):
        taken.objects = there.objects
    context.scene.collection.objects.link(taken.objects[0])
    before = fingerprint()
    words = "'Glow' of .*lamps.blend gives light, which cannot be left out of a bake of Noon alone"
    with (
        scratch_scene(context.scene) as scratch,
        pytest.raises(InputError, match=words),
        lit_by_lamps_alone(scratch, ("Noon",)),
    ):
        pass
    assert differences(before, fingerprint()) == {}


@pytest.mark.one_blender
def test_of_many_lamps_the_eight_brightest_are_mirrored(out: Path, caplog: pytest.LogCaptureFixture) -> None:
    """A bake that mirrors more than shaders take could not be exported."""
    bpy.ops.mesh.primitive_plane_add(size=2)
    context.object.name = "Floor"
    metal = stage.material("Floor", "ShaderNodeBsdfPrincipled", Metallic=1.0, Roughness=0.2)
    context.object.data.materials.append(metal)
    for number in range(12):
        bpy.ops.object.light_add(type="POINT", location=(2 * np.cos(number / 2), 2 * np.sin(number / 2), 2))
        context.object.data.energy = 10.0 * (1 + (5 * number) % 12)  # in no order
    stage.world((0.1, 0.1, 0.1))
    made = bake_object(context.scene, "Floor", replace(LAYERED, samples=16), out)
    atlas, facts = read_layered(made.files.sidecar)
    assert "12 lamps light the object: the 8 that give most light" in caplog.text
    found = [float(lamp.irradiance.sum()) for lamp in atlas.around.lamps]
    strengths = [1 + (5 * number) % 12 for number in range(12)]
    kept = [strength for strength in strengths if strength > 4]
    assert np.argsort(found).tolist() == np.argsort(kept).tolist(), "in the scene's order"
    assert definitions(facts)["RADTEX_LAMPS"] == MOST_LAMPS
