# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake without Blender: its specification, its plan, and the session that fills the atlas."""
