# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Examples of what RadTex can be extended by: docs/extending.md."""
