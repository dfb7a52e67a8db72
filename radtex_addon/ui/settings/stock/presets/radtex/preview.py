# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Good enough to judge the light."""

import bpy

radtex = bpy.context.scene.radtex  # type: ignore[union-attr]  # ours, not Blender's

radtex.kind = "radiance"
radtex.atlas_layout = "auto"
radtex.atlas_size = "texels"
radtex.texels = 128
radtex.bucket = 14
radtex.samples = 16
