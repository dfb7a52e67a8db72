# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What every layout's bake hands back."""

from __future__ import annotations

from dataclasses import dataclass

from ..core.atlas import AtlasLayout
from .condensed import Condensed
from .files import OutputFiles


@dataclass(frozen=True)
class Made:
    """An atlas on disk: the `files` that there are, what it took, and how it was `condensed`, if it was."""

    files: OutputFiles
    layout: AtlasLayout
    covered_texels: int
    paths: int
    clamped: int
    fireflies: float = 0.0
    condensed: Condensed | None = None
