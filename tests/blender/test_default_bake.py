# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the batch and the button bake where nobody names a layout: small bakes, from end to end."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.bake.progress import Stage
from radtex_addon.core import large_arrays
from radtex_addon.core.octahedron import cell_directions
from radtex_addon.formats.containers.exr import read_buckets
from radtex_addon.forms.layered.files.layered_files import read_layered
from radtex_addon.forms.layered.lookup.atlas import look_up
from radtex_addon.job import bake_object, bake_steps
from radtex_addon.settings import rays
from radtex_addon.settings.choices import Backs
from radtex_addon.settings.spec import BakeSpec, Layout, Unwrap
from radtex_addon.ui.panel import panel_state
from radtex_addon.ui.panel.main_panel import RADTEX_PT_bake
from radtex_addon.ui.panel.settings_panels import RADTEX_PT_light, RADTEX_PT_surface
from tests.blender import stage
from tests.blender.batch_process import Batch
from tests.blender.recorded_layout import RecordedLayout
from tests.blender.ui_stage import ops, registered, settings

context: Any = bpy.context  # to the stubs, every pointer may be None
QUICK = ("--uv", "UVMap", "--texels", "16", "--samples", "1", "--progress", "none")
BEGUN = BakeSpec(uv_layer="UVMap", texels=16, samples=1, denoise=True)
WHY = "radtex: note: 'Card' is baked in layout buckets, not layered: "
BACK = (
    "radtex: warning: 2 triangles of 'Card' can be seen from behind, and look there as from the front: "
    "their backs have no texels in a UV layer of your own or with a source\n"
)
SIDE = 64  # pixels of the leaf's image


@pytest.fixture(autouse=True)
def card(empty_file: None) -> Any:
    bpy.ops.mesh.primitive_plane_add(size=2)
    context.object.name = "Card"
    context.object.data.materials.append(stage.material("Gloss", "ShaderNodeBsdfGlossy", Roughness=0.2))
    stage.world()
    return context.object


def saved(folder: Path) -> Path:
    path = folder / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)
    return path


def leaf() -> Any:
    """Green where an image says leaf, a disc, and clear around it."""
    image: Any = bpy.data.images.new("Leaf", SIDE, SIDE, alpha=True)
    across = (np.indices((SIDE, SIDE)) + 0.5) / SIDE * 2 - 1
    pixels = np.ones((SIDE, SIDE, 4), dtype=np.float32)
    pixels[..., 3] = np.hypot(*across) < 0.7
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    made = stage.material("Leaves", "ShaderNodeMixShader")
    tree = made.node_tree
    mix = next(node for node in tree.nodes if node.type == "MIX_SHADER")
    matt, texture = tree.nodes.new("ShaderNodeBsdfDiffuse"), tree.nodes.new("ShaderNodeTexImage")
    matt.inputs["Color"].default_value = (0.1, 0.6, 0.1, 1)
    texture.image, texture.interpolation = image, "Closest"
    tree.links.new(texture.outputs["Alpha"], mix.inputs[0])
    tree.links.new(tree.nodes.new("ShaderNodeBsdfTransparent").outputs[0], mix.inputs[1])
    tree.links.new(matt.outputs[0], mix.inputs[2])
    return made


def alpha_of(out: Path) -> Any:
    """The alpha of each texel of the fine map, the first row at the bottom."""
    atlas, _ = read_layered(out / "Card.radiance.json")
    assert atlas.alpha is not None
    return atlas.alpha[..., 0].astype(float)


def smoke() -> Any:
    """A matt surface with smoke in it."""
    made = stage.material("Smoke", "ShaderNodeBsdfDiffuse")
    tree = made.node_tree
    output = tree.get_output_node("CYCLES")
    tree.links.new(tree.nodes.new("ShaderNodeVolumePrincipled").outputs[0], output.inputs["Volume"])
    return made


