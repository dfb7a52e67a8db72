# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A first look in seconds."""

import bpy

radtex = bpy.context.scene.radtex  # type: ignore[union-attr]  # ours, not Blender's

radtex.kind = "radiance"
radtex.atlas_layout = "buckets"
radtex.atlas_size = "texels"
radtex.texels = 64
radtex.bucket = 8
radtex.samples = 2
