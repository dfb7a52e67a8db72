# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Exports that are made again after each bake: what the scene keeps of them, and what follows a bake."""

from __future__ import annotations

import json
import shutil
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import bpy
import pytest

from radtex_addon.cli.arguments import parse
from radtex_addon.core.errors import InputError
from radtex_addon.formats.json_reader import Facts
from radtex_addon.job.bake_plan import plan_bakes
from radtex_addon.textures.export_spec import (
    Arrangement,
    ExportSpec,
    MeshPacking,
    Target,
    export_facts,
    export_spec_in,
)
from radtex_addon.textures.kept_exports import kept_exports
from radtex_addon.ui.jobs import jobs
from radtex_addon.ui.panel import settings_panels
from radtex_addon.ui.panel.jobs_panel import job_title
from radtex_addon.ui.panel.remedies import offers
from radtex_addon.ui.panel.request_checks import foreseen
from radtex_addon.ui.settings.kept_exports import rows_of
from radtex_addon.ui.settings.request import request_of, values_of
from radtex_addon.worker.job import Job
from tests.blender import stage
from tests.blender.batch_process import process
from tests.blender.recorded_layout import RecordedLayout
from tests.blender.ui_stage import PATIENCE, context, finish_jobs, ops, preferences, registered, settings

BY_HAND = "made by hand"


@pytest.fixture(autouse=True)
def _card(empty_file: None, out: Path, tmp_path: Path) -> Iterator[None]:
    """A finished bake of a card, and of another one beside it."""
    with registered():
        stage.world()
        settings().directory, settings().atlas_layout = str(out), "buckets"
        settings().texels, settings().bucket, settings().samples = 4, 2, 1
        preferences().cache_folder = str(tmp_path / "cache")
        for number, name in enumerate(("Card", "Tile")):
            bpy.ops.mesh.primitive_plane_add(size=2, location=(5.0 * number, 0, 0))
            context.object.name = name
            assert ops.radtex.bake(object=name) == {"FINISHED"}
        yield


@pytest.fixture
def game(tmp_path: Path) -> Path:
    return tmp_path / "game"


def export(name: str, game: Path, **settings: Any) -> None:
    choice = {"target": "gltf", "into": str(game), "again": True} | settings
    assert ops.radtex.export(object=name, **choice) == {"FINISHED"}


def submit(*names: str, **choice: Any) -> None:
    values = values_of(settings()) | {"overwrite": True} | choice
    jobs.submit(context.scene, [plan_bakes(context.scene, request_of(values, names))])


def exports_of(found: tuple[Job, ...]) -> list[Job]:
    return [job for job in found if job.work == "export"]


def manifest(folder: Path, name: str = "Card") -> str:
    return (folder / f"{name}.gltf" / f"{name}.export.json").read_text(encoding="utf-8")


def drawn() -> RecordedLayout:
    layout = RecordedLayout()
    panel = SimpleNamespace(layout=layout)
    settings_panels.RADTEX_PT_output.draw(cast(Any, panel), context)
    return layout


def test_after_a_bake_its_export_is_made_again_as_it_was(game: Path, out: Path) -> None:
    """In the folder that was chosen and by the same settings, as a job of its own."""
    export("Card", game, format="ktx2-rgba16f", levels=1)
    export("Tile", game, again=False)
    before, tile = manifest(game), manifest(game, "Tile")
    (game / "Card.gltf" / "notes.txt").write_text(BY_HAND)
    submit("Card", "Tile", texels=8)
    assert [job.work for job in jobs.snapshot()] == ["bake", "bake"]
    found = finish_jobs()
    (job,) = exports_of(found)
    assert job.number == 3, "once both bakes are done"
    assert (job.state, job_title(job)) == ("done", "Card for glTF")
    assert job.files == (game / "Card.gltf",)
    assert manifest(game) != before, "it shows the new bake"
    assert '"format": "RGBA16F"' in manifest(game)
    assert '"format": "RGB9E5"' in manifest(game, "Tile"), "as is exported without that setting"
    assert manifest(game, "Tile") == tile, "that one was to be exported once"
    assert (game / "Card.gltf" / "notes.txt").read_text() == BY_HAND
    assert not (out / "Card.gltf").exists()


