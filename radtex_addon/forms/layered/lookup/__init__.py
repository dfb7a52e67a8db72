# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a layered bake keeps, and how it is looked up: the reference of all shaders."""
