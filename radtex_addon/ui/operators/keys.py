# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bind Esc over the sidebar to cancel jobs; not a modal operator, which would block Blender's auto-save."""

from __future__ import annotations

import bpy

from .job_operators import RADTEX_OT_cancel_here

_bound: list[tuple[bpy.types.KeyMap, bpy.types.KeyMapItem]] = []


def register() -> None:
    """Add the key binding, unless Blender runs without a window."""
    manager = bpy.context.window_manager
    configuration = manager.keyconfigs.addon if manager is not None else None
    if configuration is None:  # in background mode
        return
    keymap = configuration.keymaps.new("3D View Generic", space_type="VIEW_3D")
    _bound.append((keymap, keymap.keymap_items.new(RADTEX_OT_cancel_here.bl_idname, "ESC", "PRESS")))


def unregister() -> None:
    """Remove the key binding."""
    for keymap, item in _bound:
        keymap.keymap_items.remove(item)
    _bound.clear()
