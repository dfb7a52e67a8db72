# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel prepares a farm and assembles it: by real workers, with the files of a bake on one machine."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import bpy
import pytest

from radtex_addon.bake.progress import finished
from radtex_addon.core.quoting import quoted
from radtex_addon.farm.farm_folder import told_earlier
from radtex_addon.farm.prepare_farm import prepare_steps
from radtex_addon.farm.tasks import read_tasks
from radtex_addon.job.bake_plan import plan_bakes
from radtex_addon.settings.spec import BakeSpec
from radtex_addon.ui.jobs import jobs
from radtex_addon.ui.operators.farm_operators import RADTEX_OT_assemble_farm, RADTEX_OT_prepare_farm
from radtex_addon.ui.panel import jobs_panel
from radtex_addon.ui.panel.farm_panel import RADTEX_PT_farm, told_prepared
from radtex_addon.ui.panel.job_ends import end_of
from radtex_addon.ui.panel.panel_state import mark_stale
from radtex_addon.ui.settings.request import request_of, values_of
from radtex_addon.worker.job import Job, JobState
from radtex_addon.worker.kept_jobs import KeptJobs, left_lists
from radtex_addon.worker.order import Program, Work, farm_command
from tests.blender import stage
from tests.blender.farming import render
from tests.blender.recorded_layout import RecordedLayout
from tests.blender.ui_stage import context, finish_jobs, ops, preferences, registered, settings

BAKE = Path(__file__).parents[2] / "bake.py"


@pytest.fixture(autouse=True)
def _registered(empty_file: None, out: Path, tmp_path: Path) -> Iterator[None]:
    """A card and a cup, apart from each other, the card selected."""
    with registered():
        stage.world()
        for number, name in enumerate(("Cup", "Card")):
            bpy.ops.mesh.primitive_plane_add(size=2, location=(6 * number, 0, 0))
            context.object.name = name
        bpy.ops.object.select_all(action="DESELECT")
        context.scene.objects["Card"].select_set(True)
        settings().directory = str(out)
        settings().atlas_layout, settings().bucket, settings().unwrap = "buckets", 2, "blender"
        settings().texels, settings().samples, settings().preview = 8, 1, False
        preferences().cache_folder = str(tmp_path / "cache")
        yield


def dialog_of(cls: Any, methods: tuple[str, ...], **choices: Any) -> Any:
    """The operator as Blender would have it once its dialog is open."""
    made: Any = SimpleNamespace(**choices, at_once=False, bl_rna=None)
    for name in methods:
        setattr(made, name, getattr(cls, name).__get__(made))
    return made


def preparing(**choices: Any) -> Any:
    methods = ("_foreseen", "_found", "_owners", "_planned", "_requests", "_check", "check", "report")
    chosen = {"what": "CHOSEN", "again": False, "join": True, "overwrite": False} | choices
    made = dialog_of(RADTEX_OT_prepare_farm, methods[:-1], **chosen, _drawn=None, _lines=(), _there=False)
    made.report = lambda levels, text: made.said.append((min(levels), text))
    made.said = []
    return made


def foreseen(**choices: Any) -> list[tuple[str, str]]:
    """What the dialog says, each line with its icon."""
    dialog = preparing(**choices)
    assert dialog.check(context)
    assert not dialog.check(context), "nothing has changed"
    dialog.layout, dialog.bl_rna = RecordedLayout(), ops.radtex.prepare_farm.get_rna_type()
    RADTEX_OT_prepare_farm.draw(dialog, context)
    assert dialog.layout.settings[:2] == ["what", "again"]
    return list(dialog._lines)


def press(dialog: Any) -> Any:
    """Confirm a dialog; its job runs in a worker of its own, as in a window. Returns the job at its end."""
    before = len(jobs.snapshot())
    found = type_of(dialog).execute(dialog, context)
    assert found == {"FINISHED"}, dialog.said
    assert len(jobs.snapshot()) == before + 1, dialog.said
    return finish_jobs()[-1]


