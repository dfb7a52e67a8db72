# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Fill pages with what the program says of itself, so that the reference cannot go stale.

A page has a fence where a part is to be, which names what: {generated} command export.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import bpy
from sphinx.application import Sphinx
from sphinx.errors import ExtensionError

from radtex_addon.ui import registration
from radtex_addon.ui.settings.preferences import ADDON

from .command_options import command, commands
from .messages import exit_codes, setting_names
from .operators import operators
from .panel_settings import preferences, presets, settings, shared_settings
from .shader_functions import shader

_FENCE = re.compile(r"^```\{generated\} (?P<name>\S+) *(?P<argument>\S*)\n```$", re.MULTILINE)
_PARTS: dict[str, Callable[[str], str]] = {
    "command": command,
    "commands": commands,
    "exit-codes": exit_codes,
    "operators": operators,
    "preferences": preferences,
    "presets": presets,
    "setting-names": setting_names,
    "settings": settings,
    "shader": shader,
    "shared-settings": shared_settings,
}


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the extension; called by Sphinx. RadTex is registered with Blender until Sphinx ends."""
    registration.register()
    context: Any = bpy.context  # to the stubs, every pointer may be None
    context.preferences.addons.new().module = ADDON
    app.connect("source-read", _fill)
    return {"parallel_read_safe": False}


def _fill(_app: Sphinx, _page: str, source: list[str]) -> None:
    source[0] = _FENCE.sub(_part, source[0])


def _part(found: re.Match[str]) -> str:
    name = found["name"]
    if name not in _PARTS:
        raise ExtensionError(f"{{generated}} {name}: choose from {', '.join(_PARTS)}")
    return _PARTS[name](found["argument"])
