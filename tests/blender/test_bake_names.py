# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes of one object by several names: side by side on disk, found again, and chosen in the panel."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import bpy
import numpy as np
import pytest

from radtex_addon.bake.progress import Stage
from radtex_addon.core.errors import InputError
from radtex_addon.core.sampler import Filter
from radtex_addon.formats.sidecar_file import read_facts
from radtex_addon.job import bake_object
from radtex_addon.job.bake_plan import check_plans, plan_bakes
from radtex_addon.job.bake_request import BakeRequest
from radtex_addon.job.baking import bake_steps
from radtex_addon.job.layout_choice import OpenLayout
from radtex_addon.job.scene_atlases import SceneAtlas, requests_of
from radtex_addon.job.variants import title_of
from radtex_addon.preview.swap import copy_of, is_on, shows_any_of
from radtex_addon.report.finished_bake import find_bakes, named_bakes
from radtex_addon.report.shown import has_bakes, shown_bake
from radtex_addon.report.side_by_side import ComparisonSpec
from radtex_addon.report.viewpoint import Viewpoint
from radtex_addon.settings.spec import BakeSpec, Split
from radtex_addon.store.output_files import OutputFiles
from radtex_addon.ui.jobs import jobs
from radtex_addon.ui.operators.compare_operator import RADTEX_OT_compare, submit
from radtex_addon.ui.operators.export_sources import export_sources
from radtex_addon.ui.panel import panel_state
from radtex_addon.ui.panel.cost_panel import told_made
from radtex_addon.ui.panel.finished_panel import RADTEX_MT_bakes, RADTEX_PT_afterwards
from radtex_addon.ui.panel.jobs_panel import job_title
from radtex_addon.ui.panel.panel_state import Next
from radtex_addon.ui.panel.settings_panels import RADTEX_PT_output
from radtex_addon.ui.settings.request import request_of, values_of
from tests.blender import stage
from tests.blender.batch_process import Batch, refusal
from tests.blender.farming import BOX, assembled, prepared, render
from tests.blender.recorded_layout import RecordedLayout
from tests.blender.test_swap import NAME, ball
from tests.blender.ui_stage import finish_jobs, registered, settings
from tests.finished_bakes import finished_bake

context: Any = bpy.context  # to the stubs, every pointer may be None
radtex: Any = bpy.ops.radtex  # type: ignore[attr-defined]  # ours, not Blender's

DRAFT = BakeSpec(texels=8, bucket=2, samples=1, bake_name="{object}.draft")
FINAL = BakeSpec(texels=16, bucket=2, samples=2, bake_name="{object}.final")
TINY = ("--layout", "buckets", "--bucket", "2", "--samples", "1", "--save-preview")


def _bake_both(folder: Path) -> None:
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    ball()
    stage.hdri(stage.world())
    for spec in (DRAFT, FINAL):
        bake_object(context.scene, NAME, spec, folder, preview=Filter.QUADRILINEAR)


