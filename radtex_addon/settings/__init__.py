# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What can be asked of a bake: options, kinds, layouts, targets; its specification, and its cost."""
