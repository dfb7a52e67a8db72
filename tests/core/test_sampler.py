# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The reference sampler: exact on what it must be exact on, silent across buckets, defined at every edge."""

from __future__ import annotations

import numpy as np
import pytest

from radtex_addon.core import hemisphere as hs
from radtex_addon.core.arrays import Floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.errors import ShapeError
from radtex_addon.core.sampler import Filter, sample

LAYOUT = AtlasLayout(5, 3, 4)
RNG = np.random.default_rng(7)


def random_lookups(count: int) -> tuple[Floats, Floats]:
    d = RNG.normal(size=(count, 3))
    d[:, 2] = np.abs(d[:, 2])
    return RNG.uniform(0, 1, (count, 2)), d / np.linalg.norm(d, axis=1, keepdims=True)


def image_of(buckets: Floats) -> Floats:
    return LAYOUT.from_buckets(buckets)


def test_buckets_lie_as_the_contract_says() -> None:
    image = RNG.uniform(size=(LAYOUT.pixel_height, LAYOUT.pixel_width, 3))
    buckets = LAYOUT.to_buckets(image)
    i, j, p, q = 3, 1, 2, 0
    assert (buckets[j, i, q, p] == image[j * 4 + q, i * 4 + p]).all()
    assert (LAYOUT.from_buckets(buckets) == image).all()


@pytest.mark.parametrize("kind", list(Filter))
def test_cell_centres_at_texel_centres_return_the_cell(kind: Filter) -> None:
    buckets = RNG.uniform(size=(3, 5, 4, 4, 3))
    j, i, q, p = (g.ravel() for g in np.meshgrid(range(3), range(5), range(4), range(4), indexing="ij"))
    uv = (np.stack([i, j], axis=-1) + 0.5) / [5, 3]
    incidence = hs.square_to_direction(hs.cell_centres(4)[q, p])
    np.testing.assert_allclose(
        sample(image_of(buckets), LAYOUT, uv, incidence, kind), buckets[j, i, q, p], atol=1e-12
    )


@pytest.mark.parametrize("kind", [Filter.NEAREST, Filter.LINEAR])
def test_neighbouring_buckets_never_bleed(kind: Filter) -> None:
    colours = RNG.uniform(size=(3, 5, 1, 1, 3))
    uv, incidence = random_lookups(5000)
    i, j = np.floor(uv * [5, 3]).astype(int).T
    result = sample(image_of(np.broadcast_to(colours, (3, 5, 4, 4, 3))), LAYOUT, uv, incidence, kind)
    np.testing.assert_allclose(result, colours[j, i, 0, 0], rtol=0, atol=1e-15)


def test_quadrilinear_of_constant_buckets_is_plain_bilinear_of_their_colours() -> None:
    ramp = np.arange(5.0)[None, :, None, None, None] + 10 * np.arange(3.0)[:, None, None, None, None]
    uv, incidence = random_lookups(5000)
    result = sample(
        image_of(np.broadcast_to(ramp, (3, 5, 4, 4, 1))), LAYOUT, uv, incidence, Filter.QUADRILINEAR
    )
    x, y = np.clip(uv * [5, 3] - 0.5, 0, [4, 2]).T
    np.testing.assert_allclose(result[:, 0], x + 10 * y, atol=1e-12)


def test_linear_reproduces_a_ramp_over_the_bucket() -> None:
    b = hs.cell_centres(4)
    buckets = np.broadcast_to((b[..., :1] * 2 + b[..., 1:] * 3), (3, 5, 4, 4, 1))
    uv, incidence = random_lookups(2000)
    guarded = hs.bleed_guard(hs.direction_to_square(incidence), 4)
    for kind in (Filter.LINEAR, Filter.QUADRILINEAR):
        result = sample(image_of(buckets), LAYOUT, uv, incidence, kind)
        np.testing.assert_allclose(result[:, 0], guarded @ [2, 3], atol=1e-12)


@pytest.mark.parametrize("kind", list(Filter))
def test_a_lookup_anywhere_is_defined_and_a_nan_spoils_its_own_only(kind: Filter) -> None:
    uv = np.array([[1, 1], [0, 0], [-3, 0.5], [7, 7], [0.5, 0.5], [0.5, np.nan], [0.5, 0.5]], float)
    incidence = np.array([[1, 0, 0], [0, 0, -1], [0, -1, 0], [0.6, 0, -0.8], *[[0, 0, 1]] * 3], float)
    incidence[6, 0] = np.nan
    result = sample(image_of(np.ones((3, 5, 4, 4, 3))), LAYOUT, uv, incidence, kind)
    np.testing.assert_allclose(result[:5], 1)
    assert np.isnan(result[5:]).all()


def test_wrong_shapes_are_named() -> None:
    image = np.zeros((12, 20, 3))
    with pytest.raises(ShapeError, match="uv"):
        sample(image, LAYOUT, np.zeros((4, 3)), np.zeros((4, 3)), Filter.NEAREST)
    with pytest.raises(ShapeError, match="incidence"):
        sample(image, LAYOUT, np.zeros((4, 2)), np.zeros((5, 3)), Filter.NEAREST)
    with pytest.raises(ShapeError, match="atlas image"):
        sample(np.zeros((12, 21, 3)), LAYOUT, np.zeros((4, 2)), np.zeros((4, 3)), Filter.NEAREST)
    with pytest.raises(ShapeError, match="no pixels"):
        AtlasLayout(0, 4, 8)
    with pytest.raises(ShapeError, match="buckets"):
        LAYOUT.from_buckets(np.zeros((3, 5, 4, 3, 3)))
