# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The Godot shader of a bake in the layered layout."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...core.arrays import Floats
from ...core.errors import InputError
from ...core.messages import Setting, do
from ...textures.entry import TextureEntry
from ...textures.godot_shader import GodotShader


def layered_shader(
    bake: Mapping[str, Any], textures: Mapping[str, TextureEntry], baked: Floats
) -> GodotShader:
    """As `Form.godot_shader`. Raises InputError: there is no such shader yet."""
    raise InputError(
        "the layered layout is not exported to Godot yet",
        do("choose layout buckets", Setting.LAYOUT, value="buckets"),
    )
