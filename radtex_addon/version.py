# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The tool's version; a test keeps it equal to the manifest's."""

VERSION = "0.1.0"
