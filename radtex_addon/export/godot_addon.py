# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The addon for Godot, which imports our .glb files: its sources with the shader includes that it needs."""

from __future__ import annotations

import shutil
from pathlib import Path

from .pack import SHADERS

ADDON = Path("addons", "radtex")  # where Godot's asset library and every project have it
LOOKUPS = (
    "radtex",
    "radtex_layered",
    "radtex_layered_through",
    "radtex_shadow",
    "radtex_trace",
    "radtex_transfer",
)


def copy_addon(project: Path) -> Path:
    """Copy the addon into a project's folder, where it must not be yet; returns its folder there."""
    addon = project / ADDON
    shutil.copytree(SHADERS / "godot" / ADDON, addon)
    (addon / "lookups").mkdir()
    for name in LOOKUPS:
        shutil.copyfile(SHADERS / f"{name}.gdshaderinc", addon / "lookups" / f"{name}.gdshaderinc")
    return addon
