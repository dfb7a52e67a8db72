# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The condensed form of the shared layout: for a size or quality, texels share buckets."""
