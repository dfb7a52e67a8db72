# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The result of a form's bake, the same for all forms."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from ..core.atlas import AtlasLayout


@dataclass(frozen=True)
class Condensed:
    """How a bake was condensed: `clusters` of each lobe, sides of `colour` and `surroundings` in pixels.

    `bytes` is the textures' size on a GPU; `agreement` is that of the files, read back, with the fit, in dB.
    """

    clusters: tuple[int, ...]
    colour: tuple[int, int]
    surroundings: int
    bytes: int
    agreement: float


@dataclass(frozen=True)
class Outcome:
    """The `images` that were written, and what they cost: see `job.baking.BakeResult`."""

    images: tuple[Path, ...]
    layout: AtlasLayout
    covered_texels: int
    paths: int
    clamped: int
    fireflies: float = 0.0
    condensed: Condensed | None = None