def test_what_is_not_baked_is_not_exported_again(game: Path) -> None:
    export("Card", game)
    before = manifest(game)
    submit("Tile")
    assert exports_of(finish_jobs()) == []
    assert manifest(game) == before


def test_bakes_that_are_exported_alike_are_one_job(game: Path) -> None:
    export("Card", game)
    export("Tile", game)
    submit("Card", "Tile", texels=8)
    (job,) = exports_of(finish_jobs())
    assert job_title(job) == "2 bakes for glTF"
    assert set(job.files) == {game / "Card.gltf", game / "Tile.gltf"}


def test_a_scene_is_exported_once_after_its_bakes(game: Path) -> None:
    for item in context.scene.objects:
        item.select_set(True)
    settings().together = "off"
    assert ops.radtex.export(target="gltf", into=str(game), as_scene=True, scene_name="Room", again=True) == {
        "FINISHED"
    }
    shutil.rmtree(game / "Room.gltf")
    submit("Card", "Tile")
    (job,) = exports_of(finish_jobs())
    assert (job.state, job_title(job)) == ("done", "Room for glTF")
    assert (game / "Room.gltf" / "Room.glb").is_file()


def test_an_export_that_fails_says_so_in_the_list_and_the_bake_stays_done(game: Path) -> None:
    export("Card", game)
    shutil.rmtree(game / "Card.gltf")
    (game / "Card.gltf").write_text(BY_HAND)
    submit("Card")
    bake, job = finish_jobs()
    assert (bake.state, job.state) == ("done", "failed")
    assert "Card.gltf" in str(job.message)
    assert (game / "Card.gltf").read_text() == BY_HAND


def test_nothing_is_exported_after_what_was_cancelled(game: Path) -> None:
    export("Card", game)
    before = manifest(game)
    submit("Card", "Tile")
    jobs.cancel()
    found = finish_jobs()
    assert {job.state for job in found} == {"cancelled"}
    assert exports_of(found) == []
    submit("Tile", "Card")
    jobs.cancel(3)  # the one that has an export goes on
    (job,) = exports_of(finish_jobs())
    assert job.state == "done"
    assert manifest(game) != before


def test_a_bake_without_its_preview_is_refused_where_it_is_exported_afterwards(game: Path) -> None:
    export("Card", game)
    with pytest.raises(InputError, match="'Card' is exported after each bake, from its preview: switch"):
        submit("Card", preview=False)
    settings().preview = False
    request = request_of(values_of(settings()), ("Card",))
    (error,) = foreseen(context.scene, replace(request, overwrite=True), 1.0).errors
    assert "'Card' is exported after each bake" in str(error), "the button is grey, and the panel says why"
    (offer,) = offers(error, settings())
    assert (offer.name, offer.text) == ("preview", "Switch On Preview")
    assert not foreseen(context.scene, replace(request, objects=("Tile",), overwrite=True), 1.0).errors
    settings().preview = True
    with pytest.raises(RuntimeError, match="'Card' is exported after each bake"):
        ops.radtex.bake(object="Card", overwrite=True, preview=False)
    submit("Tile", preview=False)
    assert jobs.snapshot()[0].object == "Tile"


def test_a_script_that_bakes_here_finds_the_new_export_too(game: Path) -> None:
    export("Card", game)
    before = manifest(game)
    assert ops.radtex.bake(object="Card", overwrite=True, texels=8) == {"FINISHED"}
    assert manifest(game) != before
    assert jobs.snapshot() == ()


def test_another_file_may_be_opened_while_it_bakes(game: Path) -> None:
    export("Card", game)
    before = manifest(game)
    submit("Card", texels=8)
    bpy.ops.wm.read_homefile(use_empty=True)
    (job,) = exports_of(finish_jobs())
    assert job.state == "done"
    assert manifest(game) != before


def test_a_bake_whose_object_was_renamed_is_exported_by_its_file_or_folder(game: Path, out: Path) -> None:
    """As the button of its job does, which names the object as it was called."""
    bpy.data.objects["Card"].name = "Other"
    sidecar = out / "Card.radiance.json"
    export("Card", game, bake=str(sidecar), again=False)
    made = game / "Card.gltf" / "Card.glb"
    before = made.read_bytes()
    export("Card", game, bake=str(out), again=False, overwrite=True)
    assert made.read_bytes() == before
    with pytest.raises(RuntimeError, match="no bake of 'Nothing'"):
        export("Nothing", game, bake=str(out))
    with pytest.raises(RuntimeError, match="No object 'Card' in view layer"):
        export("Card", game)


