# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""In a narrow sidebar, and at a large UI scale, no text of the panels is wider than its place."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import bpy
import pytest

from radtex_addon.core.messages import Message
from radtex_addon.settings.spec import BakeSpec
from radtex_addon.settings.targets import Target
from radtex_addon.settings.time_left import Left
from radtex_addon.textures.export_spec import ExportSpec
from radtex_addon.ui.jobs import jobs
from radtex_addon.ui.panel import fitting, panel_state
from radtex_addon.ui.panel.cost_panel import RADTEX_PT_cost
from radtex_addon.ui.panel.finished_panel import RADTEX_PT_afterwards
from radtex_addon.ui.panel.jobs_panel import RADTEX_PT_jobs
from radtex_addon.ui.panel.list_panel import RADTEX_PT_list, RADTEX_UL_listed, buttons_below
from radtex_addon.ui.panel.main_panel import RADTEX_PT_bake
from radtex_addon.ui.panel.settings_panels import (
    RADTEX_PT_light,
    RADTEX_PT_output,
    RADTEX_PT_sampling,
    RADTEX_PT_surface,
)
from radtex_addon.worker.job import Job, JobMap, JobState
from radtex_addon.worker.order import Handover
from radtex_addon.worker.orders import order_bake, order_export
from tests.blender import stage
from tests.blender.recorded_layout import RecordedLayout
from tests.blender.ui_stage import context, ops, registered, settings

# Of the sidebar's width, without a box: tabs, the panel's margins and those of a text, at UI scale 1.
MARGINS = 54.0
WINDOWS = [(width, scale) for width in (165, 245, 300) for scale in (1.0, 1.5) if width / scale > 150]
LONG = "Kitchen_Cabinet_Door_With_Handle.012"
PANELS = (
    *(RADTEX_PT_bake, RADTEX_PT_light, RADTEX_PT_surface, RADTEX_PT_sampling, RADTEX_PT_output),
    *(RADTEX_PT_cost, RADTEX_PT_jobs, RADTEX_PT_list, RADTEX_PT_afterwards),
)


@pytest.fixture(autouse=True)
def _registered(empty_file: None, tmp_path: Path) -> Iterator[None]:
    with registered():
        stage.world()
        settings().directory = str(tmp_path / "out")
        yield


