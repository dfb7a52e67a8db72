# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The whole job on tiny scenes: right files with right values, and a user's file that is what it was."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.bake import session
from radtex_addon.bake.plan import Tile
from radtex_addon.bake.progress import Stage
from radtex_addon.core.arrays import Floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.errors import BakeError, InputError
from radtex_addon.core.sampler import Filter
from radtex_addon.cycles import portal
from radtex_addon.cycles.portal import PortalCapture
from radtex_addon.formats.containers import exr_rows
from radtex_addon.formats.containers.exr import read_atlas
from radtex_addon.formats.sidecar import read_sidecar
from radtex_addon.forms.buckets import bake as buckets
from radtex_addon.job import BakeResult, bake_object, bake_steps, check_request
from radtex_addon.job import baking as run
from radtex_addon.prepare import prepared as prepare
from radtex_addon.prepare import unwrapping
from radtex_addon.settings.spec import BakeSpec, CaptureMethod, Compression, Kind, Unwrap
from radtex_addon.version import VERSION
from tests.blender import stage
from tests.blender.conftest import PlannedError
from tests.blender.fingerprint import differences, fingerprint
from tests.blender.lived_in import lived_in_scene
from tests.blender.shot import small_picture
from tests.blender.unfinished import take_pieces

pytestmark = pytest.mark.usefixtures("temporary")
context: Any = bpy.context  # to the stubs, every pointer may be None

TINY = BakeSpec(texels=8, bucket=2, samples=1)
WHITE = (0.8, 0.8, 0.8, 1)


def card(name: str = "Card", colour: tuple[float, ...] = WHITE, at: tuple[float, ...] = (0, 0, 0)) -> Any:
    """A square of 2 x 2 with Blender's own UV layer, "UVMap", diffuse."""
    bpy.ops.mesh.primitive_plane_add(size=2, location=at)
    made = context.object
    made.name = name
    made.data.materials.append(stage.material(name, "ShaderNodeBsdfDiffuse", Color=colour))
    return made


def glowing(name: str, colour: tuple[float, ...], at: tuple[float, ...]) -> Any:
    made = card(name, at=at)
    made.data.materials[0] = stage.material(name, "ShaderNodeEmission", Color=(*colour, 1))
    return made


def bake(name: str, spec: BakeSpec, out: Path, **options: Any) -> BakeResult:
    return bake_object(context.scene, name, spec, out, **options)


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()} if folder.exists() else set()


def pixels_of(result: BakeResult) -> Floats:
    pixels, _ = read_atlas(result.files.atlas)
    return pixels.astype(np.float32)


# files


def test_a_bake_writes_the_contracts_files_and_nothing_else(out: Path) -> None:
    stage.world()
    card()
    spec = BakeSpec(texels=8, bucket=4, samples=2, seed=7, unwrap=Unwrap.UVUNWRAP)
    result = bake("Card", spec, out)
    assert names(out) == {"Card.radiance.exr", "Card.radiance.json"}
    assert result.files.all == (out / "Card.radiance.exr", out / "Card.radiance.json")
    pixels, header = read_atlas(result.files.atlas)
    sidecar = read_sidecar(result.files.sidecar)
    assert header == sidecar
    assert (sidecar.object_name, sidecar.kind, sidecar.capture) == ("Card", "radiance", "portal")
    assert (sidecar.bucket, sidecar.samples, sidecar.seed) == (4, 2, 7)
    assert max(sidecar.width, sidecar.height) == 8
    assert (sidecar.uv_map, sidecar.layers, sidecar.clamped) == ("RadTex", (), 0)
    assert (sidecar.tool, sidecar.blender) == (f"RadTex {VERSION}", bpy.app.version_string)
    assert pixels.shape == (sidecar.height * 4, sidecar.width * 4, 4)
    assert pixels.dtype == np.float16
    assert result.layout == AtlasLayout(sidecar.width, sidecar.height, 4)
    assert result.paths == result.covered_texels * 16 * 2
    assert set(result.seconds) >= {Stage.UNWRAP, Stage.CAPTURE, Stage.WRITE}
    facts = json.loads(result.files.sidecar.read_text())
    assert facts["version"] == 1
    assert facts["color_space"] == "Linear Rec.709"


