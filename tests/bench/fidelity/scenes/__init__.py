# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes to measure bakes by, each with cameras to tune on and cameras that no choice is tuned on.

Everywhere coloured things stand beside the object, seen reflected with parallax, under an HDRI that Blender
ships; a patterned floor lies close below it.
"""

from __future__ import annotations

from collections.abc import Callable

from .asset import asset
from .bands import bands
from .brushed import brushed, lamps
from .coat import coat
from .curtain import curtain
from .flats import flats
from .meshes import SUBJECT
from .plant import plant
from .seven import SEVEN
from .stage import PIXELS, Stage
from .thick_glass import thick_glass

__all__ = ["PIXELS", "SCENES", "SEVEN", "SUBJECT", "Stage"]

SCENES: dict[str, Callable[[], Stage]] = {
    **SEVEN,
    "coat": coat,
    "flats": flats,
    "bands": bands,
    "brushed": brushed,
    "asset": asset,
    "thick_glass": thick_glass,
    "plant": plant,
    "curtain": curtain,
    "lamps": lamps,
}
