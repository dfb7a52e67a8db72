# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Apply the preferences' default preset to new files; saved files keep their settings."""

from __future__ import annotations

import logging

import bpy
from bpy.app.handlers import persistent

from ...core.errors import InputError
from .bake_settings import NAMES
from .preferences import preferred
from .presets import apply_preset

_log = logging.getLogger(__name__)


@persistent  # type: ignore[untyped-decorator]  # untyped in the stubs
def apply_default(*_: object) -> None:
    """Handler: apply the default preset to a new file's scene, unless any setting was already changed."""
    name = preferred().preset
    settings = bpy.context.scene.radtex  # type: ignore[union-attr]  # ours, not Blender's
    if bpy.data.filepath or not name or any(settings.is_property_set(one) for one in NAMES):
        return
    try:
        apply_preset(name)
    except InputError as error:  # the file is loaded anyway, so only warn
        _log.warning("%s", error)


def register() -> None:
    """Add the load handler."""
    bpy.app.handlers.load_post.append(apply_default)


def unregister() -> None:
    """Remove the load handler."""
    if apply_default in bpy.app.handlers.load_post:  # other add-ons may have cleared the list
        bpy.app.handlers.load_post.remove(apply_default)
