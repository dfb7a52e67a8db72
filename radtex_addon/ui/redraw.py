# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Telling Blender that the panel has something new to show."""

from __future__ import annotations

import bpy


def redraw() -> None:
    """Let every 3D view's sidebar be drawn again; the scene in it is not."""
    manager = bpy.context.window_manager
    for window in manager.windows if manager is not None else ():
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                for region in area.regions:
                    if region.type == "UI":
                        region.tag_redraw()
