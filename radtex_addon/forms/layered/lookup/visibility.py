# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How much of what surrounds the object it leaves free, as a lobe sees it.

Kept is a picture of that, blurred as wide as its cells. A sharp lobe needs a sharper edge: where the edge is
straight, blurring a half-space by a lobe of another width (see lobes.py) changes F(d / s) into F(d / t),
where F(x) = 1/2 + x / (2 sqrt(2 + x²)).
"""

from __future__ import annotations

from typing import cast

import numpy as np

from ....core.arrays import Floats

_KEPT = 2.56  # the kept mask's own blur, times the number of its cells along a side, radians
_EDGE = 0.04  # the sharpest edge that is shown, radians: cells do not tell where it is any better


def seen_free(kept: Floats, variance: Floats, cells: int) -> Floats:
    """The kept mask (N,) as a lobe of widths² (N,) sees it: (N,)."""
    sharper = np.maximum(_KEPT / cells / np.sqrt(variance + _EDGE**2), 1)
    place = np.clip(2 * kept - 1, -1, 1) * sharper
    return cast(
        Floats, (0.5 + 0.5 * place / np.sqrt(1 - (place / sharper) ** 2 + place**2)).astype(np.float32)
    )
