# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What is new, in Blender's window: after an update a line in the panel, a dialog, and no line any more."""

from __future__ import annotations

from tests.real.panel import SHORT, choose
from tests.real.window import Window, changed, wait_until

SEEN = "bpy.context.preferences.addons['bl_ext.user_default.radtex'].preferences.seen_version"


def test_the_changes_are_offered_after_an_update_alone_and_shown_by_a_click(window: Window) -> None:
    choose(window, **SHORT)
    version = window.value(SEEN)
    assert version, "enabling has noted the first install"
    window.ask(f"{SEEN} = '0.0.1'")
    window.ask("for area in bpy.context.window_manager.windows[0].screen.areas:\n    area.tag_redraw()")
    before = window.shot("news")
    window.click(*window.find("radtex.show_changes(", right=120))
    wait_until(lambda: window.value(SEEN) == version, 10, "the dialog is not opened")
    during = window.shot("changes")
    assert changed(before, during) > 0.05
    window.key("Escape")
    window.key("Escape")  # the first may have gone to a button under the mouse
    after = window.picture("closed")
    assert changed(during, after) > 0.05
    assert window.value(SEEN) == version