@pytest.mark.parametrize("finished_is_shown", [True, False])
def test_exports_follow_bakes_that_an_ended_blender_left(
    game: Path, tmp_path: Path, *, finished_is_shown: bool
) -> None:
    """Of the bakes that were done before it ended, too, though they were taken off the list."""
    for item in context.scene.objects:
        item.select_set(True)
    settings().together = "off"
    choice = {"into": str(game), "as_scene": True, "scene_name": "Room", "again": True}
    assert ops.radtex.export(target="gltf", **choice) == {"FINISHED"}
    export("Card", game)
    export("Tile", game)
    before = manifest(game), manifest(game, "Tile")
    shutil.rmtree(game / "Room.gltf")
    jobs.take_over(tmp_path / "lists")
    submit("Card", "Tile", texels=8)
    until = time.monotonic() + PATIENCE
    while jobs.snapshot()[0].state != "done":
        assert time.monotonic() < until, jobs.snapshot()
        jobs.advance()
        time.sleep(0.05)
    if not finished_is_shown:
        jobs.forget_ended()
    jobs.unregister()  # Blender ends
    assert manifest(game) == before[0], "it waits for the other bake"
    bpy.ops.wm.read_homefile(use_empty=True)
    jobs.take_over(tmp_path / "lists")
    assert [job.object for job in jobs.left()] == ["Tile"]
    assert ops.radtex.go_on() == {"FINISHED"}
    found = finish_jobs()
    assert {job_title(job): str(job.state) for job in exports_of(found)} == {
        "2 bakes for glTF": "done",
        "Room for glTF": "done",
    }
    assert manifest(game) != before[0]
    assert manifest(game, "Tile") != before[1]
    assert (game / "Room.gltf" / "Room.glb").is_file()
    assert not list((tmp_path / "lists").glob("*.json")), "nothing is left to be told"


def test_a_left_bake_that_is_not_gone_on_with_does_not_hold_up_the_exports_of_others(
    game: Path, tmp_path: Path
) -> None:
    """Each is exported once: with those that were gone on with at the same time."""
    export("Card", game)
    export("Tile", game)
    jobs.take_over(tmp_path / "lists")
    submit("Card", "Tile", texels=8)
    jobs.unregister()
    jobs.take_over(tmp_path / "lists")
    card, tile = (job.number for job in jobs.left())
    assert ops.radtex.go_on(number=card) == {"FINISHED"}
    assert [job_title(job) for job in exports_of(finish_jobs())] == ["Card for glTF"]
    assert ops.radtex.go_on(number=tile) == {"FINISHED"}
    assert [job_title(job) for job in exports_of(finish_jobs())] == ["Card for glTF", "Tile for glTF"]


def test_the_scene_keeps_one_export_of_a_bake_for_each_target(game: Path, tmp_path: Path) -> None:
    export("Card", game)
    export("Card", game, target="raw", zstd=False)
    export("Card", tmp_path / "other")
    kept = [(found.name, found.spec.target, found.out.parent) for found in kept_exports(context.scene)]
    assert kept == [("Card", Target.RAW, game), ("Card", Target.GLTF, tmp_path / "other")]
    assert not kept_exports(context.scene)[0].spec.zstd
    assert ops.radtex.export(object="Card", target="raw", into=str(game), overwrite=True) == {"FINISHED"}
    assert len(rows_of(context.scene)) == 2, "a script that does not speak of it changes nothing"
    export("Card", game, target="raw", again=False, overwrite=True)
    assert [found.spec.target for found in kept_exports(context.scene)] == [Target.GLTF]


def test_a_folder_is_that_of_one_export(game: Path) -> None:
    export("Card", game, into="", directory=str(game / "thing"))
    export("Tile", game, into="", directory=str(game / "thing"), overwrite=True)
    assert [row.name for row in rows_of(context.scene)] == ["Tile"]


