# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a bake comes to, whatever its form."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from ..core.atlas import AtlasLayout


@dataclass(frozen=True)
class Condensed:
    """How a bake was condensed: `clusters` of each lobe, sides of `colour` and `surroundings` in pixels.

    `bytes` are the textures' on a GPU, `agreement` is in dB: the files, read back, against what was fitted.
    """

    clusters: tuple[int, ...]
    colour: tuple[int, int]
    surroundings: int
    bytes: int
    agreement: float


@dataclass(frozen=True)
class Outcome:
    """The `images` that were written, and what they took: see `job.run.BakeResult`."""

    images: tuple[Path, ...]
    layout: AtlasLayout
    covered_texels: int
    paths: int
    clamped: int
    fireflies: float = 0.0
    condensed: Condensed | None = None
