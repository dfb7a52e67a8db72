# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel asks before it replaces a better bake or another file's; jobs tell what became of their files."""

from __future__ import annotations

import json
import shutil
import time
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import bpy
import pytest

from radtex_addon.core.sampler import Filter
from radtex_addon.job import bake_object
from radtex_addon.job.bake_plan import plan_bakes
from radtex_addon.store.ownership import UNSAVED, Overwrite
from radtex_addon.ui.jobs import jobs
from radtex_addon.ui.jobs.job_files import Fate, fate
from radtex_addon.ui.operators.bake_lookup import sidecar_of
from radtex_addon.ui.operators.bake_operator import RADTEX_OT_bake
from radtex_addon.ui.panel import jobs_panel, panel_state
from radtex_addon.ui.panel.panel_state import Next
from radtex_addon.ui.settings.request import request_of, spec_of, values_of
from tests.blender import stage
from tests.blender.recorded_layout import RecordedLayout
from tests.blender.ui_stage import PATIENCE, context, finish_jobs, ops, preferences, registered, settings

pytestmark = pytest.mark.one_blender


@pytest.fixture(autouse=True)
def _registered(empty_file: None, tmp_path: Path) -> Iterator[None]:
    with registered():
        stage.world()
        settings().atlas_layout = "buckets"
        settings().texels, settings().bucket, settings().samples, settings().preview = 4, 2, 2, False
        preferences().cache_folder = str(tmp_path / "cache")
        bpy.ops.mesh.primitive_plane_add(size=2)
        context.object.name = "Card"
        yield


def save(path: Path) -> None:
    bpy.ops.wm.save_as_mainfile(filepath=str(path))


