# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A folder for engines of the user's own: the shader includes of all languages."""

from __future__ import annotations

from ..engines import engine_writer

WRITER = engine_writer("The includes say at their top how they are called.")
