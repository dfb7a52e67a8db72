# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Which directions are blocked, in one bit a cell: the form of kind `shadow`."""
