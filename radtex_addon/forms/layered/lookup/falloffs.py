# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Falloffs, as they are looked up: how diffuse light changes with N.V in each material."""

from __future__ import annotations

from typing import cast

import numpy as np

from ....core.arrays import Floats, Ints


def falloff_at(falloff: Floats, material: Ints, cosine: Floats) -> Floats:
    """The falloffs (M, B, 3) of materials (N,) at N.V (N,), linear between their points: (N, 3)."""
    count = falloff.shape[1]
    own = np.minimum(material, len(falloff) - 1)
    place = np.clip(cosine * count - 0.5, 0, count - 1)
    low = np.minimum(place.astype(np.intp), count - 2)
    part = (place - low)[:, None].astype(falloff.dtype)
    return cast(Floats, falloff[own, low] * (1 - part) + falloff[own, low + 1] * part)
