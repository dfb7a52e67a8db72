# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Costs before a bake: bounds, in figures that can be counted by hand."""

from __future__ import annotations

import pytest

from radtex_addon.bake.spec import BakeSpec, Layout
from radtex_addon.forms import cost_of


def test_buckets_cost_four_half_floats_a_cell() -> None:
    cost = cost_of(BakeSpec(texels=64, bucket=8, samples=4))
    assert cost.side == 512
    assert cost.disk == cost.gpu == 512 * 512 * 4 * 2
    assert cost.paths == 512 * 512 * 4
    assert cost_of(BakeSpec(texels=64, bucket=8, half=False)).disk == 2 * cost.disk


def test_the_shared_layout_costs_all_its_images() -> None:
    cost = cost_of(BakeSpec(texels=32, layout=Layout.SHARED))
    buckets = (32 * 18) ** 2
    around = (256 + 2 + 128 + 2) * (256 + 2)
    others = (4 * 32) ** 2 + 32**2 + around
    assert cost.side == 32 * 18
    assert cost.disk == 2 * (3 * others + 2 * 10 * buckets)
    assert cost.gpu == 8 * (others + 2 * 3 * buckets)


def test_finer_texels_and_hidden_ones_are_among_the_shared_layouts_paths() -> None:
    spec = BakeSpec(texels=32, layout=Layout.SHARED, samples=16)
    of_texel = 23**2 + 2 * 10**2 + 2 * 5**2 + 16 + 2 * 16
    assert cost_of(spec).paths == 32**2 * of_texel + 2 * 256**2 * 9
    few = BakeSpec(texels=32, layout=Layout.SHARED, samples=4)  # 2 paths a cell of a panorama are 2 x 2
    assert few.rays.panorama == 2
    assert cost_of(few).paths == 32**2 * few.rays.of_texel + 32**2 * 48 + 2 * 256**2 * 4


@pytest.mark.parametrize("budget", [400_000, 1_000_000, 4_000_000])
def test_a_budget_is_kept_and_used(budget: int) -> None:
    cost = cost_of(BakeSpec(texels=64, layout=Layout.SHARED, budget=budget))
    assert cost.gpu == cost.disk
    assert 0.9 * budget < cost.gpu <= budget


def test_a_target_may_cost_a_cluster_for_each_texel() -> None:
    aimed = cost_of(BakeSpec(texels=64, layout=Layout.SHARED, target=40))
    small = cost_of(BakeSpec(texels=64, layout=Layout.SHARED, budget=400_000))
    tiles = 64 * 64 * 3  # of 16 x 16 pixels, a byte each, in four textures, and both lobes
    assert aimed.gpu > 2 * 4 * tiles * 256
    assert aimed.gpu > small.gpu
    assert aimed.paths == small.paths
