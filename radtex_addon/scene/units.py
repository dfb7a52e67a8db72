# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene's unit of length."""

from __future__ import annotations

import bpy


def metres_per_unit(scene: bpy.types.Scene) -> float:
    """How many metres a scene unit is: the unit scale, which Blender ignores without a unit system."""
    units = scene.unit_settings
    return 1.0 if units.system == "NONE" else units.scale_length
