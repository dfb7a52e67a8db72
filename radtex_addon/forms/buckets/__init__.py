# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The plain form: a bucket of cells for every texel, in one image; layers are images beside it."""