def type_of(dialog: Any) -> Any:
    return RADTEX_OT_prepare_farm if hasattr(dialog, "what") else RADTEX_OT_assemble_farm


def assembling(farm: Path, into: str = "", **choices: Any) -> Any:
    chosen = {"overwrite": False, "overwrite_any": False} | choices
    made = dialog_of(
        RADTEX_OT_assemble_farm,
        ("_farm", "ask_for"),
        directory=str(farm),
        into=into,
        _asked=(),
        _browsed=False,
        **chosen,
    )
    made.said = []
    made.report = lambda levels, text: made.said.append((min(levels), text))
    return made


def drawn(job: Job) -> RecordedLayout:
    """The job's box in the list."""
    layout = RecordedLayout()
    jobs_panel._draw_job(layout, job)
    return layout


def buttons(layout: RecordedLayout) -> dict[str, Any]:
    return dict(layout.buttons)


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir()) if path.is_file()}


def work(farm: Path) -> None:
    """Do all tasks, as a machine of the farm does."""
    command = [sys.executable, str(BAKE), "work", str(farm), "--progress", "none"]
    subprocess.run(command, check=True, capture_output=True, timeout=600)


def test_a_farm_from_the_panel_makes_the_files_of_a_bake(out: Path, tmp_path: Path) -> None:
    """The default layout, whose captures are tasks of their own."""
    settings().atlas_layout, settings().samples = "layered", 2
    context.object.data.materials.append(stage.material("Gloss", "ShaderNodeBsdfPrincipled", Roughness=0.3))
    plan = plan_bakes(context.scene, request_of(values_of(settings()), ("Card",)))
    jobs.submit(context.scene, [plan])
    assert finish_jobs()[-1].state is JobState.DONE
    whole = contents(out)
    for name in whole:
        (out / name).unlink()

    prepared = press(preparing())
    farm = out / "Card.radiance.radtex-farm"
    assert (prepared.state, prepared.files) == (JobState.DONE, (farm,)), prepared.message
    assert context.scene.objects["Card"].data.polygons, "the session is as it was"
    count = len(read_tasks(farm).tasks)
    assert count > 1
    box = drawn(prepared)
    assert "Card, for a farm" in box.texts
    assert f"{count} tasks, " in " ".join(box.texts)
    assert "No other file of this machine travels" in " ".join(box.texts)
    assert buttons(box)["radtex.assemble_farm"].directory == str(farm)
    assert buttons(box)["radtex.open_folder"].directory == str(farm)
    assert buttons(box)["radtex.copy_farm_command"].directory == str(farm)

    early = press(assembling(farm))
    assert early.state is JobState.FAILED
    assert f"{count} of {count} tasks are not done: Card.maps" in str(early.message)
    box = drawn(early)
    assert "Card, from a farm" in box.texts
    assert {"radtex.copy_farm_command", "radtex.assemble_farm"} <= buttons(box).keys()
    assert contents(out) == {}

    button = SimpleNamespace(directory=str(farm))
    tip = RADTEX_OT_assemble_farm.description(context, button)
    assert tip.endswith(f"any others.\n0 of {count} tasks are done now")
    work(farm)
    tip = RADTEX_OT_assemble_farm.description(context, button)
    assert tip.endswith(f"{count} of {count} tasks are done now")
    assembled = press(assembling(farm))
    assert assembled.state is JobState.DONE, assembled.message
    assert "radtex.assemble_farm" not in buttons(drawn(early)), "it was done since"
    assert contents(out) == whole
    assert {path.name for path in assembled.files} == whole.keys()
    assert buttons(drawn(assembled))["radtex.delete_bake"].object == "Card"
    mark_stale()
    assert plan_bakes(context.scene, plan.request).request.place(plan.wanted[0]).is_finished()
    found = end_of([prepared, assembled])
    assert found is not None
    assert found.text.startswith("Done 2 jobs in ")
    assert not list((tmp_path / "cache").iterdir())


