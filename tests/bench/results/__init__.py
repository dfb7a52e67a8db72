# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The project's Results: every method on the same scenes, by the same paths, with error bars."""