@pytest.mark.parametrize(
    ("half", "dtype", "compression"),
    [
        (False, np.float32, Compression.ZIP),
        (True, np.float16, Compression.PIZ),
        (True, np.float16, Compression.DWAA),
    ],
)
def test_a_furnace_reads_back_as_its_albedo_in_every_pixel(
    out: Path, half: bool, dtype: type, compression: Compression
) -> None:
    stage.world()
    card()
    spec = BakeSpec(texels=8, bucket=4, samples=4, half=half, compression=compression)
    pixels, _ = read_atlas(bake("Card", spec, out).files.atlas)
    assert pixels.dtype == dtype
    exact = 5e-3 if compression is Compression.DWAA else 2.5e-4  # half floats near 0.8 are 4.9e-4 apart
    np.testing.assert_allclose(pixels[..., :3].astype(float), 0.8, atol=exact)  # gutters included
    np.testing.assert_allclose(pixels[..., 3].astype(float), 1.0, atol=exact)


def test_a_relative_folder_is_below_the_current_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    stage.world()
    card()
    monkeypatch.chdir(tmp_path)
    bake("Card", TINY, Path("some/where"), preview=Filter.NEAREST)
    assert names(tmp_path / "some" / "where") == {
        "Card.radiance.exr",
        "Card.radiance.json",
        "Card.preview.blend",
    }
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "some" / "where" / "Card.preview.blend"))
    atlas = next(image for image in bpy.data.images if image.source == "FILE")
    assert atlas.filepath == "//Card.radiance.exr"


@pytest.mark.one_blender
def test_a_preview_never_replaces_the_file_that_is_baked(out: Path) -> None:
    stage.world()
    card()
    out.mkdir()
    bpy.ops.wm.save_as_mainfile(filepath=str(out / "Card.preview.blend"))
    before = (out / "Card.preview.blend").read_bytes()
    with pytest.raises(InputError, match=r"Card\.preview\.blend is the open file"):
        bake("Card", TINY, out, preview=Filter.NEAREST, overwrite=True)
    assert (out / "Card.preview.blend").read_bytes() == before
    bake("Card", TINY, out)  # without a preview nothing is at stake


# values


def uv_light(made: Any, layer: str) -> None:
    """Let an object glow in the colours (u, v, 0) of a UV layer."""
    material = stage.material("uv", "ShaderNodeEmission")
    tree = material.node_tree
    uv = tree.nodes.new("ShaderNodeUVMap")
    uv.uv_map = layer
    emission = next(node for node in tree.nodes if node.type == "EMISSION")
    tree.links.new(uv.outputs[0], emission.inputs["Color"])
    made.data.materials[0] = material


def test_the_users_uv_layer_decides_where_texels_lie(out: Path) -> None:
    made = card()
    uv_light(made, "UVMap")
    result = bake("Card", BakeSpec(texels=8, bucket=2, samples=16, uv_layer="UVMap"), out)
    assert read_sidecar(result.files.sidecar).uv_map == "UVMap"
    assert (result.layout.width, result.layout.height, result.covered_texels) == (8, 8, 64)
    buckets = result.layout.to_buckets(pixels_of(result))
    centre = (np.arange(8) + 0.5) / 8
    for j in range(8):
        for i in range(8):
            np.testing.assert_allclose(buckets[j, i, ..., 0], centre[i], atol=1e-3)
            np.testing.assert_allclose(buckets[j, i, ..., 1], centre[j], atol=1e-3)


def test_a_layer_of_our_own_shows_the_same_light_at_the_same_place(out: Path) -> None:
    """The object glows by its own UVs; the atlas has others, and the preview's mesh tells both."""
    made = card()
    uv_light(made, "UVMap")
    spec = BakeSpec(texels=16, bucket=2, samples=1, unwrap=Unwrap.UVUNWRAP)
    bake("Card", spec, out, preview=Filter.NEAREST)
    bpy.ops.wm.open_mainfile(filepath=str(out / "Card.preview.blend"))
    mesh: Any = bpy.data.objects["Card"].data
    ours, theirs = (
        np.array([tuple(corner.uv) for corner in mesh.uv_layers[name].data]) for name in ("RadTex", "UVMap")
    )
    pixels, sidecar = read_atlas(out / "Card.radiance.exr")
    texel = AtlasLayout(sidecar.width, sidecar.height, 2).to_buckets(pixels.astype(np.float32))[:, :, 0, 0]
    inside = 0.5 * ours + 0.5 * ours.reshape(-1, 3, 2).mean(axis=1).repeat(3, axis=0)
    where = 0.5 * theirs + 0.5 * theirs.reshape(-1, 3, 2).mean(axis=1).repeat(3, axis=0)
    i, j = (inside * [sidecar.width, sidecar.height]).astype(int).T
    np.testing.assert_allclose(texel[j, i, :2], where, atol=1.0 / min(sidecar.width, sidecar.height))


