# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""RadTex registered as Blender does it, for tests of what it registers."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import bpy

from radtex_addon.ui import registration
from radtex_addon.ui.preferences import ADDON

context: Any = bpy.context  # to the stubs, every pointer may be None
ops: Any = bpy.ops  # and they know Blender's own operators only


@contextmanager
def registered() -> Iterator[None]:
    """RadTex, with preferences of its own."""
    registration.register()
    addon = context.preferences.addons.new()
    addon.module = ADDON
    try:
        yield
    finally:
        if ADDON in context.preferences.addons:  # unless the test went back to factory settings
            context.preferences.addons.remove(context.preferences.addons[ADDON])
        registration.unregister()


def settings() -> Any:
    """The open scene's."""
    return context.scene.radtex


def preferences() -> Any:
    """RadTex's."""
    return context.preferences.addons[ADDON].preferences
