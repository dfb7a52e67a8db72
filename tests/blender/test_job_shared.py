# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes in the shared layout: files that read back, the right light, and a user's file as it was."""

from __future__ import annotations

import logging
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.bake import memory_limits
from radtex_addon.bake.progress import Stage
from radtex_addon.bake.spec import BakeSpec, Layout, Unwrap
from radtex_addon.core.arrays import Floats
from radtex_addon.core.errors import BakeError, InputError
from radtex_addon.core.frame import normalised
from radtex_addon.core.sampler import Filter
from radtex_addon.core.shared import Axis, SharedAtlas, sample_shared
from radtex_addon.cycles import shared_capture
from radtex_addon.formats.image_files import layer_path
from radtex_addon.formats.packing import layer_names
from radtex_addon.formats.shared_files import read_shared
from radtex_addon.forms.shared import bake as shared
from radtex_addon.job import BakeResult, bake_object, bake_steps, check_request
from radtex_addon.preview.node_group import MAX_PIXELS
from tests.blender import stage
from tests.blender.conftest import PlannedError
from tests.blender.fingerprint import differences, fingerprint
from tests.blender.lived_in import lived_in_scene
from tests.blender.shot import small_picture
from tests.blender.unfinished import take_pieces

pytestmark = pytest.mark.usefixtures("temporary")
context: Any = bpy.context  # to the stubs, every pointer may be None

TINY = BakeSpec(layout=Layout.SHARED, texels=8, bucket=4, samples=1)
TINT = (0.8, 0.4, 0.2)


def card(shader: str = "ShaderNodeBsdfDiffuse", name: str = "Card", **inputs: object) -> Any:
    """A square of 2 x 2 on z = 0, tinted."""
    bpy.ops.mesh.primitive_plane_add(size=2)
    made = context.object
    made.name = name
    made.data.materials.append(stage.material(name, shader, Color=(*TINT, 1), **inputs))
    return made


def mirror() -> Any:
    return card("ShaderNodeBsdfAnisotropic", Roughness=0.0)


def bake(name: str, spec: BakeSpec, out: Path, **options: Any) -> BakeResult:
    return bake_object(context.scene, name, spec, out, **options)


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()} if folder.exists() else set()


def files_of(name: str, *axes: Axis) -> set[str]:
    """What a bake leaves whose light has these lobes."""
    sidecar = Path(f"{name}.radiance.json")
    return {sidecar.name, *(layer_path(sidecar, layer).name for layer in layer_names(axes))}


