# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Undo and redo in Blender's window, by keys and by scripts, through a bake and its preview."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from tests.real.panel import CROSS, LONG, SHORT, choose, jobs, latest, press, preview, wait_for, wait_for_end
from tests.real.window import Window, wait_until

MOVE = "bpy.data.objects['Plane'].location.x += 0.25; room.step('Move')"
STEPS = "still", "moved", "shown", "hidden"  # what the user sees after each step


def by_keys(window: Window, *, again: bool) -> None:
    window.key("ctrl+shift+z" if again else "ctrl+z", over_view=True)


def by_script(window: Window, *, again: bool) -> None:
    window.ask(f"room.undo(again={again})")


@pytest.fixture(scope="module")
def steps(window: Window) -> Window:
    """A window in which an object was moved, another baked, and the preview switched on and off again."""
    choose(window, **SHORT)
    window.ask("room.remember('still')")
    window.ask(MOVE)
    window.ask("room.remember('moved')")
    press(window)
    assert wait_for_end(window).state == "done"
    assert window.value("room.changes('moved')") == []
    for step, seen in (("shown", "Suzanne (baked)"), ("hidden", "Suzanne")):
        preview(window, seen)
        window.ask(f"room.remember({step!r})")
    assert window.value("room.changes('moved')") == []
    return window


@pytest.mark.parametrize("take", [by_keys, by_script])
def test_every_step_is_undone_and_redone_as_it_was(steps: Window, take: Callable[..., None]) -> None:
    for step in reversed(STEPS[:-1]):
        take(steps, again=False)
        wait_until_as(steps, step)
    for step in STEPS[1:]:
        take(steps, again=True)
        wait_until_as(steps, step)


def test_undo_does_not_touch_a_bake_that_runs(window: Window) -> None:
    choose(window, **LONG | {"samples": 256}, overwrite=True)
    window.ask("room.remember('before')")
    window.ask(MOVE)
    press(window)
    wait_for(window, 0.1)
    by_keys(window, again=False)
    wait_until_as(window, "before")
    reached = latest(window).fraction
    wait_until(lambda: latest(window).fraction > reached + 0.02, 120, "the bake goes on no more")
    by_keys(window, again=True)
    wait_until(lambda: window.value("room.changes('before')"), 10, "not redone")
    (told,) = jobs(window)
    assert told.state == "running"
    window.click(*window.find(f"radtex.cancel(number={told.number})", right=CROSS))
    wait_until(lambda: latest(window).state == "cancelled", 2, "the bake cannot be cancelled any more")


def wait_until_as(window: Window, step: str) -> None:
    """Wait until all is as it was when that was remembered."""
    wait_until(lambda: not window.value(f"room.changes({step!r})"), 10, f"not as it was when {step}")
