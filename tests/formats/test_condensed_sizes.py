# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How many bytes a condensed bake takes on a GPU, and how many clusters a budget allows."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from radtex_addon.core.shared import Axis
from radtex_addon.formats.condensed_sizes import (
    CondensedSizes,
    clusters_within,
    columns_of,
    condensed_bytes,
    texture_bytes,
)
from radtex_addon.formats.shared_files import read_shared_sidecar, write_condensed
from tests.shared_atlases import facts_about, random_condensed_atlas

HEADER = 148  # bytes of a .dds before its blocks
VASE = CondensedSizes(
    width=128,
    height=126,
    bucket=14,
    colour=(512, 504),
    surroundings=192,
    levels=6,
    clusters={Axis.MIRROR: 100},
)


def test_the_bytes_are_those_of_the_format_by_hand() -> None:
    colour, irradiance = 512 * 504, 128 * 128
    surroundings = 292 * 200  # 194 + 98 wide, 98 + 50 + 26 + 14 + 10 = 198 high
    weights = 128 * 126 * 4
    tiles = (18 * 16) * (17 * 16)  # 300 tiles: 18 columns, 17 rows
    assert VASE.columns == 18
    assert condensed_bytes(VASE) == colour + irradiance + surroundings + weights + 4 * tiles
    both = replace(VASE, clusters={Axis.MIRROR: 100, Axis.THROUGH: 7})
    fewer = 18 * 16 * 2 * 16  # 21 tiles, in 18 columns too
    assert condensed_bytes(both) - condensed_bytes(VASE) == weights + 4 * fewer
    deeper = replace(VASE, rank=6)
    assert condensed_bytes(deeper) - condensed_bytes(VASE) == weights + 4 * ((27 * 26 * 256) - tiles)


@pytest.mark.parametrize("lobes", [(), (Axis.THROUGH,), tuple(Axis)])
def test_the_bytes_are_those_of_the_files(tmp_path: Path, lobes: tuple[Axis, ...]) -> None:
    atlas, path = random_condensed_atlas(7, 5, 5, lobes=lobes), tmp_path / "Vase.radiance.json"
    write_condensed(path, atlas, facts_about(atlas))
    files = sum(file.stat().st_size - HEADER for file in tmp_path.glob("*.dds"))
    assert texture_bytes(read_shared_sidecar(path).shapes) == files
    sizes = CondensedSizes(7, 5, 14, (21, 11), 48, 5, dict.fromkeys(lobes, 5))
    assert condensed_bytes(sizes) == files


@given(st.integers(0, 40_000_000), st.sampled_from([2, 6]), st.sampled_from([2, 6, 14]), st.integers(1, 2))
def test_a_budget_is_used_up_and_kept(budget: int, rank: int, bucket: int, lobes: int) -> None:
    axes = tuple(Axis)[:lobes]
    sizes = replace(VASE, rank=rank, bucket=bucket, clusters=dict.fromkeys(axes, 1))

    def needed(count: int) -> int:
        return condensed_bytes(replace(sizes, clusters=dict.fromkeys(axes, count)))

    clusters = clusters_within(budget, sizes)
    assert clusters == 1 or needed(clusters) <= budget
    assert clusters == 128 * 126 or needed(clusters + 1) > budget


def test_there_are_no_more_clusters_than_there_can_be() -> None:
    plenty = 10**12
    assert clusters_within(plenty, VASE) == 128 * 126
    assert clusters_within(plenty, replace(VASE, width=1024, height=1024)) == 65536
    large = replace(VASE, width=1024, height=1024, bucket=62)
    count = clusters_within(plenty, large)
    assert count == 256 * 256 // 3
    assert replace(large, clusters={Axis.MIRROR: count}).misfit(256) is None
    assert clusters_within(0, VASE) == 1


@given(st.integers(1, 70_000), st.sampled_from([2, 6]))
def test_a_lobes_image_is_near_square(clusters: int, rank: int) -> None:
    columns = columns_of([clusters, 1], rank)
    rows = -(-clusters * (1 + rank) // columns)
    assert columns - 1 <= rows <= columns


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"rank": 3}, "a rank of 3, expected 2, 6, 10 and so on"),
        ({"bucket": 8}, "buckets of 8 cells a side, expected 2, 6, 10, 14 and so on"),
        ({"clusters": {Axis.MIRROR: 1, Axis.THROUGH: 65537}}, "more than 65536 clusters"),
        ({"height": 16385}, "more than 16384 pixels along a side of irradiance"),
        ({"width": 8193, "rank": 6}, "more than 16384 pixels along a side of mirror_weights"),
        ({"colour": (16385, 1)}, "more than 16384 pixels along a side of colour"),
        ({"surroundings": 10**400}, "more than 16384 pixels along a side of surroundings"),
        ({"bucket": 1022}, "more than 16384 pixels along a side of mirror_ends_xy"),
    ],
)
def test_what_no_texture_holds_is_said(changes: dict[str, object], message: str) -> None:
    assert VASE.misfit(18) is None
    assert replace(VASE, clusters={Axis.MIRROR: 65536}).misfit(444) is None
    sizes = replace(VASE, **changes)  # type: ignore[arg-type]
    assert sizes.misfit(18) == message


def test_without_lobes_buckets_mean_nothing() -> None:
    assert replace(VASE, bucket=1, clusters={}).misfit(1) is None
