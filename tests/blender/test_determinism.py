# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes are the same whatever surrounds them: `tests.bench.determinism` and `.metamorphic` are wider."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from tests.bench.determinism import scenes
from tests.bench.determinism.__main__ import baked, started
from tests.bench.metamorphic.__main__ import RELATIONS
from tests.bench.metamorphic.trial import SIGMAS, Outcome, Trial, same_bits, same_light
from tests.blender import stage

pytestmark = pytest.mark.one_blender
CHEAP = ["radiance", "layers", "incident", "shadow", "ao", "transfer", "lights", "layered"]


@pytest.mark.skipif(sys.platform != "linux", reason="processes are kept to one core")
def test_hash_seed_cores_memory_folder_and_address_change_no_bit(tmp_path: Path) -> None:
    context: Any = bpy.context
    scenes.build("lamps")
    stage.world((0.2, 0.3, 0.4))  # the sky's picture costs each render its time
    blend = tmp_path / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    assert len([item for item in context.scene.objects if item.type == "LIGHT"]) > 10
    options = ("--uv", "UVMap", "--smaller", "4")
    both = [
        started(blend, CHEAP, tmp_path / "plain", *options),
        started(blend, CHEAP, tmp_path / "an other place", *options, odd=True),
    ]
    plain, odd = map(baked, both)
    assert list(plain) == CHEAP
    assert all(plain.values())
    assert odd == plain


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
