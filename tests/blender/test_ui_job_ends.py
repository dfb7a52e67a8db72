# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""When no job is left to do, one line says what they came to, also where the sidebar is hidden."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import bpy
import pytest

from radtex_addon.core.messages import Message
from radtex_addon.job.bake_plan import plan_bakes
from radtex_addon.settings.spec import BakeSpec
from radtex_addon.settings.targets import Target
from radtex_addon.textures.export_spec import ExportSpec
from radtex_addon.ui.jobs import jobs
from radtex_addon.ui.operators.job_operators import RADTEX_OT_show_jobs
from radtex_addon.ui.panel import fitting, job_ends
from radtex_addon.ui.panel.job_ends import End, draw_end, end_of
from radtex_addon.ui.settings.request import request_of, values_of
from radtex_addon.worker.job import Job, JobState
from radtex_addon.worker.order import Handover
from radtex_addon.worker.orders import order_bake, order_export
from tests.blender import stage
from tests.blender.recorded_layout import RecordedLayout
from tests.blender.ui_stage import context, finish_jobs, ops, preferences, registered, settings


@pytest.fixture(autouse=True)
def _registered(empty_file: None, out: Path, tmp_path: Path) -> Iterator[None]:
    with registered():
        stage.world()
        settings().directory = str(out)
        settings().atlas_layout = "buckets"
        settings().texels, settings().bucket, settings().samples = 8, 2, 1
        preferences().cache_folder = str(tmp_path / "cache")
        yield


def submit(*names: str) -> None:
    jobs.submit(context.scene, [plan_bakes(context.scene, request_of(values_of(settings()), names))])


def planes(*names: str) -> None:
    for number, name in enumerate(names):
        bpy.ops.mesh.primitive_plane_add(size=2, location=(4 * number, 0, 0))
        context.object.name = name


def in_the_header(area: Any = None) -> list[str]:
    """What a 3D view's header says, all but the cross."""
    layout: Any = RecordedLayout()
    draw_end(SimpleNamespace(layout=layout), SimpleNamespace(area=area))  # type: ignore[arg-type]  # all that it asks for
    return [text for text in layout.texts if text]


def test_the_end_of_all_bakes_is_told_once_and_stays_until_it_is_clicked() -> None:
    planes("Card", "Cup")
    submit("Card", "Cup")
    assert in_the_header() == []
    while not any(job.ended for job in jobs.snapshot()):
        jobs.advance()
    assert in_the_header() == [], "another bake is still to come"
    finish_jobs()
    (told,) = in_the_header()
    assert told.startswith("Done 2 jobs in ")
    jobs.advance()
    assert in_the_header() == [told]
    assert ops.radtex.show_jobs(show=False) == {"FINISHED"}
    assert in_the_header() == []
    jobs.advance()
    assert in_the_header() == [], "it is told once"


def test_the_line_goes_with_the_next_job_and_with_its_own_jobs() -> None:
    planes("Card", "Cup")
    submit("Card")
    finish_jobs()
    assert in_the_header()[0].startswith("Baked Card in ")
    submit("Cup")
    assert in_the_header() == []
    finish_jobs()
    assert in_the_header()[0].startswith("Baked Cup in ")
    card, cup = jobs.snapshot()
    jobs.forget_ended(card.number)
    assert in_the_header() != [], "it is about the other job"
    jobs.forget_ended(cup.number)
    assert in_the_header() == []


def test_nothing_is_told_where_the_preferences_say_so() -> None:
    preferences().notify = False
    planes("Card")
    submit("Card")
    finish_jobs()
    assert jobs.snapshot()[0].state is JobState.DONE
    assert in_the_header() == []
    preferences().notify = True
    jobs.advance()
    assert in_the_header() == [], "not afterwards, either"


def test_cancelled_jobs_are_no_news_and_failures_say_why(tmp_path: Path) -> None:
    handover = Handover(tmp_path, tmp_path / "room.blend", "Scene", None, "cpu", 0.0)
    bake = Job(1, order_bake(handover, "Card", BakeSpec(), tmp_path), state=JobState.DONE, took=600.0)
    cancelled = replace(bake, number=2, state=JobState.CANCELLED)
    failed = replace(
        bake, number=3, state=JobState.FAILED, message=Message("object 'Card' is no longer there")
    )
    where = [(name, tmp_path / f"{name}.json", tmp_path / name) for name in ("Card", "Cup", "Jug")]
    order = order_export(tmp_path, where, ExportSpec(Target.WEB))
    export = Job(4, order, state=JobState.DONE, took=3.0)
    assert end_of([cancelled]) is None
    assert end_of([bake, cancelled]) == End("Baked Card in 10 min", False, frozenset({1, 2}))
    assert end_of([failed]) == End("Card failed: Object 'Card' is no longer there", True, frozenset({3}))
    found = end_of([bake, failed, export])
    assert found is not None
    assert found.text == "1 of 3 jobs failed. Card failed: Object 'Card' is no longer there"
    told = end_of([export])
    assert told is not None
    assert told.text == "Exported Card and 2 more in 3 s"


def test_a_long_line_is_cut_in_the_header_and_whole_in_its_tooltip(tmp_path: Path) -> None:
    handover = Handover(tmp_path, tmp_path / "room.blend", "Scene", None, "cpu", 0.0)
    why = Message("the bake ended early (killed by signal 9): bake again, with fewer texels")
    bake = order_bake(handover, "Card", BakeSpec(), tmp_path)
    job_ends.tell([Job(1, bake, state=JobState.FAILED, message=why)])
    (shown,) = in_the_header()
    assert fitting.text_width(shown) <= job_ends._ROOM
    assert shown.startswith("Card failed: The bake ended early")
    tooltip = RADTEX_OT_show_jobs.description(None, SimpleNamespace(show=True))
    assert tooltip.startswith(
        "Card failed: The bake ended early (killed by signal 9): bake again, with fewer"
    )


def test_a_view_whose_sidebar_shows_the_jobs_says_nothing_itself(tmp_path: Path) -> None:
    job_ends.tell([bake_of(tmp_path)])
    sidebar = SimpleNamespace(type="UI", width=245, active_panel_category="RadTex")
    area = SimpleNamespace(type="VIEW_3D", regions=[SimpleNamespace(type="WINDOW"), sidebar])
    assert in_the_header(area) == []
    sidebar.active_panel_category = "Item"
    assert len(in_the_header(area)) == 1
    sidebar.active_panel_category, sidebar.width = "RadTex", 1
    assert len(in_the_header(area)) == 1, "it is hidden"


def bake_of(folder: Path) -> Job:
    handover = Handover(folder, folder / "room.blend", "Scene", None, "cpu", 0.0)
    return Job(1, order_bake(handover, "Card", BakeSpec(), folder), state=JobState.DONE, took=60.0)


def test_the_list_is_shown_in_a_3d_view_alone() -> None:
    with pytest.raises(RuntimeError, match="Put the mouse over a 3D view"):
        ops.radtex.show_jobs()
    assert ops.radtex.tell_end(text="RadTex: Baked Card") == {"FINISHED"}
