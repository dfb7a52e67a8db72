# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Costs before a bake: bounds, in figures that can be counted by hand."""

from __future__ import annotations

from radtex_addon.bake.rays import panorama_paths
from radtex_addon.bake.spec import BakeSpec, Layout
from radtex_addon.forms import cost_of


def test_buckets_cost_four_half_floats_a_cell() -> None:
    cost = cost_of(BakeSpec(texels=64, bucket=8, samples=4))
    assert cost.side == 512
    assert cost.disk == cost.gpu == 512 * 512 * 4 * 2
    assert cost.paths == 512 * 512 * 4
    assert cost_of(BakeSpec(texels=64, bucket=8, half=False)).disk == 2 * cost.disk


def test_finer_texels_and_hidden_ones_are_among_the_layered_layouts_paths() -> None:
    spec = BakeSpec(texels=32, layout=Layout.LAYERED, samples=16)
    of_texel = 16**2 + 2 * 10**2 + 1 + 16 + 2 * 16
    assert cost_of(spec).paths == 32**2 * of_texel + panorama_paths(2)
