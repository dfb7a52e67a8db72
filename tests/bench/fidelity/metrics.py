# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What `bake.py report` measures, and HDR FLIP, which judges all exposures."""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np

from radtex_addon.report import metrics
from radtex_addon.report.metrics import Mask, Picture, flip_map


@dataclass(frozen=True)
class Figures(metrics.Figures):
    """One picture's; `hdr_flip` too is inside the eroded mask."""

    hdr_flip: float


def compare(picture: Picture, reference: Picture, inside: Mask, eroded: Mask) -> Figures:
    """Measure a picture; outside `inside` it may hold anything."""
    shown = np.where(inside[..., None], picture, reference)
    hdr_flip = float(flip_map(shown, reference, hdr=True)[eroded].mean())
    return Figures(**asdict(metrics.compare(picture, reference, inside, eroded)), hdr_flip=hdr_flip)
