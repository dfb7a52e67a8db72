# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Update callback that settings share: a change makes the panel's cached forecast stale."""

from __future__ import annotations

from typing import Any

import bpy

from ..panel.panel_state import mark_stale


def notice(settings: Any, _: bpy.types.Context) -> None:
    """Mark the panel's state stale: Blender calls no handler when a script changes a property.

    Not for an operator's arguments, which drawing a button sets.
    """
    if isinstance(settings, bpy.types.PropertyGroup):
        mark_stale()


NOTICED: dict[str, Any] = {"update": notice, "options": {"SKIP_SAVE"}}  # arguments of a property
