# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""New files start from the preset that the preferences name; files that were saved keep what they have."""

from __future__ import annotations

import logging

import bpy
from bpy.app.handlers import persistent

from ..core.errors import InputError
from .preferences import preferred
from .presets import apply_preset
from .settings import NAMES

_log = logging.getLogger(__name__)


@persistent  # type: ignore[untyped-decorator]  # the stubs say nothing of it
def apply_default(*_: object) -> None:
    """Give a new file's scene the default preset, unless somebody has set anything."""
    name = preferred().preset
    settings = bpy.context.scene.radtex  # type: ignore[union-attr]  # ours, not Blender's
    if bpy.data.filepath or not name or any(settings.is_property_set(one) for one in NAMES):
        return
    try:
        apply_preset(name)
    except InputError as error:  # the user's file is open all the same
        _log.warning("%s", error)


def register() -> None:
    """Wait for new files."""
    bpy.app.handlers.load_post.append(apply_default)


def unregister() -> None:
    """Wait no more."""
    if apply_default in bpy.app.handlers.load_post:  # others may have emptied the list
        bpy.app.handlers.load_post.remove(apply_default)
