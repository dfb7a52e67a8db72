# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What settings have in common: the panel shows what is no longer so, once one of them has changed."""

from __future__ import annotations

from typing import Any

import bpy

from .panel_state import mark_stale


def notice(_: Any, __: bpy.types.Context) -> None:
    """Of what scripts change, Blender tells no handler."""
    mark_stale()


NOTICED: dict[str, Any] = {"update": notice, "options": {"SKIP_SAVE"}}  # of a property