@pytest.mark.parametrize("capture", list(CaptureMethod))
@pytest.mark.parametrize("kind", [Kind.INCIDENT, Kind.REFLECTION])
def test_light_kinds_bake_the_world_by_either_capture(out: Path, kind: Kind, capture: CaptureMethod) -> None:
    stage.world((0.25, 0.5, 2.0))
    card()
    spec = BakeSpec(kind=kind, capture=capture, texels=4, bucket=4, samples=4)
    result = bake("Card", spec, out)
    assert names(out) == {f"Card.{kind}.exr", f"Card.{kind}.json"}
    assert read_sidecar(result.files.sidecar).capture == capture
    pixels = pixels_of(result)
    noise = 1e-3 if capture is CaptureMethod.PORTAL else 0.25  # 4 samples of the disc's rim are few
    np.testing.assert_allclose(pixels, np.broadcast_to([0.25, 0.5, 2.0, 1.0], pixels.shape), rtol=noise)
    np.testing.assert_allclose(pixels.mean(axis=(0, 1)), [0.25, 0.5, 2.0, 1.0], rtol=noise / 5)


def test_kinds_of_one_object_lie_side_by_side(out: Path) -> None:
    stage.world()
    card()
    card("Content", at=(0, 0, 0))
    for kind in Kind:
        bake("Card", BakeSpec(kind=kind, texels=4, bucket=2, samples=1), out)
    assert names(out) == {f"Card.{kind}.{ending}" for kind in Kind for ending in ("exr", "json")}


def soft_shadow() -> None:
    card()
    stage.lamps()


def test_the_same_seed_gives_the_same_file_and_another_one_another(out: Path) -> None:
    soft_shadow()
    files = [
        bake(
            "Card", BakeSpec(texels=8, bucket=2, samples=1, seed=seed), out / str(k)
        ).files.atlas.read_bytes()
        for k, seed in enumerate((3, 3, 4))
    ]
    assert files[0] == files[1]
    assert files[0] != files[2]