@pytest.fixture(scope="module")
def baked(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a draft and a final bake of the ball; not to be written to."""
    return finished_bake(tmp_path_factory.mktemp("baked"), _bake_both)


@pytest.fixture
def both(baked: Path, tmp_path: Path) -> Path:
    """The same to be written to, of an empty file; the final one is the newer."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    made = shutil.copytree(baked, tmp_path / "both")
    set_time(made, "draft", 1_000_000_000)
    set_time(made, "final", 1_000_000_100)
    return made


@pytest.fixture
def room(tmp_path: Path) -> Path:
    """A .blend with a glowing ball."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    ball()
    stage.world((0.1, 0.1, 0.1))
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "my room.blend"), copy=True)
    return tmp_path / "my room.blend"


@pytest.fixture
def panel(both: Path) -> Iterator[Path]:
    """The panel, with a ball whose bakes lie in its output folder."""
    with registered():
        ball()
        settings().directory = str(both)
        yield both


def set_time(folder: Path, word: str, seconds: int) -> None:
    set_time_of(folder, f"{NAME}.{word}", seconds)


def set_time_of(folder: Path, called: str, seconds: int) -> None:
    for path in folder.glob(f"{called}.*"):
        os.utime(path, (seconds, seconds))


def names_in(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


# on disk


def test_bakes_by_two_names_lie_side_by_side(baked: Path) -> None:
    kinds = ("radiance.json", "radiance.exr", "preview.blend")
    assert names_in(baked) == {f"Ball.{word}.{kind}" for word in ("draft", "final") for kind in kinds}
    for word, texels in (("draft", 8), ("final", 16)):
        facts = read_facts(baked / f"Ball.{word}.radiance.json")
        assert (facts.text("object"), facts.text("bake_name")) == (NAME, f"Ball.{word}")
        assert max(facts.size("texels")) == texels
    with pytest.raises(InputError, match=r"Ball\.draft\.radiance\.exr is already there"):
        _rebake(DRAFT, baked)


def _rebake(spec: BakeSpec, folder: Path) -> None:
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    ball()
    bake_object(context.scene, NAME, spec, folder)


def test_without_a_pattern_files_are_called_as_ever(out: Path) -> None:
    spec = BakeSpec(frame=7, lights=("Key", "Fill"))
    files = OutputFiles.of("a{b}", spec, out, preview=True)
    assert files.sidecar.name == "a{b}-0007-Key+Fill.radiance.json"
    assert "bake_name" not in json.loads(_sidecar_of_a_plain_bake(out))


def _sidecar_of_a_plain_bake(out: Path) -> str:
    _rebake(BakeSpec(texels=8, bucket=2, samples=1), out)
    return (out / "Ball.radiance.json").read_text(encoding="utf-8")


def test_frames_lamps_parts_and_kinds_follow_the_name(out: Path) -> None:
    spec = BakeSpec(frame=7, lights=("Key",), bake_name="{object}.v2")
    files = OutputFiles.of("Cup", spec, out, preview=True)
    assert files.sidecar.name == "Cup.v2-0007-Key.radiance.json"
    assert files.unfinished.name == "Cup.v2-0007-Key.radiance.radtex-unfinished"
    assert files.export("web").name == "Cup.v2-0007-Key.web"
    assert files.preview is not None
    assert files.preview.name == "Cup.v2-0007-Key.preview.blend"
    assert title_of("Cup", spec) == "Cup.v2, frame 7, light of Key"


def test_all_tokens_are_filled_in_before_the_bake(tmp_path: Path) -> None:
    ball()
    context.scene.name = "My/Scene"
    pattern = "{file}-{scene}-{object}-{quality}-{resolution}-{samples}"
    spec = BakeSpec(texels=256, samples=16, bake_name=pattern)
    request = BakeRequest((NAME,), spec, tmp_path, blend=Path("/x/my room.blend"))
    ((name, found),) = request.asked(context.scene)
    called = OutputFiles.of(name, found, tmp_path).sidecar.name.removesuffix(".radiance.json")
    assert called.startswith("my room-My_Scene-")
    assert called.endswith("-Ball-custom-256-16")


def test_atlases_of_a_scene_have_the_quality_of_its_settings(out: Path) -> None:
    spec = BakeSpec(texels=256, samples=16, bake_name="{object}.{quality}.{resolution}")
    request = BakeRequest(("A", "B", "C"), spec, out, open_layout=OpenLayout(), as_scene=True)
    atlas = SceneAtlas("Room_group", ("A", "B"), 320, 1.0)
    asked = [bake for each in requests_of(request, (atlas,)) for bake in each.asked(context.scene)]
    names = [OutputFiles.of(*bake, out).sidecar.name for bake in asked]
    assert names == ["Room_group.final.320.radiance.json", "C.final.256.radiance.json"]


def test_two_objects_of_one_name_are_refused_before_anything_is_baked(out: Path) -> None:
    ball("One")
    ball("Two")
    request = BakeRequest(("One", "Two"), BakeSpec(bake_name="Pair"), out)
    with pytest.raises(InputError) as raised:
        check_plans(context.scene, [plan_bakes(context.scene, request)])
    assert "'One' and 'Two' would both become" in str(raised.value)
    assert '"Pair"' in str(raised.value)
    assert "{object}" in str(raised.value)
    apart = BakeRequest(("One", "Two"), BakeSpec(bake_name="Pair-{object}"), out)
    check_plans(context.scene, [plan_bakes(context.scene, apart)])


# found again


def test_bakes_are_found_by_object_and_by_name(both: Path) -> None:
    assert [one.called for one in named_bakes(both, NAME)] == ["Ball.final", "Ball.draft"]
    assert named_bakes(both, "Other") == ()
    with pytest.raises(InputError, match=r"Ball\.draft\.radiance\.json, Ball\.final\.radiance\.json: name"):
        find_bakes(both, NAME, "exported")
    for word in ("draft", "final"):
        (found,) = find_bakes(both, f"Ball.{word}", "exported", or_called=True)
        assert find_bakes(found.path, f"Ball.{word}", "exported", or_called=True) == [found]
        assert found.path.name == f"Ball.{word}.radiance.json"
        assert shown_bake(both, NAME, f"Ball.{word}").path == found.path
    assert has_bakes(both, [NAME], Path())
    (both / "Ball.draft.radiance.json").unlink()
    (found,) = find_bakes(both, NAME, "exported")
    assert found.path.name == "Ball.final.radiance.json"
    assert shown_bake(both, NAME).path == found.path


def test_a_bake_that_is_called_as_another_object_is_not_that_objects(both: Path) -> None:
    _rename(both, "Ball.draft", "Cup")
    assert shown_bake(both, NAME, "Cup").path.name == "Cup.radiance.json"
    with pytest.raises(InputError, match="no bake of 'Cup'"):
        shown_bake(both, "Cup")
    assert named_bakes(both, "Cup") == ()
    assert not has_bakes(both, ["Cup"], Path())
    ball("Cup")
    with registered():
        settings().directory = str(both)
        with pytest.raises(RuntimeError, match="no bake of 'Cup'"):
            radtex.preview_toggle(object="Cup")
        with pytest.raises(RuntimeError, match="no bake of 'Cup'"):
            radtex.export(object="Cup", target="raw")
    with pytest.raises(InputError, match=r"is a bake of object 'Ball', not of object 'Cup'.*call this one"):
        bake_object(context.scene, "Cup", replace(DRAFT, bake_name="Cup"), both, overwrite=True)


def _rename(folder: Path, called: str, other: str) -> None:
    for path in list(folder.glob(f"{called}.*")):
        path.rename(folder / path.name.replace(called, other))
    sidecar = folder / f"{other}.radiance.json"
    sidecar.write_text(sidecar.read_text(encoding="utf-8").replace(f'"{called}"', f'"{other}"'), "utf-8")


def test_the_batch_bakes_finds_and_exports_by_name(room: Path, out: Path, batch: Batch) -> None:
    asked = (room, "--object", NAME, "--out", out, "--name", "{file}.{object}.{resolution}", *TINY)
    first = batch(*asked, "--texels", "8")
    assert "my room.Ball.8: 8 x " in first.out
    batch(*asked, "--texels", "16")
    sidecars = {path.name for path in out.glob("*.json")}
    assert sidecars == {"my room.Ball.8.radiance.json", "my room.Ball.16.radiance.json"}
    assert "is already there" in refusal(batch(*asked, "--texels", "8"))
    assert "nothing is left to do" in batch(*asked, "--texels", "8", "--changed").err
    assert "baking" in batch(*asked, "--texels", "12", "--changed").err
    assert (out / "my room.Ball.12.radiance.json").is_file()
    assert "name one of these files" in refusal(batch("export", out, "--object", NAME, "--to", "raw"))
    batch("export", out, "--object", "my room.Ball.16", "--to", "raw")
    assert (out / "my room.Ball.16.raw").is_dir()


def test_the_batch_judges_the_bake_that_is_meant(room: Path, out: Path, batch: Batch) -> None:
    for name, texels in (("{object}.a", 8), ("{object}.b", 12)):
        batch(room, "--object", NAME, "--out", out, "--name", name, "--texels", texels, *TINY)
    quick = ("--scene", room, "--views", "1", "--pixels", "16", "--samples", "1")
    assert "name one of these files" in refusal(batch("report", out, *quick))
    for name in ("a", "b"):
        batch("report", out, "--object", f"Ball.{name}", *quick)
        assert (out / f"Ball.{name}.report.html").is_file()
    view = ("--view=1,0,0,0,0,1,0,0,0,0,1,-5,0,0,0,1", "--window=0.5,0,0,0,0,1,0,0,0,0,-0.002,0,0,0,0,1")
    seen = (*view, "--pixels", "32", "--samples", "1", "--out", out / "pictures")
    asked = ("compare", room, "--object", NAME, *seen)
    assert "name one of these files" in refusal(batch(*asked, "--bake", out))
    assert "dB" in batch(*asked, "--bake", out / "Ball.b.radiance.json").out


def test_adding_and_going_on_are_about_the_bake_of_that_name(both: Path) -> None:
    ball()
    stage.hdri(stage.world())
    more = replace(FINAL, accumulate=True)
    bake_object(context.scene, NAME, more, both)
    samples = {one.called: read_facts(one.sidecars[0]).values["samples"] for one in named_bakes(both, NAME)}
    assert samples == {"Ball.final": 4, "Ball.draft": 1}
    with pytest.raises(InputError, match=r"Ball\.new\.radiance\.json is not there to accumulate onto"):
        bake_object(context.scene, NAME, replace(more, bake_name="{object}.new"), both)
    steps = bake_steps(context.scene, NAME, replace(DRAFT, bake_name="{object}.new"), both)
    while (step := next(steps)).stage is not Stage.CAPTURE or not step.done:
        pass
    steps.close()
    assert (both / "Ball.new.radiance.radtex-unfinished").is_dir()
    bake_object(context.scene, NAME, replace(DRAFT, bake_name="{object}.new"), both, resume=True)
    assert (both / "Ball.new.radiance.json").is_file()
    assert not list(both.glob("*unfinished"))


def test_parts_of_two_names_are_told_apart(out: Path) -> None:
    item = ball()
    item.data.materials.append(stage.material("Blue", "ShaderNodeEmission", Color=(0, 0, 1, 1)))
    item.data.polygons[0].material_index = 1
    for word in ("a", "b"):
        whole = replace(DRAFT, split=Split.MATERIAL, bake_name=f"{{object}}.{word}")
        for part in (NAME, "Blue"):
            bake_object(
                context.scene,
                NAME,
                replace(whole, part=part),
                out,
                preview=Filter.QUADRILINEAR,
                overwrite=True,
            )
    assert (out / "Ball.a.material.preview.blend").is_file()
    for word in ("a", "b"):
        found = {each.path.name for each in find_bakes(out, NAME, "exported", called=f"Ball.{word}")}
        assert found == {f"Ball.{word}.{part}.radiance.json" for part in (NAME, "Blue")}
    with pytest.raises(InputError, match="name one of these files"):
        find_bakes(out, NAME, "exported")


def test_a_farm_bakes_by_the_name(out: Path) -> None:
    bpy.ops.mesh.primitive_cube_add(size=1)
    context.object.name = BOX
    stage.world((0.3, 0.4, 0.5))
    context.scene.name = "Room"
    spec = BakeSpec(texels=32, bucket=2, samples=1, bake_name="{object}.{scene}.{samples}")
    farm = prepared(context.scene, spec, out)
    assert farm.files.folder.name == "Box.Room.1.radiance.radtex-farm"
    render(farm.files.folder, "1")
    assembled(farm.files.folder)
    facts = read_facts(out / "Box.Room.1.radiance.json")
    assert (facts.text("object"), facts.text("bake_name")) == ("Box", "Box.Room.1")


def test_the_batch_names_what_is_wrong_with_a_name(room: Path, out: Path, batch: Batch) -> None:
    told = refusal(batch(room, "--object", NAME, "--out", out, "--name", "{object}.{sample}"))
    assert '"{sample}"' in told
    assert "{samples}" in told
    assert "--name {object}" in told
    assert not out.exists() or not names_in(out)


# the panel


def test_the_panels_presets_are_qualities(panel: Path) -> None:
    settings().bake_name = "{object}.{quality}"
    for preset, quality in (("draft", "draft"), ("final", "final"), ("mirror_like", "glossy")):
        radtex.preset_apply(name=preset)
        ((_, spec),) = request_of(values_of(settings()), (NAME,)).asked(context.scene)
        assert spec.bake_name == f"{{object}}.{quality}"
    settings().samples += 1
    found = panel_state.refresh(context.scene, context.view_layer)
    assert [one.name for one in found.made] == ["Ball.custom"]
    assert "Ball.custom: 192 × 192 texels" in told_made(found)
    layout = draw(RADTEX_PT_output)
    assert "bake_name" in layout.settings
    assert "That is Ball.custom" in layout.texts


def test_a_wrong_pattern_is_an_error_with_the_field_below_it(panel: Path) -> None:
    settings().bake_name = "{object}.{quallity}"
    found = panel_state.refresh(context.scene, context.view_layer)
    assert found.next is Next.NOTHING
    assert "{quallity}" in str(found.errors[0])
    with pytest.raises(RuntimeError, match="quallity"):
        radtex.bake(object=NAME)


def test_objects_with_settings_of_their_own_may_not_share_a_name(panel: Path) -> None:
    other = ball("Other")
    other.radtex.use = True
    for each in (settings(), other.radtex):
        each.texels, each.bucket, each.samples, each.bake_name = 8, 2, 1, "Same"
    with pytest.raises(RuntimeError, match="would both become"):
        radtex.bake(objects=f"{NAME}\nOther")
    assert not (panel / "Same.radiance.json").exists()


def test_the_button_is_about_the_bake_that_the_settings_name(panel: Path) -> None:
    settings().atlas_layout, settings().texels, settings().bucket, settings().samples = "buckets", 8, 2, 1
    settings().denoise = False
    for name, expected in (
        ("{object}.draft", Next.REPLACE),
        ("{object}.new", Next.BAKE),
        ("{object}", Next.BAKE),
    ):
        settings().bake_name = name
        assert panel_state.refresh(context.scene, context.view_layer).next is expected, name


def draw(cls: Any) -> RecordedLayout:
    layout = RecordedLayout()
    panel_state.refresh(context.scene, context.view_layer)
    cls.draw(SimpleNamespace(layout=layout), context)
    return layout


def rows(layout: RecordedLayout) -> list[str]:
    """The bakes that the panel offers to choose."""
    return [each.called for name, each in layout.buttons if name == "radtex.choose_bake"]


def test_finished_bake_lists_the_newest_first_and_uses_the_chosen_one(panel: Path) -> None:
    (item,) = (each for each in context.scene.objects if each.type == "MESH")
    assert rows(draw(RADTEX_PT_afterwards)) == ["Ball.final", "Ball.draft"]
    assert exported(panel) == {"Ball.final.radiance.json"}
    radtex.preview_toggle()
    assert shows(item, panel, "final")
    assert copy_of(item).name == "Ball.final (baked)"
    assert radtex.choose_bake(object=NAME, called="Ball.draft") == {"FINISHED"}
    assert is_on(item)
    assert shows(item, panel, "draft")
    assert copy_of(item).name == "Ball.draft (baked)"
    assert exported(panel) == {"Ball.draft.radiance.json"}
    assert rows(draw(RADTEX_PT_afterwards)) == ["Ball.final", "Ball.draft"]
    radtex.preview_toggle()
    assert not is_on(item)
    radtex.preview_toggle()
    assert shows(item, panel, "draft")
    set_time(panel, "final", 1_000_000_200)  # baked again
    assert exported(panel) == {"Ball.final.radiance.json"}


def exported(_: Path) -> set[str]:
    return {source.sidecar.path.name for source in export_sources(context.scene, context.view_layer, "", "")}


def shows(item: Any, folder: Path, word: str) -> bool:
    return shows_any_of(item, [folder / f"Ball.{word}.radiance.exr"])


def test_many_bakes_have_a_menu(panel: Path) -> None:
    for number in range(7):
        for path in list(panel.glob("Ball.draft.*")):
            text = path.read_bytes().replace(b"Ball.draft", f"Ball.v{number}".encode())
            (panel / path.name.replace("draft", f"v{number}")).write_bytes(text)
        set_time(panel, f"v{number}", 1_000_000_000 - number)
    layout = draw(RADTEX_PT_afterwards)
    assert rows(layout) == [
        "Ball.final",
        *sorted(["Ball.draft", "Ball.v0"]),
        *(f"Ball.v{n}" for n in (1, 2, 3)),
    ]
    assert layout.menus == ["RADTEX_MT_bakes"]
    assert "and 3 more" in layout.texts
    menu = RecordedLayout()
    RADTEX_MT_bakes.draw(cast(Any, SimpleNamespace(layout=menu)), context)
    assert rows(menu) == ["Ball.v4", "Ball.v5", "Ball.v6"]
    radtex.choose_bake(object=NAME, called="Ball.v6")
    assert "Ball.v6 is chosen" in draw(RADTEX_PT_afterwards).texts
    assert exported(panel) == {"Ball.v6.radiance.json"}


def test_a_bake_that_is_gone_cannot_be_chosen(panel: Path) -> None:
    for path in panel.glob("Ball.draft.*"):
        path.unlink()
    with pytest.raises(RuntimeError, match=r"no bake 'Ball\.draft' of 'Ball': it has 'Ball\.final'"):
        radtex.choose_bake(object=NAME, called="Ball.draft")
    assert rows(draw(RADTEX_PT_afterwards)) == ["Ball.final"]


def test_copies_of_two_bakes_stand_side_by_side(panel: Path) -> None:
    for word in ("final", "draft"):
        radtex.choose_bake(object=NAME, called=f"Ball.{word}")
        radtex.apply_to_copy(object=NAME)
    assert {"Ball.final (baked copy)", "Ball.draft (baked copy)"} <= set(bpy.data.objects.keys())


def test_deleting_leaves_the_bakes_of_other_names(panel: Path) -> None:
    radtex.choose_bake(object=NAME, called="Ball.draft")
    radtex.delete_bake(object=NAME)
    assert names_in(panel) == {
        f"Ball.final.{kind}" for kind in ("radiance.json", "radiance.exr", "preview.blend")
    }


def test_plain_bakes_have_nothing_to_choose(panel: Path) -> None:
    for path in panel.iterdir():
        path.unlink()
    radtex.bake(object=NAME, texels=8, bucket=2, samples=1, atlas_layout="buckets", wait=True)
    assert (panel / "Ball.radiance.json").is_file()
    assert rows(draw(RADTEX_PT_afterwards)) == []


def test_a_plain_bake_and_a_named_one_are_both_offered(panel: Path) -> None:
    radtex.bake(object=NAME, texels=8, bucket=2, samples=1, atlas_layout="buckets", wait=True)
    assert rows(draw(RADTEX_PT_afterwards)) == ["Ball", "Ball.final", "Ball.draft"]
    assert exported(panel) == {"Ball.radiance.json"}
    radtex.choose_bake(object=NAME, called="Ball.final")
    assert exported(panel) == {"Ball.final.radiance.json"}


def test_an_asset_has_bakes_of_several_names_too(panel: Path) -> None:
    bpy.ops.object.delete()
    stage.world()
    own = settings()
    for name, place in (("Foot", 0.0), ("Shade", 0.5)):
        bpy.ops.mesh.primitive_cube_add(size=0.5, location=(0, 0, place))
        context.object.name = name
    items = [context.scene.objects[name] for name in ("Foot", "Shade")]
    for item in items:
        item.select_set(True)
    own.bake_name = "{object}.{quality}"
    radtex.preset_apply(name="preview")
    seen = panel_state.refresh(context.scene, context.view_layer)
    (asset,) = seen.assets
    assert [(one.name, one.texels) for one in seen.made] == [(f"{asset.name}.preview", 192)]
    own.texels, own.samples = 8, 1
    for name in ("{object}.a", "{object}.b"):
        own.bake_name = name
        radtex.bake(wait=True)
    set_time_of(panel, f"{asset.name}.a", 1_000_000_300)
    set_time_of(panel, f"{asset.name}.b", 1_000_000_400)
    assert rows(draw(RADTEX_PT_afterwards)) == [f"{asset.name}.b", f"{asset.name}.a"]
    radtex.preview_toggle()
    assert {copy_of(item).name for item in items} == {
        f"{item.name}, {asset.name}.b (baked)" for item in items
    }
    radtex.choose_bake(object=asset.name, called=f"{asset.name}.a")
    assert {copy_of(item).name for item in items} == {
        f"{item.name}, {asset.name}.a (baked)" for item in items
    }
    assert exported(panel) == {f"{asset.name}.a.radiance.json"}


def test_a_comparison_uses_the_chosen_bakes_of_several_objects(panel: Path) -> None:
    bpy.ops.object.select_all(action="SELECT")
    for name in ("a", "b"):
        radtex.bake(
            object=NAME,
            texels=8,
            bucket=2,
            samples=1,
            atlas_layout="buckets",
            bake_name=f"{{object}}.{name}",
            wait=True,
        )
    items = [context.scene.objects[NAME]]
    radtex.choose_bake(object=NAME, called="Ball.a")
    bakes, _ = RADTEX_OT_compare._bakes(cast(Any, None), context.scene, items, "")
    assert [bake.path.name for bake in bakes.values() if bake is not None] == ["Ball.a.radiance.json"]
    eye = Viewpoint(np.eye(4), np.diag([0.5, 1.0, -0.002, 1.0]))
    submit(context.scene, bakes, panel, eye, ComparisonSpec(16, 1))
    (job,) = finish_jobs()
    assert job.state == "done", job.message


def test_jobs_of_two_names_wait_beside_each_other(panel: Path) -> None:
    own = settings()
    own.atlas_layout, own.texels, own.bucket, own.samples, own.preview = "buckets", 8, 2, 1, False
    for name in ("{object}.a", "{object}.{samples}"):
        own.bake_name = name
        assert not jobs.is_being_baked(NAME, own)
        plan = plan_bakes(context.scene, request_of(values_of(own), (NAME,)))
        jobs.submit(context.scene, [plan])
        assert jobs.is_being_baked(NAME, own)
        with pytest.raises(InputError, match="being baked there already"):
            jobs.submit(context.scene, [plan])
    assert [job_title(job) for job in jobs.snapshot()] == ["Ball.a", "Ball.1"]
    assert [job.state for job in finish_jobs()] == ["done", "done"]
    assert {"Ball.a.radiance.json", "Ball.1.radiance.json"} <= names_in(panel)
