# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line `bake.py`: arguments in, files and an exit code out."""
