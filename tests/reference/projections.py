# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A projection of the hemisphere that the paper discusses and no bake uses."""

from __future__ import annotations

import numpy as np

from radtex_addon.core.arrays import Floats, as_floats
from radtex_addon.core.hemisphere import _TINY, _dot, _length


def equisolid_half(incidence: Floats, tangent: Floats, bitangent: Floats, normal: Floats) -> Floats:
    """`equisolid` for vectors in any space, by the half vector: four times (..., 3) -> A (..., 2).

    H = normalize(I + N), A = sqrt(2) (H.T, H.Bt); H.N = cos(theta/2). Horizon and I = -N as in `equisolid`.
    """
    half = as_floats("incidence", incidence, 3) + as_floats("normal", normal, 3)
    half = half / np.sqrt(np.maximum(_dot(half, half), _TINY))
    a = np.sqrt(half.dtype.type(2)) * np.concatenate([_dot(half, tangent), _dot(half, bitangent)], axis=-1)
    clamped: Floats = a / np.maximum(_length(a), 1)
    return clamped


def equisolid_half_inverse(a: Floats, tangent: Floats, bitangent: Floats, normal: Floats) -> Floats:
    """Inverse of `equisolid_half`, in the space of the frame: A (..., 2), frame (..., 3) each -> I (..., 3).

    H = (A.x T + A.y Bt) / sqrt(2) + sqrt(1 - |A|^2 / 2) N, I = 2 (H.N) H - N.
    """
    a = as_floats("A", a, 2)
    normal = as_floats("normal", normal, 3)
    h_dot_n = np.sqrt(np.maximum(1 - _dot(a, a) / 2, 0))
    across = (a[..., :1] * tangent + a[..., 1:] * bitangent) / np.sqrt(a.dtype.type(2))
    incidence: Floats = 2 * h_dot_n * (across + h_dot_n * normal) - normal
    return incidence
