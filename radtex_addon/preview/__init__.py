# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The baked atlas seen in Blender: the sampling node group, the material, the OSL node, the preview file."""