@pytest.fixture(params=WINDOWS, ids=lambda window: f"{window[0]}-{window[1]}")
def room(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> float:
    """The width that a text may have, in a sidebar of some pixels at some UI scale."""
    return narrow(monkeypatch, *request.param)


def narrow(monkeypatch: pytest.MonkeyPatch, width: int, scale: float) -> float:
    """The same."""
    monkeypatch.setattr(fitting, "_scale", lambda: scale)
    monkeypatch.setattr(fitting, "bpy", SimpleNamespace(context=_Narrow(width)))
    return float(width / scale - MARGINS)


class _Narrow:
    """Blender's context, with a sidebar of that width."""

    def __init__(self, width: int) -> None:
        self.region = SimpleNamespace(width=width)

    def __getattr__(self, name: str) -> Any:
        return getattr(bpy.context, name)


def cabinets(count: int) -> None:
    for number in range(count):
        bpy.ops.mesh.primitive_plane_add(size=2, location=(4 * number, 0, 0))
        context.object.name = f"{LONG[:-1]}{number}"
        context.object.data.materials.append(stage.material("Oak", "ShaderNodeBsdfGlossy", Roughness=0.3))
    bpy.ops.object.select_all(action="SELECT")


def lost_image() -> None:
    """The active object shows an image whose file is missing."""
    image: Any = bpy.data.images.new("Oak", 8, 8)
    image.source, image.filepath = "FILE", "//textures/kitchen/wood/oak_planks_colour_4k.png"
    tree = context.object.active_material.node_tree
    tree.nodes.new("ShaderNodeTexImage").image = image


def texts(*, forget: bool = False) -> list[str]:
    """All that the panels draw of the open scene."""
    panel_state.refresh(context.scene, context.view_layer)
    if forget:
        panel_state._cache.found.clear()
    layout: Any = RecordedLayout()
    for panel in PANELS:
        if not hasattr(panel, "poll") or panel.poll(context):
            panel.draw(SimpleNamespace(layout=layout), context)  # type: ignore[arg-type]  # draws all the same
    return [text for text in layout.texts if text]


def too_wide(found: list[str], room: float) -> dict[str, float]:
    return {text: width for text in found if (width := fitting.text_width(text)) > room}


def test_what_is_said_of_objects_and_settings_fits(room: float) -> None:
    assert not too_wide(texts(), room), "of an empty scene"
    cabinets(1)
    lost_image()
    one = texts()
    assert "planks" in "".join(one)
    assert not too_wide(one, room)
    cabinets(3)
    settings().uv_layer = "A layer that none of these objects has"
    several = texts()
    assert not too_wide(several, room)
    assert not too_wide(texts(forget=True), room), "before anything was worked out"


def test_in_the_narrowest_sidebar_the_buttons_to_press_have_whole_words(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    narrow(monkeypatch, 165, 1.5)
    cabinets(1)
    names = (context.object.name,)
    found = panel_state.Forecast(names, next=panel_state.Next.REPLACE, finished=1)
    monkeypatch.setattr("radtex_addon.ui.panel.main_panel.cached_forecast", lambda *_: found)
    layout: Any = RecordedLayout()
    panel: Any = SimpleNamespace(layout=layout)
    (area,) = [one for one in context.window_manager.windows[0].screen.areas if one.type == "VIEW_3D"]
    area.spaces.active.shading.type = "SOLID"
    with context.temp_override(window=context.window_manager.windows[0], area=area):
        RADTEX_PT_bake.draw(panel, context)
    for word in ("Scene's", "Again", "Scene…"):
        assert word in layout.texts, layout.texts
    assert layout.texts.count("Preview") == 2, "the preset and the button"
    assert layout.texts.count("") >= 2, "icons alone for the shadings"
    assert "replaced" in layout.texts, "a whole word, without the icon for which it would be broken"
    several = panel_state.Forecast(("Cup", "Plate"), next=panel_state.Next.BAKE)
    monkeypatch.setattr("radtex_addon.ui.panel.main_panel.cached_forecast", lambda *_: several)
    panel.layout = layout = RecordedLayout()
    RADTEX_PT_bake.draw(panel, context)
    assert layout.texts[0] == "2", "where 2 objects has no room"


def test_jobs_fit_whatever_becomes_of_them(
    room: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    cabinets(1)
    shown = every_job(tmp_path)
    monkeypatch.setattr(jobs._session, "shown", shown)
    monkeypatch.setattr(jobs._session, "folded", {job.number: False for job in shown})
    found = texts()
    assert not too_wide(found, room)
    letters = "".join(found).replace(" ", "")
    assert letters.count(LONG) >= 2, "of a title that is shortened, the whole stands below"
    assert "oak_planks_colour_4k.png" in letters, "the file's name can be read"


def every_job(folder: Path) -> tuple[Job, ...]:
    """A job in each state, with long names and messages."""
    handover = Handover(folder, folder / "room.blend", "Scene", None, "cpu", 0.0)
    bake = order_bake(handover, LONG, BakeSpec(), folder)
    export = order_export(folder, [(LONG, folder / f"{LONG}.json", folder / LONG)], ExportSpec(Target.WEB))
    lost = Message("image 'Oak' is missing: put //textures/kitchen/wood/oak_planks_colour_4k.png back")
    job = Job(1, bake, warnings=(lost,), map=JobMap(folder / "map.png", 41, 0.55), took=700.0)
    return (
        replace(
            job, state=JobState.RUNNING, stage="surroundings", fraction=0.3, left=Left(4000.0, 3000.0, 5400.0)
        ),
        replace(job, number=2, state=JobState.RUNNING, stage="surroundings"),
        replace(job, number=3),
        replace(job, number=4, state=JobState.CANCELLED),
        replace(job, number=5, state=JobState.FAILED, message=Message(f"object '{LONG}' is no longer there")),
        replace(job, number=6, state=JobState.DONE, facts={"clamped": 16777216}),
        Job(7, export, state=JobState.DONE, took=3.0, files=(folder / LONG,), facts={"bytes": 10**9}),
    )


def test_names_in_the_bake_list_fit_and_keep_their_numbers(room: float) -> None:
    cabinets(2)
    context.scene.radtex_chosen.source = "list"
    ops.radtex.list_add(what="SELECTED")
    chosen = context.scene.radtex_chosen
    layout: Any = RecordedLayout()
    for item in chosen.listed:
        listed: Any = SimpleNamespace(layout=layout)
        RADTEX_UL_listed.draw_item(listed, context, layout, chosen, item, 0, chosen, "active")
    assert [text[-1] for text in layout.texts] == ["0", "1"]
    # The box to tick, the pin, and the buttons where they are beside the list.
    beside = (3 if buttons_below() else 4) * fitting.BUTTON - 12
    assert buttons_below() == (room < 120)
    assert not too_wide(layout.texts, room - beside)
    assert not too_wide(texts(), room)