@pytest.mark.one_blender
def test_tiles_do_not_change_the_bits(out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    soft_shadow()
    whole = bake("Card", TINY, out / "whole").files.atlas.read_bytes()
    monkeypatch.setattr(session, "SECONDS_PER_TILE", 0.0)
    rendered = counted(monkeypatch)
    assert bake("Card", TINY, out / "rows").files.atlas.read_bytes() == whole
    assert len(rendered) > 4
    assert {tile.rows for tile in rendered} == {1}


def counted(monkeypatch: pytest.MonkeyPatch, fail_at: int | None = None) -> list[Tile]:
    """The tiles that the capture of the bake renders from now on; the `fail_at`-th raises PlannedError."""
    rendered: list[Tile] = []
    render = PortalCapture.render

    class Counted(PortalCapture):
        def render(self, tile: Tile) -> Floats:
            rendered.append(tile)
            if len(rendered) - 1 == fail_at:
                raise PlannedError
            return render(self, tile)

    monkeypatch.setattr(buckets, "PortalCapture", Counted)
    return rendered


def test_the_rim_of_an_open_mesh_shows_the_mesh(out: Path) -> None:
    """Texels lie exactly on the rim; with another object in the scene, Cycles's rays there used to miss."""
    glowing("Card", (1, 1, 1), (0, 0, 0))
    card("Other", at=(5, 0, 0))
    stage.world((0, 0, 0))
    for kind in (Unwrap.XATLAS, Unwrap.BLENDER):
        spec = BakeSpec(texels=8, bucket=4, samples=2, unwrap=kind, half=False)
        pixels = pixels_of(bake("Card", spec, out, overwrite=True))
        np.testing.assert_array_equal(pixels, np.ones_like(pixels))


def test_the_named_view_layer_is_the_one_that_is_baked(out: Path) -> None:
    stage.world()
    card()
    lid = glowing("Lid", (3, 0, 0), (0, 0, 0.1))
    lid_only = bpy.data.collections.new("lids")
    context.scene.collection.children.link(lid_only)
    lid_only.objects.link(lid)
    context.scene.collection.objects.unlink(lid)
    bare = context.scene.view_layers.new("bare")
    bare.layer_collection.children["lids"].exclude = True
    shut = bake("Card", TINY, out / "shut")
    opened = bake("Card", TINY, out / "open", view_layer="bare")
    assert pixels_of(shut)[..., 0].mean() > 1.2, "lit by the lid"
    np.testing.assert_allclose(pixels_of(opened)[..., :3], 0.8, atol=2e-3)


def test_the_named_view_layer_is_the_one_that_is_checked(out: Path) -> None:
    card()
    lit = bpy.data.collections.new("lit")
    context.scene.collection.children.link(lit)
    lit.objects.link(bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN")))
    dark = context.scene.view_layers.new("dark")
    dark.layer_collection.children["lit"].exclude = True
    dark.update()
    assert check_request(context.scene, "Card", TINY, out, False, False) == []
    (warning,) = check_request(context.scene, "Card", TINY, out, False, False, "dark")
    assert "has no light" in str(warning)
    with pytest.raises(InputError, match=r"has no view layer 'nowhere': it has '.*', 'dark'"):
        bake("Card", TINY, out, view_layer="nowhere")


# progress


# the user's file


def preferences() -> dict[str, object]:
    """What a bake could change in Blender's preferences."""
    cycles = context.preferences.addons["cycles"].preferences
    return {
        "type": cycles.compute_device_type,
        "devices": [(device.id, device.type, device.use) for device in cycles.devices],
        "dirty": context.preferences.is_dirty,
    }


def lived_in() -> Any:
    head = lived_in_scene()
    head.name = "Head"
    context.scene.render.engine = "BLENDER_EEVEE" if bpy.app.version >= (5, 0, 0) else "BLENDER_EEVEE_NEXT"
    return head


QUICK = BakeSpec(texels=64, bucket=2, samples=1, unwrap=Unwrap.BLENDER)


def test_the_users_file_is_what_it_was_after_a_bake_with_a_preview(out: Path) -> None:
    lived_in()
    before, preferred = fingerprint(), preferences()
    bake("Head", QUICK, out, preview=Filter.QUADRILINEAR)
    assert names(out) == {"Head.radiance.exr", "Head.radiance.json", "Head.preview.blend"}
    assert differences(before, fingerprint()) == {}
    assert preferences() == preferred


@pytest.mark.one_blender
def test_the_users_file_is_what_it_was_whatever_fails(out: Path) -> None:
    def fail(*_: object, **__: object) -> None:
        raise PlannedError

    made = card()
    made.modifiers.new("Thick", "SOLIDIFY")
    stage.world()
    before, preferred = fingerprint(), preferences()
    parts: dict[str, Any] = {
        "evaluate": prepare,
        "unwrap_steps": unwrapping,
        "rasterise": prepare,
        "find_hidden": prepare,
        "render": PortalCapture,
        "write_bands": buckets,
        "save_preview_of": run,
    }
    for part, module in parts.items():
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(module, part, fail)
            with pytest.raises(PlannedError):
                bake("Card", QUICK, out, preview=Filter.NEAREST)
        take_pieces(out)
        assert differences(before, fingerprint()) == {}, part
        assert preferences() == preferred, part
        whole = {"Card.radiance.exr", "Card.radiance.json"} if part == "save_preview_of" else set()
        assert names(out) == whole, part


def drop_at(stage: Stage, out: Path, done: int = 0) -> None:
    """Bake the head until so many parts of a stage are done, and drop it there."""
    steps = bake_steps(context.scene, "Head", QUICK, out, preview=Filter.NEAREST)
    for step in steps:
        if step.stage is stage and step.done >= done:
            steps.close()
            return
    pytest.fail(f"the bake was over without {stage}")


def test_the_users_file_is_what_it_was_at_whatever_stage_the_bake_is_dropped(out: Path) -> None:
    stage.world()
    card("Head")
    before, preferred = fingerprint(), preferences()
    for until in (one for one in Stage if one not in (Stage.SURROUNDINGS, Stage.DENOISE, Stage.FIT)):
        drop_at(until, out, done=int(until is Stage.CAPTURE))
        take_pieces(out)
        assert differences(before, fingerprint()) == {}, until
        assert preferences() == preferred, until
        whole = {"Head.radiance.exr", "Head.radiance.json"} if until is Stage.PREVIEW else set()
        assert names(out) == whole, until


@pytest.mark.one_blender
def test_a_file_that_was_there_survives_a_bake_that_fails(out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    stage.world()
    card()
    bake("Card", TINY, out)
    before = {path.name: path.read_bytes() for path in out.iterdir()}
    counted(monkeypatch, fail_at=0)
    with pytest.raises(PlannedError):
        bake("Card", BakeSpec(texels=4, bucket=2, samples=1), out, overwrite=True)
    assert take_pieces(out)
    assert {path.name: path.read_bytes() for path in out.iterdir()} == before


@pytest.mark.one_blender
def test_an_atlas_never_lies_beside_another_ones_sidecar(out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    stage.world()
    card()
    bake("Card", TINY, out)

    def full(*_: object) -> None:
        raise OSError("the disk is full")

    monkeypatch.setattr(exr_rows.BandWriter, "write", full)
    with pytest.raises(BakeError, match="full"):
        bake("Card", BakeSpec(texels=4, bucket=2, samples=1), out, overwrite=True)
    assert take_pieces(out)
    assert names(out) == {"Card.radiance.exr", "Card.radiance.json"}
    assert read_atlas(out / "Card.radiance.exr")[1] == read_sidecar(out / "Card.radiance.json")


@pytest.mark.one_blender
def test_what_cycles_refuses_is_a_failure_of_the_bake(out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    stage.world()
    card()
    before = fingerprint()
    monkeypatch.setattr(portal, "camera_above", lambda *_: None)
    with pytest.raises(BakeError, match="no camera") as raised:
        bake("Card", replace(TINY, unwrap=Unwrap.UVUNWRAP), out)
    assert "\n" not in str(raised.value)
    assert differences(before, fingerprint()) == {}
    assert take_pieces(out)
    assert not out.exists()


# the preview


def rendered_view(folder: Path) -> Floats:
    """What a camera above the origin sees in the open file: (8, 8, 4)."""
    scene = context.scene
    camera = bpy.data.objects.new("eye", bpy.data.cameras.new("eye"))
    camera.location = (0, 0, 2)
    scene.collection.objects.link(camera)
    scene.camera = camera
    return small_picture(scene, folder)


def test_the_preview_stands_in_the_objects_place_and_finds_its_atlas(out: Path, tmp_path: Path) -> None:
    stage.world()
    made = card()
    made.modifiers.new("Subdivision", "SUBSURF").subdivision_type = "SIMPLE"
    card("Neighbour", at=(5, 0, 0))
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "user.blend"))
    things = {item.name for item in context.scene.objects}
    spec = BakeSpec(texels=16, bucket=2, samples=4, unwrap=Unwrap.UVUNWRAP)
    bake("Card", spec, out, preview=Filter.NEAREST)
    elsewhere = tmp_path / "elsewhere"
    shutil.move(out, elsewhere)
    bpy.ops.wm.open_mainfile(filepath=str(elsewhere / "Card.preview.blend"))
    assert {item.name for item in context.scene.objects} == things
    shown: Any = context.scene.objects["Card"]
    assert not shown.modifiers
    assert shown.data.uv_layers.active.name == "RadTex"
    atlas: Any = next(image for image in bpy.data.images if image.source == "FILE")
    assert atlas.filepath == "//Card.radiance.exr"
    assert tuple(atlas.size) != (0, 0)
    assert [scene.name for scene in bpy.data.scenes] == ["Scene"]
    for light in list(context.scene.objects):
        if light.name != "Card":
            bpy.data.objects.remove(light)
    context.scene.world = None  # what is seen comes from the atlas alone
    np.testing.assert_allclose(rendered_view(tmp_path)[..., :3], 0.8, atol=5e-3)
