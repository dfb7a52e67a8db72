# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Stretch is what a linear map does to a triangle: known singular values come out again."""

from __future__ import annotations

import numpy as np
import pytest

from radtex_addon.core.stretch import stretches


@pytest.mark.parametrize("most", [1.0, 1.5, 4.0])
@pytest.mark.parametrize("least", [0.25, 1.0])
def test_a_map_of_known_stretch_is_found(most: float, least: float) -> None:
    chance = np.random.default_rng(2)
    corners = chance.normal(size=(40, 3, 3))
    along = corners[:, 1] - corners[:, 0]
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    normal = np.cross(along, corners[:, 2] - corners[:, 0])
    across = np.cross(normal / np.linalg.norm(normal, axis=1, keepdims=True), along)
    flat = np.einsum("fcx,fax->fca", corners - corners[:, :1], np.stack([along, across], axis=1))
    turn, back = (np.linalg.qr(chance.normal(size=(40, 2, 2)))[0] for _ in range(2))
    mapped = np.einsum("fab,b,fbc,fkc->fka", turn, np.array([most, least]), back, flat)
    found = stretches(corners, mapped + chance.normal(size=(40, 1, 2)))
    np.testing.assert_allclose(found, np.tile([most, least], (40, 1)), rtol=1e-6)


def test_a_triangle_without_area_gives_numbers() -> None:
    assert np.isfinite(stretches(np.zeros((1, 3, 3)), np.zeros((1, 3, 2)))).all()
