# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A few of the bench's relations on one small scene; and that its measure sees what is wrong."""

from __future__ import annotations

import numpy as np
import pytest

from tests.bench.metamorphic.__main__ import RELATIONS
from tests.bench.metamorphic.trial import SIGMAS, Outcome, Trial, same_bits, same_light

pytestmark = pytest.mark.one_blender
QUICK = (
    "the scene mirrored",
    "sheared by a parent",
    "everything renamed",
)


@pytest.mark.parametrize("name", QUICK)
def test_a_relation_holds(name: str) -> None:
    outcome = RELATIONS[name](Trial(seed=4))
    assert outcome is not None
    assert outcome.holds, f"{outcome.deviation:.3g}, allowed {outcome.allowed:g}"


def noisy(
    seed: int, light: float = 1.0, patch: float = 1.0
) -> np.ndarray[tuple[int, ...], np.dtype[np.float32]]:
    """Buckets of a light, each cell the mean of 8 skewed samples; a corner has `patch` times as much."""
    found = np.random.default_rng(seed).gamma(8, light / 8, (12, 12, 4, 4, 4)).astype(np.float32)
    found[:4, :4] *= patch
    return found


def test_noise_alone_is_no_difference() -> None:
    worst = max(same_light((noisy(s), noisy(s + 1)), noisy(s + 2)).deviation for s in range(0, 300, 3))
    assert worst < SIGMAS


@pytest.mark.parametrize("other", [noisy(2, light=0.9), noisy(2, patch=0.7)])
def test_light_that_lacks_is_one(other: np.ndarray[tuple[int, ...], np.dtype[np.float32]]) -> None:
    assert not same_light((noisy(0), noisy(1)), other).holds


def test_other_sizes_and_what_is_no_number_are_one() -> None:
    light = noisy(0)
    assert not same_bits(light, light[:6]).holds
    assert not same_light((light, noisy(1)), light[:6]).holds
    assert not Outcome(float("nan"), 1.0).holds
