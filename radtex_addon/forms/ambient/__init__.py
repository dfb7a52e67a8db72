# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""One value a texel with the mean open direction: the form of kind `ao`."""
