# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""From objects to what a bake captures: unwrapped copies, twins of faces, texels and points on them."""
