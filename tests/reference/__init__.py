# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""References in plain NumPy that only tests need: what shaders, exports and captures are compared with.

What RadTex itself computes is in `radtex_addon.core`; these are lookups that engines do on a GPU, and whole
images of what exports make in bands of rows.
"""
