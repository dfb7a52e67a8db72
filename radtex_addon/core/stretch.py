# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How much a UV layer stretches triangles."""

from __future__ import annotations

import numpy as np

from .arrays import Floats, blocks

_NOTHING = 1e-30  # lengths below count as 0


def stretches(corners: Floats, uv: Floats) -> Floats:
    """The largest and the least stretch of each triangle as it is flattened: (F, 2).

    `corners` (F, 3, 3) in space, `uv` (F, 3, 2) in the same unit: both are 1 where a triangle keeps its shape
    and size. They are the singular values of the linear map from the triangle's plane; Sander, Snyder,
    Gortler and Hoppe, "Texture Mapping Progressive Meshes" (2001), section 3. Of a triangle without area in
    space they are not meaningful, but finite.
    """
    found = np.empty((len(corners), 2))
    for some in blocks(len(corners)):
        found[some] = _stretches(corners[some], uv[some])
    return found


def _stretches(corners: Floats, uv: Floats) -> Floats:
    one, two = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    length = np.maximum(np.linalg.norm(one, axis=1), _NOTHING)
    along = one / length[:, None]
    across_x = np.sum(two * along, axis=1)
    across_y = np.maximum(np.linalg.norm(two - across_x[:, None] * along, axis=1), _NOTHING)
    u = (uv[:, 1] - uv[:, 0]) / length[:, None]
    v = (uv[:, 2] - uv[:, 0] - u * across_x[:, None]) / across_y[:, None]
    uu, vv, uv_ = np.sum(u * u, axis=1), np.sum(v * v, axis=1), np.sum(u * v, axis=1)
    apart = np.sqrt((uu - vv) ** 2 + 4 * uv_ * uv_)
    found: Floats = np.sqrt(np.maximum(np.stack([uu + vv + apart, uu + vv - apart], axis=1) / 2, 0))
    return found
