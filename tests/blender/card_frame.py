# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The attributes of a baked copy's mesh, for cards that are made by hand."""

from __future__ import annotations

from typing import Any

import bpy


def give_frame(card: bpy.types.Mesh) -> None:
    """Give a card in the plane z = 0 the frame of its UVs: normals along z, tangents along x."""
    fields: Any = (
        ("radtex_normal", "FLOAT_VECTOR", (0.0, 0.0, 1.0)),
        ("radtex_tangent", "FLOAT_VECTOR", (1.0, 0.0, 0.0)),
        ("radtex_sign", "FLOAT", 1.0),
    )
    for name, kind, value in fields:
        made: Any = card.attributes.new(name, kind, "CORNER")
        for item in made.data:
            setattr(item, "value" if kind == "FLOAT" else "vector", value)
