# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays that end in an atlas see what a viewer would, and grazing light where they come from behind."""

from __future__ import annotations

import numpy as np
import pytest

from radtex_addon.core.sampler import Filter, sample
from tests.lookups import LAYOUT, random_atlas, random_lookups
from tests.reference.hits import sample_hit

LOOKUPS = random_lookups()
RNG = np.random.default_rng(8)


@pytest.mark.parametrize("kind", list(Filter))
def test_a_ray_finds_what_a_viewer_at_its_start_sees(kind: Filter) -> None:
    atlas = random_atlas().astype(float)
    uv, normal, tangent, sign, viewer = (
        a.astype(float) for a in (LOOKUPS.uv, LOOKUPS.normal, LOOKUPS.tangent, LOOKUPS.sign, LOOKUPS.viewer)
    )
    found = sample_hit(atlas, LAYOUT, uv, -viewer, normal, tangent, sign, kind)
    np.testing.assert_array_equal(found, sample(atlas, LAYOUT, uv, LOOKUPS.incidence, kind))


def test_a_ray_from_behind_finds_the_rim_on_its_side() -> None:
    image = random_atlas().astype(float)
    angle = RNG.uniform(0, 2 * np.pi, 500)
    across = np.stack([np.cos(angle), np.sin(angle), np.zeros(500)], axis=1)
    up, along = np.tile([0.0, 0, 1], (500, 1)), np.tile([1.0, 0, 0], (500, 1))
    uv, depth = RNG.uniform(size=(500, 2)), RNG.uniform(0.01, 3, (500, 1))
    found, rim = (
        sample_hit(image, LAYOUT, uv, ray, up, along, np.ones(500), Filter.QUADRILINEAR)
        for ray in (depth * up - across, -across)
    )
    np.testing.assert_allclose(found, rim, rtol=1e-9)
