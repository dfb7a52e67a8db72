# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What two eyes see in a shiny ball, over bake seeds: `tests.bench.stereo`, several times."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from ..stereo import both_eyes
from .summary import Spread

_TEXELS, _SAMPLES = 128, 8


def stereo_figures(seeds: Sequence[int]) -> dict[str, Any]:
    """Decibels of the worse eye and of the eyes' difference, with their spread over seeds."""
    found = [both_eyes(_TEXELS, _SAMPLES, seed) for seed in seeds]
    looked_up = {
        name: {
            "worse_eye": asdict(Spread.of(each[name][0] for each in found)),
            "difference": asdict(Spread.of(each[name][1] for each in found)),
        }
        for name in found[0]
    }
    return {"texels": _TEXELS, "samples": _SAMPLES, "seeds": list(seeds), "looked_up": looked_up}
