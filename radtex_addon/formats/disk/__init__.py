# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Files as such: written atomically, locked, temporary, checked before they are read."""
