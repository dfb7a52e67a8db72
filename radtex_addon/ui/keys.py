# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Esc over the sidebar cancels bakes: a key, for a modal operator would hold up Blender's auto-save."""

from __future__ import annotations

import bpy

from .job_operators import RADTEX_OT_cancel_here

_bound: list[tuple[bpy.types.KeyMap, bpy.types.KeyMapItem]] = []


def register() -> None:
    """Bind the key, where there is a keyboard."""
    manager = bpy.context.window_manager
    configuration = manager.keyconfigs.addon if manager is not None else None
    if configuration is None:  # without a window there is none
        return
    keymap = configuration.keymaps.new("3D View Generic", space_type="VIEW_3D")
    _bound.append((keymap, keymap.keymap_items.new(RADTEX_OT_cancel_here.bl_idname, "ESC", "PRESS")))


def unregister() -> None:
    """Free the key."""
    for keymap, item in _bound:
        keymap.keymap_items.remove(item)
    _bound.clear()
