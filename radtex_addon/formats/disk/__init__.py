# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Files on disk: atomic writing, locks, temporary folders, and checks before reading."""
