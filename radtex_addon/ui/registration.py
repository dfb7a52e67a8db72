# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What Blender learns when the extension is enabled, in order; disabling forgets it in reverse."""

from __future__ import annotations

import bpy

from .operator import RADTEX_OT_bake

CLASSES = (RADTEX_OT_bake,)


def register() -> None:
    """Register every class, in order."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    """Unregister every class, last one first."""
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
