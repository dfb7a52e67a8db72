# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What is asked of the user's scene, and made of it: Blender's data, without rendering."""