@pytest.mark.one_blender
def test_large_atlases_have_no_more_buckets_and_no_finer_maps_than_the_limits(
    card: Any, out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With limits that 24 texels exceed; where the light is even, that changes no picture."""
    spec = BakeSpec(layout=Layout.LAYERED, texels=24, samples=1, uv_layer="UVMap")
    whole, _ = read_layered(bake_object(context.scene, "Card", spec, out).files.sidecar)
    assert whole.colour.shape[:2] == (96, 96)
    assert whole.own.shape[:2] == (12, 12)
    monkeypatch.setattr(rays, "_FINEST", 60)
    monkeypatch.setattr(rays, "_MOST_BUCKETS", 7)
    steps = bake_object(context.scene, "Card", spec, out, overwrite=True)
    limited, sidecar = read_layered(steps.files.sidecar)
    assert limited.colour.shape[:2] == (60, 60)
    assert sidecar.coarse == (7, 7)
    np.testing.assert_allclose(limited.irradiance, whole.irradiance)
    axis = cell_directions(8)  # either may have 8 x 8 cells or 14 x 14
    uv = np.full((len(axis), 2), 0.5)
    shown, wanted = (look_up(one.rest.mean(axis=(0, 1), keepdims=True), uv, axis) for one in (limited, whole))
    np.testing.assert_allclose(shown, wanted, atol=0.02)


@pytest.mark.one_blender
def test_a_bake_in_another_layout_leaves_none_of_the_earlier_images(
    tmp_path: Path, out: Path, batch: Batch
) -> None:
    line = (saved(tmp_path), "--object", "Card", *QUICK, "--out", out, "--overwrite-any")

    def baked(*more: str) -> set[str]:
        assert batch(*line, *more).code == 0
        return {path.name for path in out.iterdir()}

    parted = baked("--layout", "buckets", "--bucket", "2", "--layer", "diffuse")
    assert parted == {f"Card.radiance.{ending}" for ending in ("json", "exr", "diffuse.exr")}
    layered = baked()
    assert {"Card.radiance.json", "Card.radiance.own.exr", "Card.radiance.world.exr"} < layered
    assert not layered & {"Card.radiance.exr", "Card.radiance.diffuse.exr"}
    refused = batch(*line[:-1], "--refresh")
    assert "is in the layered layout, which cannot be refreshed, since " in refused.err
    assert "or bake it anew in layout buckets (--layout buckets, --overwrite)" in refused.err
    anew = baked("--layout", "buckets", "--bucket", "2")
    assert anew == {"Card.radiance.json", "Card.radiance.exr"}, "the advice works"


def test_leaves_keep_their_outline(card: Any, tmp_path: Path, out: Path, batch: Batch) -> None:
    card.data.materials[0] = leaf()
    context.scene.render.film_transparent = True
    ended = batch(saved(tmp_path), "--object", "Card", *QUICK, "--out", out, "--save-preview")
    assert (ended.code, ended.err) == (0, BACK)
    assert "texels, layered, at 1 spp" in ended.out
    alpha = alpha_of(out)
    middle = np.hypot(*((np.indices(alpha.shape) + 0.5) / len(alpha) * 2 - 1))
    assert alpha[middle < 0.55].min() > 0.95
    assert alpha[middle > 0.85].max() < 0.05


@pytest.mark.one_blender
def test_a_line_says_why_and_json_too(tmp_path: Path, out: Path, batch: Batch) -> None:
    blend = saved(tmp_path)
    ended = batch(blend, "--object", "Card", *QUICK, "--bucket", "4", "--out", out)
    assert ended.code == 0
    assert ended.err.startswith(f"{WHY}the layered layout chooses its cells itself, 14 or fewer, not 4")
    assert ended.err.count("\n") == 1
    again = (*QUICK, "--bucket", "4", "--progress", "json", "--overwrite")
    events = [
        json.loads(line) for line in batch(blend, "--object", "Card", *again, "--out", out).out.splitlines()
    ]
    assert [f"radtex: note: {event['message']}\n" for event in events if event["event"] == "note"] == [
        ended.err
    ]
    assert events[-1]["layout"] == "buckets"


@pytest.mark.one_blender
def test_what_was_begun_is_resumed_without_its_layout(tmp_path: Path, out: Path, batch: Batch) -> None:
    blend = saved(tmp_path)
    begin(out)
    ended = batch(blend, "--object", "Card", *QUICK, "--resume", "--out", out)
    assert (ended.code, ended.err) == (0, "")
    whole = out.parent / "whole"
    bake_object(context.scene, "Card", BEGUN, whole)
    assert {path.name: path.read_bytes() for path in out.iterdir()} == {
        path.name: path.read_bytes() for path in whole.iterdir()
    }


def begin(out: Path) -> None:
    """Leave an unfinished bake in buckets."""
    steps = bake_steps(context.scene, "Card", BEGUN, out)
    next(step for step in steps if step.stage is Stage.CAPTURE and step.done)
    steps.close()


@pytest.mark.one_blender
def test_what_is_there_is_accumulated_in_its_layout(tmp_path: Path, out: Path, batch: Batch) -> None:
    blend = saved(tmp_path)
    named = ("--layout", "buckets", "--bucket", "4", "--no-denoise")
    assert batch(blend, "--object", "Card", *QUICK, *named, "--out", out).code == 0
    for way in ("--accumulate", "--refresh"):
        ended = batch(blend, "--object", "Card", *QUICK, way, "--out", out)
        assert (ended.code, ended.err) == (0, "")
    facts = read_buckets(out / "Card.radiance.json")[1]
    assert (facts.bucket, facts.samples) == (4, 2)


@pytest.mark.one_blender
def test_a_farm_bakes_the_default_by_tasks_and_buckets_as_frames(
    tmp_path: Path, out: Path, batch: Batch
) -> None:
    prepare = ("prepare", saved(tmp_path), "--object", "Card", *QUICK, "--out", out)
    ended = batch(*prepare)
    assert (ended.code, ended.err) == (0, "")
    farm = out / "Card.radiance.radtex-farm"
    assert (farm / "tasks.json").is_file()
    ended = batch(*prepare, "--layout", "buckets", "--overwrite")
    assert (ended.code, ended.err) == (0, "")
    assert (farm / "farm.blend").is_file()
    assert not (farm / "tasks.json").exists()


@pytest.fixture
def panel(out: Path) -> Iterator[Any]:
    with registered():
        settings().directory = str(out)
        yield settings()


def told() -> str:
    return panel_state.refresh(context.scene, context.view_layer).layout


def test_the_panel_says_what_an_automatic_layout_comes_to(panel: Any, card: Any) -> None:
    assert told() == "Layered"
    panel.bucket = 8
    assert told().startswith("Buckets, 8 cells. The layered layout chooses its cells itself, 14 or fewer")
    panel.bucket = 14
    panel.layers = {"base"}
    assert told().startswith("Buckets, 8 cells. The layered layout has no layers, since its images hold")
    panel.layers = set()
    panel.variants = "lamps"
    assert told() == "Layered"
    panel.variants = "none"
    card.data.materials[0] = smoke()
    assert told() == "Buckets, 8 cells. Its material 'Smoke' has a volume"
    bpy.ops.mesh.primitive_plane_add()
    bpy.ops.object.select_all(action="SELECT")
    assert told() == (
        "Buckets for 1 of 2 objects, Layered for the others. 'Card' is baked in layout buckets, not layered: "
        "its material 'Smoke' has a volume"
    )
    panel.atlas_layout = "buckets"
    assert told() == ""


@pytest.mark.one_blender
def test_the_panel_goes_on_in_the_layout_that_was_begun(panel: Any, out: Path) -> None:
    panel.uv_layer, panel.texels, panel.samples, panel.preview = "UVMap", 16, 1, False
    begin(out)
    found = panel_state.refresh(context.scene, context.view_layer)
    assert (found.next, found.layout) == (panel_state.Next.RESUME, "Buckets, 8 cells")
    assert ops.radtex.bake(resume=True) == {"FINISHED"}
    assert (out / "Card.radiance.exr").is_file()


def test_the_button_bakes_each_object_in_its_layout(
    panel: Any, card: Any, out: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    panel.uv_layer, panel.texels, panel.samples, panel.preview = "UVMap", 16, 1, False
    card.data.materials[0] = smoke()
    bpy.ops.mesh.primitive_plane_add(location=(0, 0, 3))
    context.object.name = "Plain"
    bpy.ops.object.select_all(action="SELECT")
    capfd.readouterr()
    assert ops.radtex.bake() == {"FINISHED"}
    assert (out / "Card.radiance.exr").is_file()
    assert (out / "Plain.radiance.colour.exr").is_file()
    said = capfd.readouterr().out
    assert said.count("not layered: its material 'Smoke' has a volume") == 1


def drawn(panel: type) -> RecordedLayout:
    layout = RecordedLayout()
    panel.draw(SimpleNamespace(layout=layout), context)  # type: ignore[attr-defined]  # every panel draws
    return layout


def test_the_panel_draws_the_line_and_no_setting_of_a_layout_that_was_not_chosen(
    panel: Any, card: Any
) -> None:
    card.data.materials[0] = smoke()
    told()
    light, surface = drawn(RADTEX_PT_light), drawn(RADTEX_PT_surface)
    assert "Buckets, 8 cells. Its material 'Smoke' has a volume" in " ".join(light.texts)
    assert "atlas_layout" in light.settings
    assert {"source", "split"} <= set(surface.settings)
    panel.atlas_layout = "layered"
    told()
    assert "Buckets, 8 cells" not in " ".join(drawn(RADTEX_PT_light).texts)
    told_in_panel = " ".join(drawn(RADTEX_PT_bake).texts)
    assert "will look like a solid surface in the layered layout: " in told_in_panel
    assert "its material 'Smoke' has a volume" in told_in_panel


def test_a_bake_with_little_memory_has_its_arrays_in_files_and_the_same_bytes(
    card: Any, out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bpy.ops.mesh.primitive_cube_add(size=0.5, location=(0.3, 0, 0.6))
    context.object.data.materials.append(stage.material("Cube", "ShaderNodeBsdfDiffuse"))
    for item in (context.object, card):
        item.select_set(True)
    context.view_layer.objects.active = card
    bpy.ops.object.join()  # so that it mirrors itself
    spec = BakeSpec(layout=Layout.LAYERED, texels=64, backs=Backs.NONE, unwrap=Unwrap.BLENDER)
    bake_object(context.scene, "Card", spec, out / "memory")
    tight = replace(spec, memory_mb=spec.atlas_bytes >> 20)
    files: list[Path] = []
    place = large_arrays._in_file

    def in_file(folder: Path, *of: Any) -> Any:
        files.append(folder)
        return place(folder, *of)

    monkeypatch.setattr(large_arrays, "LEAST", 1 << 12)
    monkeypatch.setattr(large_arrays, "_in_file", in_file)
    bake_object(context.scene, "Card", tight, out / "files")
    assert len(files) > 50
    assert {folder.parent for folder in files} == {out / "files"}
    names = sorted(path.name for path in (out / "memory").iterdir())
    assert names == sorted(path.name for path in (out / "files").iterdir())
    for name in names:
        assert (out / "files" / name).read_bytes() == (out / "memory" / name).read_bytes(), name
