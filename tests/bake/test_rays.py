# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The layered layout's paths go with the samples that the user asks for."""

from __future__ import annotations

import pytest

from radtex_addon.bake.rays import LayeredRays, side_in


def test_the_specs_default_is_rays_default() -> None:
    assert LayeredRays.of(16) == LayeredRays()


@pytest.mark.parametrize("samples", [4, 16, 64, 256, 1024])
def test_a_texel_spends_fewer_than_64_paths_for_each_sample(samples: int) -> None:
    assert 0.3 < LayeredRays.of(samples).of_texel / (64 * samples) < 1


def test_the_fewest_rays_still_tell_directions_apart() -> None:
    rays = LayeredRays.of(1)
    assert min(rays.light, rays.ends) >= 4


def test_a_map_of_wider_texels_has_whole_ones_alone() -> None:
    """The buckets of light that comes through lay in one more column than those of the rest."""
    assert [side_in(texels, 2) for texels in (1, 63, 64, 65)] == [1, 31, 32, 32]
    assert [side_in(texels, 0.25) for texels in (1, 63)] == [4, 252]
    assert side_in(1023, 1023 / 512) == 512