def test_the_dialog_says_what_is_written_and_what_stays(out: Path) -> None:
    (folder, time_, *rest) = foreseen()
    assert folder == (f"Writes the folder {out / 'Card.radiance.radtex-farm'}", "FILE_FOLDER")
    assert time_[1] == "TIME"
    assert time_[0].startswith("1 bake, by this machine alone ")
    assert rest == []
    settings().export_targets, settings().preview = {"web"}, True
    assert ("Exports are not made by a farm: export once it is assembled", "INFO") in foreseen()
    settings().export_targets, settings().preview = set(), False
    scene = foreseen(what="ALL")
    assert scene[0] == (f"Writes the folder {out / 'scene.radtex-farm'}", "FILE_FOLDER")
    assert any(line.startswith("2 bakes, by this machine alone ") for line, _ in scene)
    ops.radtex.bake(object="Card", wait=True)
    assert foreseen() == [("All of it is baked: switch Bake Again on to bake it anew", "CHECKMARK")]
    assert ("Finished bakes that stay: 1", "INFO") in foreseen(what="ALL")
    assert ("Bakes that are there: 1. Assemble asks before it replaces them", "INFO") in foreseen(again=True)
    settings().accumulate = True
    assert foreseen(again=True)[0][1] == "ERROR"
    settings().accumulate = False
    bpy.ops.object.select_all(action="DESELECT")
    context.view_layer.objects.active = None
    assert foreseen() == [("Select a mesh object to bake", "ERROR")]


def test_the_bake_list_becomes_one_farm_and_its_bakes_are_assembled_together(out: Path) -> None:
    chosen = context.scene.radtex_chosen
    chosen.source = "list"
    for name in ("Cup", "Card"):
        chosen.listed.add().item = context.scene.objects[name]
    dialog = preparing()
    dialog.check(context)
    prepared = press(dialog)
    farm = out / "scene.radtex-farm"
    assert prepared.files == (farm,)
    assert jobs_panel.job_title(prepared) == "2 bakes, for a farm"
    assert [bake.name for bake in read_tasks(farm).bakes] == ["Cup", "Card"]
    assert read_tasks(farm).blend == "", "the file was never saved"
    again = preparing()
    with pytest.raises(Exception, match="is already there: assemble it first"):
        again._check(context.scene, again._planned(context.scene, ("Card", "Cup")))
    told = "scene.radtex-farm is there, with 0 of 2 tasks done: it will be replaced"
    assert (told, "ERROR") in foreseen()
    again.check(context)
    job = read_tasks(farm).job
    assert press(again).state is JobState.DONE
    assert read_tasks(farm).job != job, "the dialog has asked"
    work(farm)
    assert told_earlier(farm) == told.replace("0 of", "2 of")
    assembled = press(assembling(farm))
    assert {path.name for path in assembled.files} >= {"Cup.radiance.json", "Card.radiance.json"}
    box = drawn(assembled)
    assert "Finished Bake shows them, once they are chosen" in " ".join(box.texts)
    assert buttons(box)["radtex.open_folder"].directory == str(out)


