# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Condensed atlases: what they keep, what they lose, and how that is measured."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from radtex_addon.bake.agreement import agreement
from radtex_addon.bake.condense import condense, members
from radtex_addon.bake.fit import FALLOFF_SIZE
from radtex_addon.bake.progress import finished
from radtex_addon.core.arrays import Floats
from radtex_addon.core.octahedron import octahedron_to_direction
from radtex_addon.core.shared import Axis, Lobe, SharedAtlas, level_sizes
from tests.bake.known_object import HEIGHT, WIDTH, floor, sphere

CELLS = 6
PLAN = sphere()


def lobe(axis: Axis, weights: Floats, seed: int = 4) -> Lobe:
    """Buckets that are mixtures of as many smooth ones as `weights` (H, W, r) has, and one that all have."""
    rng = np.random.default_rng(seed)
    cell = (np.arange(CELLS) + 0.5) / CELLS
    directions = octahedron_to_direction(np.stack(np.meshgrid(cell, cell), axis=-1))
    parts = []
    for channels, usual, change in ((4, 0.0, 0.1), (3, 0.6, 0.2), (3, 0.2, 0.1)):
        first = usual + 0.05 * directions @ rng.normal(size=(3, channels))
        others = change * np.tanh(
            np.einsum("yxd,rdc->ryxc", directions, rng.normal(size=(weights.shape[2], 3, channels)))
        )
        part = first + np.einsum("hwr,ryxc->hwyxc", weights, others)
        part = (np.abs(part) if channels == 4 else part).astype(np.float32)
        covered = part.reshape(-1, CELLS, CELLS, channels)[PLAN.texel]
        parts.append(PLAN.placed(covered, gutter=True))
    return Lobe(axis, *parts)


def atlas(*lobes: Lobe) -> SharedAtlas:
    rng = np.random.default_rng(2)
    sizes = level_sizes(32, 3)
    bright = [np.full((size, size, 3), 0.5) + 0.2 * rng.random((size, size, 3)) for size in sizes]
    return SharedAtlas(
        colour=np.full((HEIGHT, WIDTH, 3), 0.1, np.float32),
        irradiance=np.full((HEIGHT, WIDTH, 3), 0.5, np.float32),
        falloff=np.ones((FALLOFF_SIZE, 3), np.float32),
        surroundings=tuple(level.astype(np.float32) for level in bright),
        sharpest=1e-3,
        lobes=lobes,
    )


def varied(rank: int) -> Floats:
    """Weights (H, W, rank) that differ from texel to texel."""
    return np.random.default_rng(3).uniform(-1, 1, (HEIGHT, WIDTH, rank)).astype(np.float32)


@pytest.mark.parametrize("axis", list(Axis))
@pytest.mark.parametrize("rank", [2, 6])
def test_mixtures_of_as_many_buckets_are_kept_wholly(axis: Axis, rank: int) -> None:
    """On a floor, where all see the same half of their buckets. Spreads, as lengths, are no mixtures."""
    whole = lobe(axis, varied(rank))
    ends = np.full_like(whole.ends, 0.01)
    ends[..., :3] = whole.ends[..., :3]
    found = finished(condense(atlas(replace(whole, ends=ends)), floor(), clusters=1, rank=rank)).lobes[0]
    assert found.ends.shape == (1, 1 + rank, CELLS, CELLS, 4)
    assert np.abs(found.weights).max() == pytest.approx(1, abs=1e-5)
    cell = (np.arange(CELLS) + 0.5) / CELLS
    upwards = octahedron_to_direction(np.stack(np.meshgrid(cell, cell), axis=-1))[..., 2]
    seen = upwards > 0 if axis is Axis.MIRROR else upwards < 0
    for part in ("gain", "rest"):
        off = getattr(found.expanded(), part) - getattr(whole, part)
        assert np.abs(off[:, :, seen]).max() < 5e-3, part


@pytest.mark.parametrize("each", [(), (1,), (3,)])
def test_each_cluster_has_the_texels_that_name_it_once(each: tuple[int, ...]) -> None:
    clusters = np.random.default_rng(1).integers(0, 20, (500, *each)).astype(np.int32)
    for number, texels in zip(range(20), members(clusters), strict=True):
        naming = (clusters.reshape(500, -1) == number).any(axis=1)
        np.testing.assert_array_equal(texels, np.flatnonzero(naming))


def test_more_clusters_come_nearer() -> None:
    full = atlas(lobe(Axis.MIRROR, varied(12)), lobe(Axis.THROUGH, varied(12), seed=9))
    condensed = [finished(condense(full, PLAN, count)).expanded() for count in (1, 16, 128)]
    found = [finished(agreement(one, full, PLAN)) for one in condensed]
    print("dB from the whole:", *(f"{value:.1f}" for value in found))
    assert found[0] + 1 < found[1] < found[2] - 1


def test_texels_that_are_one_each_lose_nothing() -> None:
    full = atlas(lobe(Axis.MIRROR, varied(12)))
    condensed = finished(condense(full, PLAN, clusters=10 * HEIGHT * WIDTH))
    assert len(condensed.lobes[0].ends) <= len(PLAN.texel)
    assert finished(agreement(condensed.expanded(), full, PLAN)) > 45


def test_it_is_the_same_again() -> None:
    full = atlas(lobe(Axis.MIRROR, varied(5)))
    one, other = (finished(condense(full, PLAN, 16)).lobes[0] for _ in range(2))
    for part in ("cluster", "weights", "ends", "gain", "rest"):
        np.testing.assert_array_equal(getattr(one, part), getattr(other, part))


def test_it_gives_way_between_blocks_of_work() -> None:
    """So that nobody waits for the end of it who wants it to end: once a cluster at least, in each turn."""
    full = atlas(lobe(Axis.MIRROR, varied(5)))
    steps = condense(full, PLAN, 16)
    assert sum(1 for _ in steps) > 5 * 10
    assert sum(1 for _ in agreement(full, full, PLAN)) >= 5


def test_an_atlas_without_a_lobe_stays_as_it_is() -> None:
    assert finished(condense(atlas(), PLAN, 16)).expanded().lobes == ()


def test_texels_that_nothing_covers_have_a_neighbours_mixture() -> None:
    """Fragments at an island's edge are blended with them."""
    condensed = finished(condense(atlas(lobe(Axis.MIRROR, varied(3))), PLAN, 8)).lobes[0]
    assert condensed.cluster.shape == (HEIGHT, WIDTH)
    mixture = np.concatenate([condensed.cluster[..., None], condensed.weights], axis=-1)
    own = {tuple(texel) for texel in mixture[PLAN.covered].tolist()}
    assert {tuple(texel) for texel in mixture[~PLAN.covered].tolist()} <= own


def test_agreement_is_the_psnr_of_what_viewers_see() -> None:
    dim, bright = (replace(atlas(), colour=np.full((HEIGHT, WIDTH, 3), c, np.float32)) for c in (0.4, 0.6))
    step = 0.3 ** (1 / 2.2) - 0.2 ** (1 / 2.2)
    assert finished(agreement(dim, bright, PLAN)) == pytest.approx(-20 * np.log10(step), abs=0.01)
    assert finished(agreement(dim, dim, PLAN)) == pytest.approx(100)
