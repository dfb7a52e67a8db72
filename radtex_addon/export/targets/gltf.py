# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A folder for programs that read glTF: the .glb, and the shader includes in GLSL."""

from __future__ import annotations

from ..engines import engine_writer

WRITER = engine_writer(
    "Any program opens the .glb; one that knows no radiance textures shows the flat lightmap."
)
