# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's data: read and check the user's scene, and build scenes, meshes and node trees from it."""