def test_it_is_kept_in_the_file_and_moves_with_its_folder(tmp_path: Path) -> None:
    project = tmp_path / "project"
    project.mkdir()
    bpy.ops.wm.save_as_mainfile(filepath=str(project / "scene.blend"))
    settings().directory = "//baked"
    ops.radtex.bake(object="Card")
    export("Card", Path(), into="//game")
    assert rows_of(context.scene)[0].folder == "//game/Card.gltf"
    bpy.ops.wm.save_mainfile()
    moved = shutil.copytree(project, tmp_path / "moved")
    before = manifest(project / "game")
    bpy.ops.wm.open_mainfile(filepath=str(moved / "scene.blend"))
    ops.radtex.bake(object="Card", overwrite=True, overwrite_any=True, texels=8)
    assert manifest(moved / "game") != before
    assert manifest(project / "game") == before


def test_the_batch_makes_it_again_where_that_is_asked_for(game: Path, out: Path) -> None:
    """By what the .blend says, in a Blender where RadTex is not enabled; others are made where one fails."""
    file = game.parent / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(file))
    export("Card", game)
    export("Card", game, target="raw")
    export("Tile", game)
    bpy.ops.wm.save_mainfile()
    before, tile = manifest(game), manifest(game, "Tile")
    shutil.rmtree(game / "Card.raw")
    (game / "Card.raw").write_text(BY_HAND)
    line = [file, "--object", "Card", "--out", out, "--texels", "8", "--layout", "buckets", "--bucket", "2"]
    line += ["--samples", "1", "--overwrite-any", "--save-preview", "--export-again", "--progress", "json"]
    ended = process(*line)
    done = [event for event in map(json.loads, ended.out.splitlines()) if event["event"] == "done"]
    assert [event["files"] for event in done][1:] == [[str(game / "Card.gltf")]]
    assert manifest(game) != before
    assert manifest(game, "Tile") == tile
    assert ended.code == 2
    assert "Card.raw" in ended.err
    (game / "Card.raw").unlink()
    assert process(*line).code == 0
    assert (game / "Card.raw" / "Card.glb").is_file()
    with pytest.raises(InputError, match="--export-again makes exports from the preview"):
        parse(["scene.blend", "--object", "Card", "--export-again"], inside_blender=False)


def test_settings_of_a_later_version_are_left_out_and_can_be_taken_off(game: Path) -> None:
    export("Card", game)
    (row,) = rows_of(context.scene)
    row.spec = row.spec.replace('"gltf"', '"hologram"')
    assert kept_exports(context.scene) == ()
    assert "Card" in drawn().texts
    submit("Card")
    assert exports_of(finish_jobs()) == []
    assert ops.radtex.forget_export(row=0) == {"FINISHED"}
    assert len(rows_of(context.scene)) == 0


def test_the_panel_lists_them_with_a_cross_each(game: Path) -> None:
    assert "After Each Bake" not in drawn().texts
    export("Card", game)
    export("Tile", game, target="raw")
    layout = drawn()
    at = layout.texts.index("After Each Bake")
    assert layout.texts[at + 1] == "Card for glTF"
    assert any(text.endswith("Card.gltf") for text in layout.texts)
    assert "Tile for Raw" in layout.texts
    crosses = [button for name, button in layout.buttons if name == "radtex.forget_export"]
    assert [button.row for button in crosses] == [0, 1]
    assert ops.radtex.forget_export(row=0) == {"FINISHED"}
    assert [row.name for row in rows_of(context.scene)] == ["Tile"]
    assert (game / "Card.gltf").is_dir(), "what was exported stays"
    with pytest.raises(RuntimeError, match="not on the list any more"):
        ops.radtex.forget_export(row=1)


def test_settings_of_an_export_come_back_from_json() -> None:
    spec = ExportSpec(Target.WEB, levels=3, limit=512, zstd=False, arrangement=Arrangement.SLICES)
    spec = replace(spec, mesh=MeshPacking.PLAIN)
    for each in (spec, ExportSpec(Target.GODOT, mirror=True, sky=(0.1, 0.2, 0.3), image_limit=0)):
        assert export_spec_in(Facts(export_facts(each), "here")) == each
