# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Metrics: errors that are known beforehand."""

from __future__ import annotations

import numpy as np
import pytest

from radtex_addon.report import metrics
from radtex_addon.report.metrics import CAP, Mask, Picture, compare, display, flip_map, psnr

ALL: Mask = np.ones((16, 16), dtype=bool)


def plain(value: float) -> Picture:
    return np.full((16, 16, 3), value)


def test_glints_are_what_is_brighter_than_white_and_no_brighter_light_makes_up_for_a_lost_one() -> None:
    reference, picture = plain(0.5), plain(0.5)
    reference[2, 2], reference[2, 3] = 4, 2
    picture[2, 2], picture[2, 3] = 1, 9
    assert compare(picture, reference, ALL, ALL).glints == pytest.approx((1 + 2) / (4 + 2))
    assert compare(plain(3), plain(0.5), ALL, ALL).glints is None


def test_decibels_are_of_display_values_and_energy_of_light_that_is_not_clipped() -> None:
    shown = display(plain(0.2)) + 0.1
    assert psnr(shown**2.2, plain(0.2), ALL) == pytest.approx(20)
    assert psnr(plain(7), plain(1), ALL) == CAP
    assert psnr(plain(-7), plain(0), ALL) == CAP
    assert compare(plain(6), plain(4), ALL, ALL).energy == pytest.approx(1.5)
    assert np.isnan(compare(plain(1), plain(0), ALL, ALL).energy)


def test_only_the_mask_counts() -> None:
    picture, mask = plain(0.5), ALL.copy()
    picture[:, 8:], mask[:, 8:] = 0, False
    found = compare(picture, plain(0.5), mask, mask)
    assert (found.psnr, found.flip, found.energy) == (CAP, 0, 1)
    assert psnr(picture, plain(0.5), ALL) < 10


def test_flip_grows_with_the_error_and_sees_all_exposures_in_hdr() -> None:
    near, far = (flip_map(plain(0.2 + step), plain(0.2)).mean() for step in (0.02, 0.3))
    assert 0 < near < far < 1
    assert flip_map(plain(9), plain(3)).max() == 0
    assert flip_map(plain(9), plain(3), hdr=True).mean() > 0.1


def test_without_flip_the_rest_is_measured(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(metrics, "flip_evaluator", None)
    assert not metrics.has_flip()
    assert compare(plain(1), plain(1), ALL, ALL).flip is None
