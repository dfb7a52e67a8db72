# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake without Blender: its plan, its light by cells and samples, and the session that fills the atlas."""
