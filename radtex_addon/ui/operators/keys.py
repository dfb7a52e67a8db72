# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Key bindings: Esc over the sidebar cancels jobs; Ctrl Shift B opens the pie menu in Object Mode.

Esc is no modal operator, which would block Blender's auto-save.
"""

from __future__ import annotations

import bpy

from .job_operators import RADTEX_OT_cancel_here

_bound: list[tuple[bpy.types.KeyMap, bpy.types.KeyMapItem]] = []


def register() -> None:
    """Add the key bindings, unless Blender runs without a window."""
    manager = bpy.context.window_manager
    configuration = manager.keyconfigs.addon if manager is not None else None
    if configuration is None:  # in background mode
        return
    keymap = configuration.keymaps.new("3D View Generic", space_type="VIEW_3D")
    _bound.append((keymap, keymap.keymap_items.new(RADTEX_OT_cancel_here.bl_idname, "ESC", "PRESS")))
    keymap = configuration.keymaps.new("Object Mode")
    pie = keymap.keymap_items.new("wm.call_menu_pie", "B", "PRESS", ctrl=True, shift=True)
    pie.properties.name = "RADTEX_MT_pie"  # type: ignore[union-attr]  # of the operator, which the stubs do not know
    _bound.append((keymap, pie))


def unregister() -> None:
    """Remove the key bindings."""
    for keymap, item in _bound:
        keymap.keymap_items.remove(item)
    _bound.clear()
