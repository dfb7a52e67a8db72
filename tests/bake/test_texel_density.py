# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A texel density is read with its unit, is a size in texels, and is refused where it means nothing."""

from __future__ import annotations

import math
from typing import Any

import pytest

from radtex_addon.bake.spec import BakeSpec, Kind, View
from radtex_addon.bake.texel_density import MOST_TEXELS, parse_density, side_for
from radtex_addon.core.errors import InputError


@pytest.mark.parametrize(
    ("text", "per_metre"),
    [("64", 64), ("64/m", 64), (" 64 / m ", 64), ("64/cm", 6400), ("1.5/mm", 1500), ("1e2/m", 100)],
)
def test_a_density_is_texels_per_metre_whatever_its_unit(text: str, per_metre: float) -> None:
    assert parse_density(text) == per_metre


@pytest.mark.parametrize(
    "text", ["64/in", "64/", "64/m/m", "x/m", "", "0", "-3/m", "nan", "inf/m", "1e400", "1e-300/m", "1e300/m"]
)
def test_what_is_no_density_is_refused_by_its_name(text: str) -> None:
    with pytest.raises(InputError, match=r"^--density .*such as 64/m") as raised:
        parse_density(text, "--density")
    assert text in str(raised.value)


@pytest.mark.parametrize("density", [0.0, -1.0, math.nan, math.inf])
def test_a_spec_has_a_density_above_0_or_none(density: float) -> None:
    with pytest.raises(InputError, match="above 0"):
        BakeSpec(density=density)


@pytest.mark.parametrize("density", [5e-324, 1e-300, 1e-10, 1e13, 1e300])
def test_a_density_that_would_overflow_is_refused(density: float) -> None:
    with pytest.raises(InputError, match=r"from 1e-09 to 1e\+12 texels per metre"):
        BakeSpec(density=density)


@pytest.mark.parametrize("distance", [5e-324, 1e-300, 1e-38, 1e20, 1e38, 1e300, math.inf])
@pytest.mark.parametrize(
    "given", [{"kind": Kind.AO, "ao_distance": 0.0}, {"source": "Other", "extrusion": 0.0}]
)
def test_a_distance_whose_square_is_no_float_is_refused(given: dict[str, Any], distance: float) -> None:
    beyond: dict[str, Any] = {name: distance if value == 0 else value for name, value in given.items()}
    with pytest.raises(InputError, match=r"from 1e-18 to 1e\+18, in scene units"):
        BakeSpec(**beyond)


def test_the_most_texels_are_what_an_image_can_hold() -> None:
    assert BakeSpec(density=1, bucket=8).most_texels == MOST_TEXELS
    assert BakeSpec(density=1, bucket=64).most_texels == 65536 // 64
    around = BakeSpec(kind=Kind.TRANSFER, view=View.AROUND, density=1, bucket=256).most_texels
    assert around * 3 * 256 <= 65536 < (around + 4) * 3 * 256


def test_a_square_metre_that_fills_a_quarter_has_twice_its_density_along_a_side() -> None:
    assert side_for(1.0, 64, 0.25) == 128
    assert side_for(1e300, 1e300, 1e-9) > MOST_TEXELS