def facts(path: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(path.read_text())
    return found


def pressed(**arguments: object) -> tuple[str, ...]:
    """What the dialog asks when the button is pressed; nothing if it bakes at once."""
    asked: list[str] = []

    def invoke(operator: Any, around: Any) -> Any:  # without a window Blender calls `execute` at once
        operator.ask_for(around)
        asked.extend(operator._asked)
        return {"CANCELLED"}

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(RADTEX_OT_bake, "execute", invoke)
        ops.radtex.bake(**arguments)
    return tuple(asked)


def test_the_button_asks_before_a_better_bake_is_replaced(out: Path) -> None:
    settings().directory = str(out)
    assert ops.radtex.bake() == {"FINISHED"}
    assert pressed(overwrite=True) == ()  # one that is as good
    settings().samples = 1
    found = panel_state.refresh(context.scene, context.view_layer)
    assert (found.next, found.errors) == (Next.REPLACE, ())
    (asked,) = pressed(overwrite=True, show_object=True)
    assert asked == (
        "Card.radiance.json is a better bake (buckets, 4 texels, 2 cells a side, 2 samples) than the new one "
        "would be (buckets, 4 texels, 2 cells a side, 1 sample)"
    )
    assert pressed(only="changed") == (asked,)
    with pytest.raises(RuntimeError, match=r"is a better bake.*Overwrite Any"):
        ops.radtex.bake(overwrite=True)
    assert facts(out / "Card.radiance.json")["samples"] == 2
    assert ops.radtex.bake(only="changed", overwrite_any=True) == {"FINISHED"}
    assert facts(out / "Card.radiance.json")["samples"] == 1


@pytest.mark.parametrize(("count", "more"), [(1, ()), (8, ()), (10, ("and 2 more",))])
def test_the_dialog_counts_those_questions_alone_that_it_does_not_show(
    count: int, more: tuple[str, ...]
) -> None:
    layout, asked = RecordedLayout(), tuple(f"{number}?" for number in range(count))
    draw: Any = RADTEX_OT_bake.draw
    draw(SimpleNamespace(layout=layout, _asked=asked), context)
    assert layout.texts == [*asked[:8], *more]


def test_the_button_asks_before_another_files_bake_is_replaced(out: Path, tmp_path: Path) -> None:
    settings().directory = str(out)
    save(tmp_path / "a.blend")
    assert ops.radtex.bake() == {"FINISHED"}
    save(tmp_path / "b.blend")
    asked = ("Card.radiance.json is a bake of a.blend, not of b.blend",)
    assert pressed(overwrite=True) == asked
    assert pressed(accumulate=True) == asked
    with pytest.raises(RuntimeError, match=r"is a bake of a\.blend, not of b\.blend"):
        ops.radtex.bake(overwrite=True)
    assert facts(out / "Card.radiance.json")["blend"] == "a.blend"


def test_bakes_of_earlier_versions_are_found_in_the_common_folder(tmp_path: Path) -> None:
    save(tmp_path / "a.blend")
    flat, spec = tmp_path / "radtex" / "Card.radiance.json", spec_of(values_of(settings()))
    former = Overwrite(blend=UNSAVED)  # those versions noted no file
    bake_object(context.scene, "Card", spec, flat.parent, preview=Filter.NEAREST, overwrite=former)
    assert "blend" not in facts(flat)
    assert sidecar_of(context.scene, "Card", "") == flat
    assert ops.radtex.export(object="Card", target="raw") == {"FINISHED"}
    assert (tmp_path / "radtex" / "Card.raw").is_dir()
    assert panel_state.refresh(context.scene, context.view_layer).next is Next.BAKE  # it replaces nothing
    assert ops.radtex.bake() == {"FINISHED"}
    assert sidecar_of(context.scene, "Card", "") == tmp_path / "radtex" / "a" / "Card.radiance.json"
    others = Overwrite(True, blend=Path("b.blend"))
    bake_object(context.scene, "Card", spec, flat.parent, preview=Filter.NEAREST, overwrite=others)
    shutil.rmtree(tmp_path / "radtex" / "a")
    with pytest.raises(RuntimeError, match="othing was baked into"):
        ops.radtex.preview_toggle(object="Card", action="ON")


def test_an_unfinished_bake_in_the_common_folder_is_gone_on_with(tmp_path: Path) -> None:
    save(tmp_path / "a.blend")
    settings().texels, settings().bucket, settings().samples = 64, 8, 6
    submit(directory="//radtex/")
    flat, until = tmp_path / "radtex", time.monotonic() + PATIENCE
    while not list(flat.glob("*.radtex-unfinished")) or jobs.snapshot()[0].fraction < 0.3:
        assert time.monotonic() < until
        jobs.advance()
        time.sleep(0.02)
    jobs.cancel()
    finish_jobs()
    assert "radtex.bake" in dict(drawn(0).buttons)  # Resume
    save(tmp_path / "b.blend")  # whose object the button would bake
    assert "radtex.bake" not in dict(drawn(0).buttons)
    save(tmp_path / "a.blend")
    settings().property_unset("directory")
    found = panel_state.refresh(context.scene, context.view_layer)
    assert (found.next, found.errors, found.unfinished) == (Next.RESUME, (), 1)
    submit(resume=True)
    assert "radtex.bake" not in dict(drawn(0).buttons)  # that one goes on with it
    finish_jobs()
    assert "radtex.bake" not in dict(drawn(0).buttons)
    assert [path.name for path in flat.glob("*.json")] == ["Card.radiance.json"]
    assert not (flat / "a").exists()
    assert facts(flat / "Card.radiance.json")["blend"] == "a.blend"


def submit(**choice: object) -> None:
    values = values_of(settings()) | choice
    jobs.submit(context.scene, [plan_bakes(context.scene, request_of(values, ("Card",)))])


def drawn(number: int) -> RecordedLayout:
    layout, job = RecordedLayout(), jobs.snapshot()[number]
    if jobs.is_folded(job):
        assert ops.radtex.fold_job(number=job.number) == {"FINISHED"}
    jobs_panel._draw_job(layout, job)
    return layout


def test_a_job_says_so_once_other_files_are_in_the_place_of_its_own(out: Path, tmp_path: Path) -> None:
    settings().directory, settings().preview = str(out), True
    save(tmp_path / "a.blend")
    submit()
    finish_jobs()
    assert facts(out / "Card.radiance.json")["blend"] == "a.blend"  # not the worker's copy
    shown = dict(drawn(0).buttons)["radtex.preview_toggle"]
    number = jobs.snapshot()[0].number
    assert (shown.object, shown.job) == ("Card", number)
    arguments = {"object": shown.object, "bake": shown.bake, "job": shown.job}
    assert ops.radtex.preview_toggle(**arguments) == {"FINISHED"}
    assert ops.radtex.preview_toggle(**arguments) == {"FINISHED"}

    submit(samples=3, overwrite=True)  # another job replaces it
    finish_jobs()
    assert [fate(job.number) for job in jobs.snapshot()] == [Fate.REPLACED, Fate.THERE]
    assert "Other files have replaced its own since" in " ".join(drawn(0).texts)
    assert {name for name, _ in drawn(0).buttons} == {
        "radtex.fold_job",
        "radtex.clear_jobs",
        "radtex.fold_map",
    }
    assert "radtex.export" in dict(drawn(1).buttons)

    assert jobs_panel.job_title(jobs.snapshot()[1]) == "Card"
    save(tmp_path / "b.blend")
    assert jobs_panel.job_title(jobs.snapshot()[1]) == "Card (a.blend)"
    assert "radtex.preview_toggle" in dict(drawn(1).buttons)  # a copy's own object is there
    item = context.scene.objects["Card"]
    item.name = "Another"
    assert "radtex.preview_toggle" not in dict(drawn(1).buttons)
    assert "Open a.blend to preview it" in " ".join(drawn(1).texts)
    save(tmp_path / "a.blend")
    assert "radtex.preview_toggle" not in dict(drawn(1).buttons)
    assert "No object is called 'Card' any more: give it that name again" in " ".join(drawn(1).texts)
    assert "radtex.export" in dict(drawn(1).buttons)
    with pytest.raises(RuntimeError, match="give the object that name again if you renamed it"):
        ops.radtex.preview_toggle(**arguments | {"job": jobs.snapshot()[1].number})
    item.name = "Card"
    arguments["job"] = jobs.snapshot()[1].number
    assert ops.radtex.bake(overwrite_any=True, samples=1) == {"FINISHED"}  # another process replaces that
    with pytest.raises(RuntimeError, match="he files of this job have been replaced by others since"):
        ops.radtex.preview_toggle(**arguments, action="ON")
    assert not context.scene.objects["Card"].hide_render
    for path in out.glob("Card.radiance.*"):
        path.unlink()
    panel_state.refresh(context.scene, context.view_layer)
    assert fate(arguments["job"]) is Fate.GONE


def test_the_button_of_a_job_shows_its_own_bake_in_the_place_of_another(out: Path, tmp_path: Path) -> None:
    settings().preview = True
    save(tmp_path / "a.blend")
    for folder in ("one", "two"):
        submit(directory=str(out / folder))
    finish_jobs()

    def buttons() -> list[SimpleNamespace]:
        return [dict(drawn(number).buttons)["radtex.preview_toggle"] for number in range(2)]

    for shown, folder in ((0, "one"), (1, "two")):
        assert ops.radtex.preview_toggle(**vars(buttons()[shown])) == {"FINISHED"}
        (path,) = {bpy.path.abspath(image.filepath) for image in bpy.data.images if image.filepath}
        assert Path(path) == out / folder / "Card.radiance.exr"
        found = buttons()
        assert (found[shown].action, found[1 - shown].action) == ("TOGGLE", "ON")
    assert ops.radtex.preview_toggle(**vars(buttons()[1])) == {"FINISHED"}
    assert not context.scene.objects["Card"].hide_render
    assert [button.action for button in buttons()] == ["TOGGLE", "TOGGLE"]
