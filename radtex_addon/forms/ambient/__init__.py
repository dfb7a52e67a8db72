# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The form of kind `ao`: one value per texel, with the mean open direction."""
