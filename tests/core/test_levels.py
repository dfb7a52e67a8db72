# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Levels of the bucket matrix: plain means, exact halves, continuous lookups."""

from __future__ import annotations

import numpy as np
import pytest

from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.errors import ShapeError
from radtex_addon.core.levels import fitting_levels, halved, pad, padded_layout
from tests.lookups import LAYOUT, random_atlas
from tests.reference.levels import level_chain, sample_level

LEVELS = 4  # 13 x 7 texels are stored as 16 x 8
ATLAS = random_atlas().astype(np.float64)


@pytest.mark.parametrize(
    ("size", "levels", "stored"), [((13, 7), 1, (13, 7)), ((13, 7), 4, (16, 8)), ((128, 126), 5, (128, 128))]
)
def test_stored_sizes_are_halved_without_a_rest(
    size: tuple[int, int], levels: int, stored: tuple[int, int]
) -> None:
    assert padded_layout(AtlasLayout(*size, 6), levels) == AtlasLayout(*stored, 6)


def test_padding_repeats_the_last_texel_and_keeps_the_rest() -> None:
    stored = padded_layout(LAYOUT, LEVELS)
    buckets = stored.to_buckets(pad(ATLAS, LAYOUT, stored))
    assert (buckets[:7, :13] == LAYOUT.to_buckets(ATLAS)).all()
    assert (buckets[:7, 13:] == buckets[:7, 12:13]).all()
    assert (buckets[7] == buckets[6]).all()


def test_a_level_holds_the_mean_of_its_block_cell_by_cell() -> None:
    chain = level_chain(ATLAS, LAYOUT, LEVELS)
    assert [level.shape for level in chain] == [(48, 96, 4), (24, 48, 4), (12, 24, 4), (6, 12, 4)]
    stored = padded_layout(LAYOUT, LEVELS).to_buckets(chain[0])
    second = AtlasLayout(4, 2, 6).to_buckets(chain[2])
    np.testing.assert_allclose(second[1, 2], stored[4:8, 8:12].mean(axis=(0, 1)), rtol=1e-14)


def test_the_mean_of_half_floats_does_not_overflow() -> None:
    bright = np.full((4, 4, 3), 65504, np.float16)
    last = level_chain(bright, AtlasLayout(2, 2, 2), 2)[1]
    assert last.dtype == np.float32
    assert (last == 65504).all()


@pytest.mark.parametrize("level", [0, 1, 1.5, 2])
def test_levels_do_not_shift_what_they_blur(level: float) -> None:
    """A slope over u stays the same slope, away from the edges, though 13 texels have no half."""
    ramp = np.broadcast_to(np.arange(13.0)[None, :, None, None, None] + 0.5, (7, 13, 6, 6, 1))
    chain = level_chain(LAYOUT.from_buckets(ramp), LAYOUT, 3)
    uv = np.stack([np.linspace(0.2, 0.75, 100), np.full(100, 0.4)], axis=-1)
    result = sample_level(chain, LAYOUT, uv, np.tile([0.0, 0.0, 1.0], (100, 1)), np.array(level))
    np.testing.assert_allclose(result[:, 0], uv[:, 0] * 13, rtol=1e-12)


@pytest.mark.parametrize(
    ("size", "levels"), [((128, 126), 7), ((1, 5), 1), ((130, 130), 5), ((64, 64), 7), ((2, 512), 2)]
)
def test_as_many_levels_as_padding_a_quarter_allows(size: tuple[int, int], levels: int) -> None:
    assert fitting_levels(AtlasLayout(*size, 8)) == levels


def test_wrong_shapes_are_named() -> None:
    with pytest.raises(ShapeError, match="levels: expected 1 to 16"):
        padded_layout(LAYOUT, 0)
    with pytest.raises(ShapeError, match="have no half"):
        halved(ATLAS, LAYOUT)
    with pytest.raises(ShapeError, match="does not fit"):
        pad(ATLAS, LAYOUT, AtlasLayout(12, 8, 6))
