# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The result of a form's bake, the same for all forms."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from ..core.atlas import AtlasLayout


@dataclass(frozen=True)
class Outcome:
    """The `images` that were written, and what they cost: see `job.baking.BakeResult`."""

    images: tuple[Path, ...]
    layout: AtlasLayout
    covered_texels: int
    paths: int
    clamped: int
