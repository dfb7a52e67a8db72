# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Several bakes in Blender's window: one runs, the others wait, and each is cancelled alone."""

from __future__ import annotations

from tests.real.panel import CROSS, LONG, SHORT, Told, choose, jobs, press, wait_for_end
from tests.real.window import Window, wait_until

STATES = "running", "waiting"


def test_two_objects_bake_one_after_another(window: Window) -> None:
    choose(window, "Plane", "Suzanne", **SHORT)
    press(window)
    wait_for_end(window)
    assert summary(window) == [("Plane", "done"), ("Suzanne", "done")]
    running = [{what for _, what, state, *_ in window.value("states") if state == word} for word in STATES]
    assert running == [{"Plane", "Suzanne"}, {"Suzanne"}]


def test_one_that_waits_is_cancelled_alone(window: Window) -> None:
    choose(window, "Plane", "Suzanne", **LONG | {"samples": 256}, overwrite=True)
    window.ask("room.remember('before')")
    press(window)
    wait_until(lambda: first(window).fraction > 0.15, 120, "the first does not begin")
    assert summary(window) == [("Plane", "running"), ("Suzanne", "waiting")]
    window.shot("queue")
    _, second = jobs(window)
    window.click(*window.find(f"radtex.cancel(number={second.number})", right=CROSS))
    assert summary(window) == [("Plane", "running"), ("Suzanne", "cancelled")]
    reached = first(window).fraction
    wait_until(lambda: first(window).fraction > reached + 0.02, 120, "the first goes on no more")
    window.click(*window.find(f"radtex.cancel(number={first(window).number})", right=CROSS))
    wait_until(lambda: first(window).state == "cancelled", 2, "the first cannot be cancelled")
    assert window.value("room.changes('before')") == []


def first(window: Window) -> Told:
    return jobs(window)[0]


def summary(window: Window) -> list[tuple[str, str]]:
    """Object and state of each job."""
    return [(told.what, told.state) for told in jobs(window)]