def test_assembling_asks_before_bakes_are_replaced(out: Path) -> None:
    assert ops.radtex.prepare_farm() == {"FINISHED"}
    assert context.scene.objects["Card"], "the session is as it was"
    farm = out / "Card.radiance.radtex-farm"
    work(farm)
    assert not assembling(farm).ask_for()
    settings().samples = 2
    ops.radtex.bake(object="Card", wait=True)
    better = contents(out)
    with pytest.raises(RuntimeError, match="already there"):
        ops.radtex.assemble_farm(directory=str(farm))
    with pytest.raises(RuntimeError, match="better bake"):
        ops.radtex.assemble_farm(directory=str(farm), overwrite=True)
    assert contents(out) == better
    dialog = assembling(farm)
    assert dialog.ask_for()
    (line,) = dialog._asked
    assert line.startswith("Card.radiance.json is a better bake (")
    dialog.layout = RecordedLayout()
    RADTEX_OT_assemble_farm.draw(dialog, context)
    assert dialog.layout.texts[0].startswith("Card.radiance.json is a")
    assert press(dialog).state is JobState.DONE, "OK means yes"
    assert contents(out) != better
    dialog = assembling(farm)
    assert dialog.ask_for()
    assert dialog._asked == ("Card.radiance.json is already there: it will be replaced",)
    elsewhere = out.parent / "elsewhere"
    assert not assembling(farm, str(elsewhere)).ask_for()
    assert ops.radtex.assemble_farm(directory=str(farm), into=str(elsewhere)) == {"FINISHED"}
    assert (elsewhere / "Card.radiance.json").is_file()


@pytest.mark.one_blender
def test_a_farm_of_frames_is_assembled_alike(out: Path) -> None:
    spec = BakeSpec(texels=8, bucket=2, samples=1, device="cpu")
    farm = finished(prepare_steps(context.scene, "Card", spec, out)).files.folder
    told = f"{farm.name} is there, with the frames that were rendered: it will be replaced"
    assert told_earlier(farm) == told
    early = press(assembling(farm))
    assert early.state is JobState.FAILED
    assert "1 missing" in str(early.message)
    render(farm, "1")
    assembled = press(assembling(farm))
    assert assembled.state is JobState.DONE, assembled.message
    assert {path.name for path in assembled.files} == {"Card.radiance.exr", "Card.radiance.json"}
    assert assembling(farm).ask_for(), "a bake is there now"


@pytest.mark.one_blender
def test_what_is_refused_says_why(out: Path) -> None:
    with pytest.raises(RuntimeError, match=r"(?i)which farm is assembled\? name its folder"):
        ops.radtex.assemble_farm()
    out.mkdir()
    with pytest.raises(
        RuntimeError, match=r"holds no farm: choose a folder whose name ends in \.radtex-farm"
    ):
        ops.radtex.assemble_farm(directory=str(out))
    with pytest.raises(RuntimeError, match="holds no tasks"):
        ops.radtex.copy_farm_command(directory=str(out))
    settings().accumulate = True
    with pytest.raises(RuntimeError, match="A farm bakes anew"):
        ops.radtex.prepare_farm()
    settings().accumulate = False
    own = context.scene.objects["Cup"].radtex
    own.use = True
    own.directory = str(out / "cups")
    with pytest.raises(RuntimeError, match="go to another folder"):
        ops.radtex.prepare_farm(what="ALL")
    own.use = False
    (out / "Card.radiance.radtex-farm").mkdir()
    with pytest.raises(RuntimeError, match="and is no farm: move it"):
        ops.radtex.prepare_farm(overwrite=True)
    assert list((out / "Card.radiance.radtex-farm").iterdir()) == []
    for item in list(context.scene.objects):
        bpy.data.objects.remove(item)
    context.view_layer.update()
    assert not ops.radtex.prepare_farm.poll()
    layout: Any = RecordedLayout()
    RADTEX_PT_farm.draw(SimpleNamespace(layout=layout), context)  # type: ignore[arg-type]  # all that it asks for
    assert "Add a mesh object to prepare its bake" in layout.texts


@pytest.mark.one_blender
def test_a_cancelled_preparation_leaves_nothing(out: Path) -> None:
    dialog = preparing()
    assert RADTEX_OT_prepare_farm.execute(dialog, context) == {"FINISHED"}
    second = preparing()
    with pytest.raises(Exception, match="is being prepared or assembled"):
        second._check(context.scene, second._planned(context.scene, ("Card",)))
    until = time.monotonic() + 60
    while not list(out.glob(".radtex-*")):
        assert jobs.advance(), jobs.snapshot()
        assert time.monotonic() < until, jobs.snapshot()
    assert "Card, for a farm" in drawn(jobs.snapshot()[0]).texts
    jobs.cancel()
    assert finish_jobs()[0].state is JobState.CANCELLED
    assert list(out.iterdir()) == []


