# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The shared layout's paths go with the samples that the user asks for."""

from __future__ import annotations

import pytest

from radtex_addon.bake.rays import Rays


def test_the_specs_default_is_rays_default() -> None:
    assert Rays.of(16) == Rays()


@pytest.mark.parametrize("samples", [4, 16, 64, 256, 1024])
def test_a_texel_spends_about_64_paths_for_each_sample(samples: int) -> None:
    assert 0.6 < Rays.of(samples).of_texel / (64 * samples) < 1


def test_the_fewest_rays_still_tell_directions_apart() -> None:
    rays = Rays.of(1)
    assert rays.light >= 4
    assert min(rays.ends, rays.around) >= 2
    assert rays.panorama == 1


def test_the_panorama_stays_one_render() -> None:
    rays = Rays.of(4096)
    assert rays.size**2 * rays.panorama <= 2048**2
