# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Prepare objects for a bake: unwrapped copies, twins of faces, texels and their surface points."""