@pytest.mark.one_blender
def test_a_preparation_is_kept_for_the_next_session(tmp_path: Path) -> None:
    assert RADTEX_OT_prepare_farm.execute(preparing(), context) == {"FINISHED"}
    kept = KeptJobs(tmp_path / "lists", "this")
    kept.write(jobs.snapshot())
    kept.close()
    jobs.cancel()
    (found,) = left_lists(tmp_path / "lists", "this")
    (job,) = found.jobs
    assert job.work is Work.PREPARATION
    gone_on = replace(job, begun=True).goes_on()
    assert gone_on.order.facts["overwrite"] is True
    assert replace(gone_on.order, facts={}) == replace(jobs.snapshot()[0].order, facts={}, expected=None)
    found.remove()


@pytest.mark.one_blender
def test_files_that_travel_are_listed() -> None:
    """Some by name; of many their number, and where they are listed."""
    facts = {"tasks": 3, "bytes": 2_500_000, "expected": [[1, 7200.0], [4, 1800.0], [16, 600.0]]}
    few = facts | {
        "carried": ["image 'Wood': /textures/wood.png (packed, 2.0 MB)"],
        "listing": "/x/tasks.json",
    }
    assert told_prepared(few) == [
        "3 tasks, 2.5 MB to travel",
        "By typical times 2.0 h on 1 machine, 30 min on 4, 10 min on 16",
        "Of this machine travel with it:",
        "image 'Wood': /textures/wood.png (packed, 2.0 MB)",
    ]
    many = few | {"carried": ["one"] * 40}
    assert told_prepared(many)[2:] == ["40 files of this machine travel with it: tasks.json lists them"]


@pytest.mark.one_blender
def test_an_image_of_this_machine_is_named_in_the_list(tmp_path: Path) -> None:
    image = bpy.data.images.new("Wood", 4, 4)
    image.filepath_raw = str(tmp_path / "wood.png")
    image.file_format = "PNG"
    image.save()
    made = stage.material("Wood", "ShaderNodeBsdfDiffuse")
    tree: Any = made.node_tree
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image = image
    shader = next(each for each in tree.nodes if each.type == "BSDF_DIFFUSE")
    tree.links.new(node.outputs["Color"], shader.inputs["Color"])
    context.scene.objects["Card"].data.materials.append(made)
    prepared = press(preparing())
    assert any("wood.png" in line for line in told_prepared(prepared.facts))


@pytest.mark.one_blender
def test_the_command_is_that_of_the_program_that_runs_radtex(
    out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    farm = out / "A farm.radtex-farm"
    blender = farm_command(Program("/opt/blender", is_blender=True), farm)
    assert blender == quoted(["blender", "-b", "-P", str(BAKE), "--", "work", str(farm)])
    assert farm_command(Program("/opt/python", is_blender=False), farm) == quoted(
        ["python", str(BAKE), "work", str(farm)]
    )


def test_the_panel_and_the_menu_have_the_buttons() -> None:
    layout: Any = RecordedLayout()
    RADTEX_PT_farm.draw(SimpleNamespace(layout=layout), context)  # type: ignore[arg-type]  # all that it asks for
    assert [name for name, _ in layout.buttons] == ["radtex.prepare_farm", "radtex.assemble_farm"]
    assert RADTEX_PT_farm.bl_options == {"DEFAULT_CLOSED"}
    assert RADTEX_OT_prepare_farm.poll(context)
    menu: Any = RecordedLayout()
    bpy.types.RADTEX_MT_object.draw(SimpleNamespace(layout=menu), context)  # type: ignore[attr-defined]  # ours
    assert {"radtex.prepare_farm", "radtex.assemble_farm"} <= {name for name, _ in menu.buttons}
