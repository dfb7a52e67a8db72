# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Levels of an image that comes in bands are those of the whole, to the bit, however it is cut."""

from __future__ import annotations

import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.levels import bucket_halving, fitting_levels, padded_layout
from radtex_addon.core.row_chain import Halving, RowChain
from radtex_addon.core.slices import image_halving
from tests.reference.levels import level_chain
from tests.reference.slices import mip_chain


def pushed(image: Floats, halvings: list[Halving], step: int) -> list[Floats]:
    """The levels of an image (..., H, W, C), whose rows come `step` at a time; each row once, in order."""
    levels: list[list[Floats]] = [[] for _ in range(len(halvings) + 1)]

    def take(level: int, first: int, rows: Floats) -> None:
        assert first == sum(some.shape[-3] for some in levels[level])
        levels[level].append(rows)

    chain = RowChain(halvings, take)
    for first in range(0, image.shape[-3], step):
        chain.push(image[..., first : first + step, :, :])
    return [np.concatenate(rows, axis=-3) for rows in levels]


@pytest.mark.parametrize("texels", [1, 3, 100])
@pytest.mark.parametrize(("width", "height", "bucket"), [(16, 8, 3), (32, 64, 2), (13, 7, 4), (1, 5, 2)])
def test_buckets_come_as_of_the_whole(width: int, height: int, bucket: int, texels: int) -> None:
    layout = AtlasLayout(width, height, bucket)
    levels = fitting_levels(layout)
    image = np.random.default_rng(1).random((height * bucket, width * bucket, 4), dtype=np.float32)
    whole = level_chain(image, layout, levels)
    stored = padded_layout(layout, levels)
    halvings = [
        bucket_halving(AtlasLayout(stored.width >> level, stored.height >> level, bucket))
        for level in range(levels - 1)
    ]
    for ours, theirs in zip(pushed(whole[0], halvings, texels * bucket), whole, strict=True):
        np.testing.assert_array_equal(ours, theirs)


@pytest.mark.parametrize("step", [1, 2, 5, 1000])
@pytest.mark.parametrize(("width", "height"), [(16, 16), (37, 21), (5, 1), (1, 9), (1, 1), (3, 127)])
def test_slices_come_as_of_the_whole(width: int, height: int, step: int) -> None:
    slices = np.random.default_rng(2).random((4, height, width, 3), dtype=np.float32)
    whole = mip_chain(slices)
    halvings = [image_halving(max(1, height >> level)) for level in range(len(whole) - 1)]
    for ours, theirs in zip(pushed(slices, halvings, step), whole, strict=True):
        np.testing.assert_array_equal(ours, theirs)
