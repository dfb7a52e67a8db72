# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What users do with the .blend in Blender's window while it is baked: save it, load another, start anew."""

from __future__ import annotations

from tests.real.panel import CROSS, LONG, choose, latest, press, preview, wait_for, wait_for_end
from tests.real.window import Window, wait_until


def test_files_are_saved_and_loaded_while_a_bake_goes_on(window: Window) -> None:
    choose(window, **LONG | {"samples": 24})
    press(window)
    wait_for(window, 0.1)
    window.ask("room.step('a change')")
    assert window.value("bpy.data.is_dirty")
    window.key("ctrl+s", over_view=True)
    wait_until(lambda: not window.value("bpy.data.is_dirty"), 10, "not saved")
    assert latest(window).state == "running"
    window.ask("bpy.ops.wm.open_mainfile(filepath=bpy.data.filepath)")
    window.find("radtex.cancel(", right=CROSS)  # the panel goes on showing it
    assert latest(window).state == "running"
    window.ask("bpy.ops.wm.read_homefile(app_template='')")
    assert window.value("bpy.data.filepath") == ""
    told = wait_for_end(window, 280)
    assert told.state == "done", told.message
    assert (window.folder / "radtex/room/Suzanne.preview.blend").is_file()
    window.ask(f"bpy.ops.wm.open_mainfile(filepath={window.inside + '/room.blend'!r})")
    preview(window, "Suzanne (baked)")
