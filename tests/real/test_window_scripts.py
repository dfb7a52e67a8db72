# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators called by scripts in Blender's window, without asking for a step to undo; then Ctrl-Z."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from tests.real.panel import SHORT, bake
from tests.real.test_window_undo import by_keys, by_script, wait_until_as
from tests.real.window import Window

COMPARE = "bpy.ops.radtex.compare(wait=True, pixels=32, samples=1)"
TOGGLE = "bpy.ops.radtex.preview_toggle()"
STEPS = "before", "compared", "shown", "hidden"


@pytest.fixture(scope="module")
def baked(window: Window) -> Window:
    """A window in which an object was baked."""
    bake(window, **SHORT)
    window.ask("room.step('Baked')")
    return window


@pytest.mark.parametrize("take", [by_keys, by_script])
def test_blender_survives_an_undo_after_a_comparison_and_a_preview(
    baked: Window, take: Callable[..., None]
) -> None:
    baked.ask(COMPARE)
    baked.ask("room.remember('compared')")
    baked.ask(TOGGLE)
    take(baked, again=False)
    wait_until_as(baked, "compared")


@pytest.fixture(scope="module")
def steps(baked: Window) -> Window:
    """A window in which a script compared a bake, showed it and hid it again."""
    baked.ask("room.step('Start'); room.remember('before')")
    for step, code in (("compared", COMPARE), ("shown", TOGGLE), ("hidden", TOGGLE)):
        baked.ask(code)
        baked.ask(f"room.remember({step!r})")
    return baked


@pytest.mark.parametrize("take", [by_keys, by_script])
def test_what_a_script_did_is_undone_and_redone_step_by_step(
    steps: Window, take: Callable[..., None]
) -> None:
    for step in reversed(STEPS[:-1]):
        take(steps, again=False)
        wait_until_as(steps, step)
    for step in STEPS[1:]:
        take(steps, again=True)
        wait_until_as(steps, step)
