# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel, the Object menu and the pie menu call each thing by one word, in every state."""

from __future__ import annotations

from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import bpy
import pytest

from radtex_addon.ui.panel import menus, panel_state
from radtex_addon.ui.panel.finished_panel import RADTEX_PT_afterwards
from radtex_addon.ui.panel.main_panel import RADTEX_PT_bake
from radtex_addon.ui.panel.next_buttons import ACTIONS, bake_buttons
from radtex_addon.ui.panel.panel_state import Forecast, Next, ShownCopy
from tests.blender.recorded_layout import RecordedLayout
from tests.blender.test_swap import NAME, ball
from tests.blender.ui_stage import context, registered

COPY = ShownCopy("Ball (baked copy)", NAME, has_original=True, bake="newer")
STATES = {
    "nothing is there": (Forecast((NAME,), next=Next.BAKE), ["Bake Radiance Texture"]),
    "a bake is there": (Forecast((NAME,), next=Next.REPLACE, finished=1), ["Bake Again"]),
    "a bake was begun": (Forecast((NAME,), next=Next.RESUME, unfinished=1), ["Resume", "Bake Again"]),
    "some are there": (Forecast((NAME,), next=Next.RESUME, finished=1), ["Bake the Others", "Bake Again"]),
    "it is baked now": (Forecast((NAME,), next=Next.WAIT), ["Being Baked"]),
    "there are errors": (Forecast((NAME,), next=Next.NOTHING), ["Bake Radiance Texture"]),
    "a copy": (Forecast((), copies=(COPY,)), ["Select Original", "Update Copy", "Delete Copy"]),
    "copies": (
        Forecast((), copies=(COPY, COPY)),
        ["Select Originals", "Update Copies", "Delete Copies"],
    ),
}


@pytest.fixture(autouse=True)
def _registered() -> Iterator[None]:
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    with registered():
        ball()
        yield


def drawn(*classes: Any) -> RecordedLayout:
    """What panels, one below the other, or a menu draw."""
    layout = RecordedLayout()
    for cls in classes:
        cls.draw(SimpleNamespace(layout=layout), context)
    return layout


def words(layout: RecordedLayout) -> set[str]:
    """The texts of its buttons, but for those that show their operator's own label."""
    return {text for text in layout.texts if text}


@pytest.mark.parametrize("state", STATES)
def test_menus_say_what_the_panels_button_says(state: str, monkeypatch: pytest.MonkeyPatch) -> None:
    found, wanted = STATES[state]
    for module in ("main_panel", "menus"):
        monkeypatch.setattr(f"radtex_addon.ui.panel.{module}.cached_forecast", lambda *_: found)
    assert [button.texts[0] for button in bake_buttons(found)] == wanted
    every = {text for _, texts in STATES.values() for text in texts}
    for cls in (RADTEX_PT_bake, menus.RADTEX_MT_object, menus.RADTEX_MT_pie):
        layout = drawn(cls)
        assert sorted(words(layout) & every) == sorted(wanted), cls
        asked = [vars(arguments) for name, arguments in layout.buttons if name == "radtex.bake"]
        assert [(one["resume"], one["overwrite"]) for one in asked] == [
            (one.resume, one.overwrite) for one in bake_buttons(found) if one.operator == "radtex.bake"
        ]


def test_what_comes_after_a_bake_is_called_alike(monkeypatch: pytest.MonkeyPatch) -> None:
    found = Forecast((NAME,), next=Next.REPLACE, finished=1)
    for module in ("main_panel", "menus"):
        monkeypatch.setattr(f"radtex_addon.ui.panel.{module}.cached_forecast", lambda *_: found)
    panel = drawn(RADTEX_PT_bake, RADTEX_PT_afterwards)
    menu, pie = map(drawn, (menus.RADTEX_MT_object, menus.RADTEX_MT_pie))
    for layout in (panel, menu, pie):
        texts = dict(zip([name for name, _ in layout.buttons], layout.texts, strict=False))
        assert len([name for name, _ in layout.buttons if name == "radtex.preview_toggle"]) == 1
        for name in texts.keys() & ACTIONS.keys():
            assert ACTIONS[name][0][0] in layout.texts, name
    assert "Export…" in words(panel) & words(menu) & words(pie)


@pytest.mark.parametrize("state", STATES)
def test_a_bake_that_may_be_there_is_previewed_by_a_button_above_the_jobs(
    state: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """So it is seen however many jobs there are, and however much they warn of."""
    found = STATES[state][0]
    monkeypatch.setattr("radtex_addon.ui.panel.main_panel.cached_forecast", lambda *_: found)
    none = ("nothing is there", "a bake was begun", "it is baked now", "a copy", "copies")
    assert drawn(RADTEX_PT_bake).texts.count("Preview Bake") == (state not in none)
    finished = drawn(RADTEX_PT_afterwards).texts
    assert "Preview Bake" not in finished
    assert ("Nothing of it is baked yet" in finished) == (state in none[:3])


def test_menus_before_the_panel_has_looked_say_the_plain_word() -> None:
    panel_state._cache.found.clear()
    assert "Bake Radiance Texture" in drawn(menus.RADTEX_MT_pie).texts
