# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Which of two bakes is the better one."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from radtex_addon.formats.json_reader import Facts
from radtex_addon.settings.quality import Quality
from radtex_addon.settings.spec import BakeSpec, Kind, Layer, Layout

LAYERED = Quality("layered", 256, 0, 16)
BUCKETS = Quality("buckets", 256, 8, 16, frozenset({"diffuse"}))


@pytest.mark.parametrize(
    ("new", "there", "is_worse"),
    [
        (LAYERED, LAYERED, False),
        (replace(LAYERED, texels=512, samples=32), LAYERED, False),
        (replace(LAYERED, texels=255), LAYERED, True),
        (replace(LAYERED, samples=15), LAYERED, True),
        (replace(LAYERED, texels=1024, samples=1), LAYERED, True),  # more texels, and more noise
        (replace(BUCKETS, cells=7), BUCKETS, True),
        (replace(BUCKETS, layers=frozenset()), BUCKETS, True),
        (replace(BUCKETS, layers=frozenset({"diffuse", "glossy"})), BUCKETS, False),
        (BUCKETS, LAYERED, True),
        (replace(BUCKETS, texels=512, samples=64), LAYERED, True),
        (LAYERED, BUCKETS, False),  # which choose their cells by other rules
        (replace(LAYERED, samples=8), BUCKETS, True),
        (replace(LAYERED, density=100.0), replace(LAYERED, density=100.00001, texels=300), False),
        (replace(LAYERED, density=90.0), replace(LAYERED, density=100.0), True),
        (replace(LAYERED, density=90.0), replace(LAYERED, texels=300), True),
    ],
)
def test_a_bake_is_worse_that_has_less_of_anything(new: Quality, there: Quality, is_worse: bool) -> None:
    assert new.is_worse_than(there) == is_worse


@pytest.mark.parametrize(
    ("spec", "facts"),
    [
        (
            BakeSpec(layout=Layout.LAYERED, texels=64, samples=4),
            {"layout": "layered", "bucket": 14, "samples": 4},
        ),
        (
            BakeSpec(layout=Layout.BUCKETS, texels=64, bucket=4, samples=4, layers=(Layer.DIFFUSE,)),
            {"layout": "buckets", "bucket": 4, "samples": 4, "layers": ["diffuse"]},
        ),
        (BakeSpec(kind=Kind.SHADOW, texels=64, bucket=4), {"layout": "buckets", "bucket": 4, "samples": 1}),
        (
            BakeSpec(kind=Kind.AO, texels=64, bucket=4, samples=2),
            {"layout": "buckets", "bucket": 1, "samples": 32},
        ),
        (BakeSpec(kind=Kind.TRANSFER, texels=64, samples=2), {"layout": "sphere", "bucket": 9, "samples": 2}),
    ],
)
def test_a_bake_and_its_own_specification_are_as_good_as_each_other(
    spec: BakeSpec, facts: dict[str, Any]
) -> None:
    made = Quality.in_facts(Facts({"texels": [64, 32], "layers": [], **facts}, "a sidecar"))
    assert made == Quality.of_spec(spec)
    assert Quality.of_spec(replace(spec, texels=32)).is_worse_than(made)


def test_passes_count_as_the_samples_that_they_add_up_to() -> None:
    spec = BakeSpec(layout=Layout.BUCKETS, samples=2)
    assert Quality.of_spec(spec, passes=4).samples == 8


def test_a_bake_is_told_in_words() -> None:
    assert str(LAYERED) == "layered, 256 texels, 16 samples"
    assert str(BUCKETS) == "buckets, 256 texels, 8 cells a side, 16 samples, layers diffuse"
