# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake as an animation: a .blend whose frames any render farm renders, and their assembly to an atlas."""
