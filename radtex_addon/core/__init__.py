# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The paper's maths and everything else that needs numpy only: no file, no Blender."""
