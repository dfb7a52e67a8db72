# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Redraw the panel when its contents have changed, or views when something is drawn in them."""

from __future__ import annotations

from collections.abc import Iterator

import bpy


def redraw() -> None:
    """Redraw the sidebar of every 3D view, but not the view itself."""
    for area in views():
        for region in area.regions:
            if region.type == "UI":
                region.tag_redraw()


def redraw_views() -> None:
    """Redraw every 3D view, with its sidebar."""
    for area in views():
        area.tag_redraw()


def views() -> Iterator[bpy.types.Area]:
    """The 3D views of all windows."""
    manager = bpy.context.window_manager
    for window in manager.windows if manager is not None else ():
        yield from (area for area in window.screen.areas if area.type == "VIEW_3D")
