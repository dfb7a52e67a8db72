# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Matt things, whose light hardly changes with the view."""

import bpy

radtex = bpy.context.scene.radtex  # type: ignore[union-attr]  # ours, not Blender's

radtex.kind = "radiance"
radtex.atlas_layout = "buckets"
radtex.atlas_size = "texels"
radtex.texels = 128
radtex.bucket = 4
radtex.samples = 64
