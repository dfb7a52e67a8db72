# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""UV layers: the user's, and those made by xatlas or Blender."""
