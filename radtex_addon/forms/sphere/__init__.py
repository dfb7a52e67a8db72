# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Buckets of all directions to the light: the form of kind `transfer`."""
