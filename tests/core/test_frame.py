# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The surface frame: orthonormal for every input, with one agreed fallback."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from radtex_addon.core.errors import ShapeError
from radtex_addon.core.frame import fallback_tangent, orthonormal_frame, to_frame

RNG = np.random.default_rng(5)


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_frames_are_orthonormal_and_keep_their_hand(dtype: type[np.floating[Any]]) -> None:
    normal, tangent = RNG.normal(size=(2, 500, 3)).astype(dtype)
    sign = np.where(RNG.uniform(size=500) < 0.5, -1, 1).astype(dtype)
    tangent[::7] = normal[::7] * 3  # degenerate: along the normal
    tangent[::11] = 0
    t, b, n = orthonormal_frame(normal, tangent, sign)
    assert t.dtype == b.dtype == n.dtype == dtype
    basis = np.stack([t, b, n], axis=1)
    np.testing.assert_allclose(
        basis @ basis.transpose(0, 2, 1), np.broadcast_to(np.eye(3), (500, 3, 3)), atol=1e-5
    )
    np.testing.assert_allclose(np.linalg.det(basis), sign, atol=1e-5)


def test_the_fallback_is_the_agreed_one() -> None:
    np.testing.assert_allclose(fallback_tangent(np.array([1.0, 0, 0])), [0, 1, 0])
    np.testing.assert_allclose(fallback_tangent(np.array([0, 0, 1.0])), [0, -1, 0])
    t, b, n = orthonormal_frame(np.array([1.0, 0, 0]), np.array([2.0, 0, 0]), np.array(1.0))
    np.testing.assert_allclose(t, [0, 1, 0])
    np.testing.assert_allclose(to_frame(np.array([[1.0, 2, 3]]), t, b, n), [[2, 3, 1]])
    with pytest.raises(ShapeError, match="sign"):
        orthonormal_frame(np.zeros((4, 3)), np.zeros((4, 3)), np.ones(3))