def seen(atlas: SharedAtlas, viewer: tuple[float, float, float], part: float = 1.0) -> Floats:
    """What a viewer in this direction sees of the middle `part` of a card that looks up: (K, 3)."""
    height, width = atlas.irradiance.shape[:2]
    across, along = np.meshgrid((np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height)
    uv = (0.5 + part * (np.stack([across.ravel(), along.ravel()], axis=1) - 0.5)).astype(np.float32)
    up = np.tile(np.array([0, 0, 1], dtype=np.float32), (len(uv), 1))
    towards = np.tile(normalised(np.array([viewer], dtype=float)).astype(np.float32), (len(uv), 1))
    return sample_shared(atlas, uv, up, towards)


# files


def test_a_bake_writes_the_contracts_files_and_nothing_else(out: Path) -> None:
    stage.world()
    mirror()
    result = bake("Card", TINY, out)
    assert names(out) == files_of("Card", Axis.MIRROR) == {path.name for path in result.files.all}
    atlas, sidecar = read_shared(out / "Card.radiance.json")
    facts = sidecar.bake
    assert (facts.object_name, facts.kind, facts.capture) == ("Card", "radiance", "portal")
    assert (facts.bucket, facts.samples, facts.seed, facts.uv_map) == (4, 1, 0, "RadTex")
    assert (result.layout.width, result.layout.height, result.layout.bucket) == (facts.width, facts.height, 4)
    assert atlas.colour.shape == (4 * facts.height, 4 * facts.width, 3)
    rays = TINY.rays
    once = result.covered_texels * rays.of_texel + 2 * rays.size**2 * rays.panorama
    assert (
        once < result.paths < 1.1 * once + 16 * result.covered_texels * 6
    )  # the colour's, and hidden cells'
    assert set(result.seconds) >= {Stage.UNWRAP, Stage.CAPTURE, Stage.FIT, Stage.WRITE}


def test_the_same_seed_gives_the_same_files_and_another_one_others(out: Path) -> None:
    stage.lamps()
    card("ShaderNodeBsdfAnisotropic", Roughness=0.3)
    bakes = []
    for index, seed in enumerate((3, 3, 4)):
        spec = BakeSpec(layout=Layout.SHARED, texels=8, bucket=4, samples=1, seed=seed)
        files = bake("Card", spec, out / str(index)).files
        bakes.append([path.read_bytes() for path in files.images])
    assert bakes[0] == bakes[1]
    assert bakes[0] != bakes[2]


def test_what_is_there_is_kept_unless_it_may_go(out: Path) -> None:
    """Every image that the layout can have counts, whether or not the new bake has it."""
    stage.world()
    mirror()
    out.mkdir()
    for name in sorted(files_of("Card", *Axis)):
        (out / name).write_text("mine")
        with pytest.raises(InputError, match=rf"{name} is already there: overwrite it"):
            bake("Card", TINY, out)
        assert [path.read_text() for path in out.iterdir()] == ["mine"]
        (out / name).unlink()
    for name in (*files_of("Card", *Axis), "Card.radiance.exr"):
        (out / name).write_text("mine")
    bake("Card", TINY, out, overwrite=True)
    assert names(out) == files_of("Card", Axis.MIRROR) | {"Card.radiance.exr"}
    assert read_shared(out / "Card.radiance.json")[1].lobes == (Axis.MIRROR,)
    assert (out / "Card.radiance.exr").read_text() == "mine", "the plain layout's is none of this bake's"


# values


@pytest.mark.parametrize("glossy", [False, True])
def test_a_furnace_reads_back_as_its_albedo(out: Path, glossy: bool) -> None:
    stage.world((1, 2, 3))
    mirror() if glossy else card()
    bake("Card", TINY, out)
    atlas, _ = read_shared(out / "Card.radiance.json")
    expected = np.array(TINT) * [1, 2, 3]
    for viewer in ((0, 0, 1), (1, 0, 1), (-1, 2, 1)):
        light = seen(atlas, viewer)
        np.testing.assert_allclose(light, np.broadcast_to(expected, light.shape), rtol=2e-2)


def test_a_mirror_shows_the_sky_where_it_is(out: Path) -> None:
    """Red to the east, green to the west: a viewer in the west sees the east."""
    world = stage.world()
    tree = world.node_tree
    direction = tree.nodes.new("ShaderNodeTexCoord").outputs["Generated"]
    apart, east, west, both = (
        tree.nodes.new(f"ShaderNode{kind}") for kind in ("SeparateXYZ", "Math", "Math", "CombineXYZ")
    )
    tree.links.new(direction, apart.inputs[0])
    for side, operation, socket in ((east, "GREATER_THAN", 0), (west, "LESS_THAN", 1)):
        side.operation, side.inputs[1].default_value = operation, 0
        tree.links.new(apart.outputs["X"], side.inputs[0])
        tree.links.new(side.outputs[0], both.inputs[socket])
    background = next(node for node in tree.nodes if node.type == "BACKGROUND")
    tree.links.new(both.outputs[0], background.inputs["Color"])
    mirror()
    bake("Card", BakeSpec(layout=Layout.SHARED, texels=8, bucket=8, samples=4), out)
    atlas, _ = read_shared(out / "Card.radiance.json")
    np.testing.assert_allclose(seen(atlas, (-1, 0, 1)).mean(axis=0), [TINT[0], 0, 0], atol=3e-2)
    np.testing.assert_allclose(seen(atlas, (1, 0, 1)).mean(axis=0), [0, TINT[1], 0], atol=3e-2)


def test_glass_has_a_lobe_of_its_own(out: Path) -> None:
    stage.world()
    card("ShaderNodeBsdfRefraction", Roughness=0.0, IOR=1.3)
    bake("Card", TINY, out)
    assert names(out) == files_of("Card", Axis.THROUGH)
    atlas, _ = read_shared(out / "Card.radiance.json")
    light = seen(atlas, (1, 0, 2))
    np.testing.assert_allclose(light, np.broadcast_to(TINT, light.shape), rtol=2e-2)


def test_a_scene_without_light_bakes_black_with_a_warning(
    out: Path, caplog: pytest.LogCaptureFixture
) -> None:
    mirror()
    with caplog.at_level(logging.WARNING):
        bake("Card", TINY, out)
    assert "scene 'Scene' has no light" in caplog.text
    assert not seen(read_shared(out / "Card.radiance.json")[0], (0, 0, 1)).any()


def test_the_named_view_layer_is_the_one_that_is_baked(out: Path) -> None:
    stage.world()
    mirror()
    lid = card("ShaderNodeEmission", "Lid")
    lid.location.z, lid.scale = 0.5, (40, 40, 1)
    lids = bpy.data.collections.new("lids")
    context.scene.collection.children.link(lids)
    lids.objects.link(lid)
    context.scene.collection.objects.unlink(lid)
    context.scene.view_layers.new("bare").layer_collection.children["lids"].exclude = True
    for layer, expected in (("bare", np.array(TINT)), (None, np.array(TINT) ** 2)):
        bake("Card", TINY, out, view_layer=layer, overwrite=True)
        light = seen(read_shared(out / "Card.radiance.json")[0], (0, 0, 1))
        np.testing.assert_allclose(light.mean(axis=0), expected, atol=3e-2)


# requests


def test_a_preview_that_no_gpu_takes_is_refused_before_the_bake(
    out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(memory_limits, "physical_memory", lambda: None)
    card()
    fits = BakeSpec(layout=Layout.SHARED, texels=MAX_PIXELS // 32, bucket=30, samples=1)
    assert check_request(context.scene, "Card", fits, out, True, False)
    large = BakeSpec(layout=Layout.SHARED, texels=MAX_PIXELS // 32 + 1, bucket=30, samples=1)
    with pytest.raises(InputError, match="'mirror_ends' has 16416 x 16416 pixels and cannot be previewed"):
        check_request(context.scene, "Card", large, out, True, False)
    assert check_request(context.scene, "Card", large, out, False, False)


# progress


def test_stages_come_in_order_and_each_once(out: Path) -> None:
    stage.world()
    card()
    steps = list(bake_steps(context.scene, "Card", TINY, out, preview=Filter.LINEAR))
    stages = list(dict.fromkeys(step.stage for step in steps))
    assert stages == [stage for stage in Stage if stage not in (Stage.FILL, Stage.CONDENSE)]
    order = [stages.index(step.stage) for step in steps]
    assert order == sorted(order)
    rendered = [step for step in steps if step.stage is Stage.CAPTURE]
    assert len(rendered) > 4
    assert [step.done for step in rendered] == sorted(step.done for step in rendered)
    assert rendered[0].done == 0
    assert rendered[-1].done == rendered[-1].total
    assert all(0 <= step.done <= step.total for step in steps)


# the user's file


def test_the_users_file_is_what_it_was_after_a_bake(out: Path) -> None:
    """With a parent, animation, a second scene; instances, shared collections and hidden things besides."""
    head = lived_in_scene()
    head.name, head.pass_index = "Head", 7
    shared_by = bpy.data.collections.new("shared")
    context.scene.collection.children.link(shared_by)
    shared_by.objects.link(head)
    near = card("ShaderNodeEmission", "Near")
    shared_by.objects.link(near)
    near.pass_index = 3
    bpy.ops.object.collection_instance_add(collection="shared", location=(5, 0, 0))
    card(name="Hidden").hide_render = True
    before = fingerprint()
    spec = BakeSpec(layout=Layout.SHARED, texels=48, bucket=2, samples=1, unwrap=Unwrap.BLENDER)
    bake("Head", spec, out)
    assert differences(before, fingerprint()) == {}
    assert "Head.radiance.json" in names(out)


def drop_at(stage: Stage, out: Path, done: int = 0) -> None:
    """Bake the card until so many parts of a stage are done, and drop it there."""
    steps = bake_steps(context.scene, "Card", TINY, out, preview=Filter.LINEAR)
    for step in steps:
        if step.stage is stage and step.done >= done:
            steps.close()
            return
    pytest.fail(f"the bake was over without {stage}")


def test_the_users_file_is_what_it_was_wherever_the_bake_is_dropped(out: Path) -> None:
    stage.world()
    mirror()
    before = fingerprint()
    for until, done in (
        (Stage.CAPTURE, 1),  # amid the paths' ends
        (Stage.CAPTURE, 100_000),  # after the panorama
        (Stage.FIT, 0),
    ):
        drop_at(until, out, done)
        assert take_pieces(out)
        assert differences(before, fingerprint()) == {}, until
        assert not out.exists(), until
    drop_at(Stage.PREVIEW, out)
    assert take_pieces(out)
    assert differences(before, fingerprint()) == {}
    assert names(out) == files_of("Card", Axis.MIRROR)


def test_the_users_file_is_what_it_was_whatever_fails(out: Path) -> None:
    def fail(*_: object, **__: object) -> None:
        raise PlannedError

    stage.world()
    mirror()
    before = fingerprint()
    parts = {
        "capture_surroundings": shared_capture,
        "capture_samples": shared_capture,
        "fit_shared": shared,
        "write_shared": shared,
    }
    for part, module in parts.items():
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(module, part, fail)
            with pytest.raises(PlannedError):
                bake("Card", TINY, out, preview=Filter.LINEAR)
        assert take_pieces(out)
        assert differences(before, fingerprint()) == {}, part
        assert not out.exists(), part


def test_a_bake_that_cannot_be_written_leaves_the_one_before(
    out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    stage.world()
    mirror()
    bake("Card", TINY, out)
    before = {path.name: path.read_bytes() for path in out.iterdir()}

    def full(*_: object) -> None:
        raise BakeError("the disk is full")

    monkeypatch.setattr("radtex_addon.formats.image_files.write_rows", full)
    with pytest.raises(BakeError, match="full"):
        bake("Card", BakeSpec(layout=Layout.SHARED, texels=4, bucket=4, samples=1), out, overwrite=True)
    assert take_pieces(out)
    assert {path.name: path.read_bytes() for path in out.iterdir()} == before


# the preview


def rendered_view(folder: Path, place: tuple[float, float, float]) -> Floats:
    """What a far camera at `place` that looks at the origin sees in the open file: (8, 8, 3)."""
    scene = context.scene
    lens = bpy.data.cameras.new("eye")
    lens.type, lens.ortho_scale = "ORTHO", 0.5
    camera = bpy.data.objects.new("eye", lens)
    camera.location = place
    target = bpy.data.objects.new("target", None)
    for item in (camera, target):
        scene.collection.objects.link(item)
    track: Any = camera.constraints.new("TRACK_TO")
    track.target = target
    scene.camera = camera
    return small_picture(scene, folder)[..., :3]


def test_the_preview_shows_what_the_sampler_sees(out: Path, tmp_path: Path) -> None:
    """A rough mirror under a bright lamp to the east, from both sides."""
    stage.world((0.2, 0.2, 0.2))
    lamp = card("ShaderNodeEmission", "Lamp", Strength=5.0)
    lamp.location, lamp.rotation_euler = (3, 0, 3), (0, 0.785, 0)
    card("ShaderNodeBsdfAnisotropic", Roughness=0.3)
    spec = BakeSpec(layout=Layout.SHARED, texels=8, bucket=8, samples=4)
    bake("Card", spec, out, preview=Filter.LINEAR)
    atlas, _ = read_shared(out / "Card.radiance.json")
    bpy.ops.wm.open_mainfile(filepath=str(out / "Card.preview.blend"))
    shown = context.scene.objects["Card"]
    assert shown.data.uv_layers.active.name == "RadTex"
    paths = {image.filepath for image in bpy.data.images if image.source == "FILE"}
    assert paths == {f"//{name}" for name in files_of("Card", Axis.MIRROR) if name.endswith(".exr")}
    bpy.data.objects.remove(context.scene.objects["Lamp"])
    context.scene.world = None  # what is seen comes from the atlas alone
    bright = {}
    for place in ((-5, 0, 5), (5, 0, 5)):
        light = seen(atlas, place, part=0.25)
        view = rendered_view(tmp_path, place).reshape(-1, 3)
        np.testing.assert_allclose(np.median(view, axis=0), np.median(light, axis=0), rtol=0.1)
        bright[place] = view.mean()
    assert bright[-5, 0, 5] > 3 * bright[5, 0, 5], "the lamp's reflection"
