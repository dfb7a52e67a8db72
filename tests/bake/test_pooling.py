# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sums in cells and over neighbours, against the slow and plain way."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from radtex_addon.bake.blocks import in_blocks
from radtex_addon.bake.plan import CapturePlan
from radtex_addon.bake.pooling import SHARE, Neighbours, Taps, upsampled
from radtex_addon.core.arrays import Floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.octahedron import octahedron_taps, sample_octahedron
from tests.bake.known_plans import HEIGHT, WIDTH, floor

TEXELS, SAMPLES = 5, 300

sizes = pytest.mark.parametrize("n", [1, 2, 3, 16])


def places() -> Floats:
    """On the octahedron's square, its edges and corners among them: (2, TEXELS, SAMPLES)."""
    place = np.random.default_rng(1).random((2, TEXELS, SAMPLES)).astype(np.float32)
    place[:, :, :4] = np.array([[0, 0, 1, 1], [0, 1, 0, 1]])[:, None]
    place[0, :, 4:20], place[1, :, 20:40] = 0, 1
    return place


@sizes
def test_samples_take_from_four_cells_as_any_lookup_does(n: int) -> None:
    table = np.random.default_rng(2).random((3, TEXELS, n * n)).astype(np.float32)
    found = Taps.of(places(), n).gather(table)
    for texel in range(TEXELS):
        image = table[:, texel].T.reshape(n, n, 3)
        expected = sample_octahedron(image, places()[:, texel].T)
        np.testing.assert_allclose(found[:, texel], expected.T, atol=2e-6)


@sizes
def test_samples_give_to_the_cells_that_they_take_from(n: int) -> None:
    rng = np.random.default_rng(3)
    columns = rng.random((2, TEXELS, SAMPLES)).astype(np.float32)
    found = Taps.of(places(), n).scatter(columns)
    expected = np.zeros((2, TEXELS, n * n))
    for texel in range(TEXELS):
        for cell, weight in octahedron_taps(places()[:, texel].T.astype(float), n):
            for column, total in zip(columns[:, texel], expected[:, texel], strict=True):
                np.add.at(total, cell, weight * column)
    np.testing.assert_allclose(found, expected, rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize(("n", "finer"), [(1, 4), (2, 8), (8, 16), (4, 4)])
def test_finer_buckets_are_looked_up(n: int, finer: int) -> None:
    table = np.random.default_rng(4).random((2, 70, n * n)).astype(np.float32)
    middle = (np.arange(finer) + 0.5) / finer
    place = np.stack(np.meshgrid(middle, middle), axis=-1).reshape(-1, 2)
    expected = [sample_octahedron(table[:, texel].T.reshape(n, n, 2), place).T for texel in range(70)]
    np.testing.assert_allclose(upsampled(table, finer), np.stack(expected, axis=1), atol=1e-6)


def pooled(plan: CapturePlan, wide: bool = False) -> Floats:
    """How much each texel gets of each other: [from, to]."""
    each = np.eye(len(plan.texel), dtype=np.float32)[:, :, None]
    return Neighbours(plan).pool(each, wide)[..., 0]


def test_neighbours_count_by_a_gaussian_of_one_texel() -> None:
    share = pooled(floor())
    j, i = np.divmod(np.arange(HEIGHT * WIDTH), WIDTH)
    inside = (i >= 2) & (i < WIDTH - 2) & (j >= 2) & (j < HEIGHT - 2)
    np.testing.assert_allclose(share[:, inside].sum(axis=0), 1, atol=1e-5)
    np.testing.assert_allclose((share[:, inside] ** 2).sum(axis=0), SHARE, rtol=1e-5)
    for offset in (i[:, None] - i, j[:, None] - j):
        variance = (share * offset**2).sum(axis=0)[inside]
        np.testing.assert_allclose(variance, 2 * (0.244201 + 4 * 0.054489), rtol=1e-4)
    np.testing.assert_allclose(share, share.T, atol=1e-7)


def test_wide_neighbours_reach_three_texels_on() -> None:
    share = pooled(floor(), wide=True)
    j, i = np.divmod(np.arange(HEIGHT * WIDTH), WIDTH)
    middle = (HEIGHT // 2) * WIDTH + WIDTH // 2
    for offset, reach in ((i - i[middle], 8), (j - j[middle], 8)):
        variance = (share[middle] * offset**2).sum()
        assert 0.9 < variance / (10 * 2 * (0.244201 + 4 * 0.054489)) < 1.001
        assert np.abs(offset[share[middle] > 0]).max() == min(reach, np.abs(offset).max())


def test_texels_of_another_island_are_no_neighbours_and_one_alone_has_itself() -> None:
    plan = floor()
    left = plan.texel % WIDTH < WIDTH // 2
    position = plan.points.copy()
    position[left, 2] += 100
    share = pooled(replace(plan, position=position.reshape(plan.position.shape)))
    assert not share[np.ix_(left, ~left)].any()
    assert share[np.ix_(left, left)].any(axis=0).all()
    one = np.ones((1, 1, 3), dtype=np.float32)
    alone = CapturePlan(AtlasLayout(1, 1, 8), np.array([0]), one, one, one, one, one)
    np.testing.assert_allclose(pooled(alone), [[0.402620**2]], rtol=1e-5)


def test_blocks_cover_all_texels_in_order() -> None:
    assert in_blocks(lambda some: (some.start, some.stop), 10, 100, 350) == [(0, 3), (3, 6), (6, 9), (9, 10)]
    assert in_blocks(lambda some: some, 3, 10**9) == [slice(0, 1), slice(1, 2), slice(2, 3)]
    assert in_blocks(lambda some: some, 0, 5) == []
