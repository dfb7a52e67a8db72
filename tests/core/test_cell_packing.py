# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shapes of cells are packed apart, none is lost or changed, and what cannot fit is not packed."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from radtex_addon.core.arrays import Bools, Ints
from radtex_addon.core.cell_packing import Spot, place


def laid_out(masks: list[Bools], spots: list[Spot], width: int, height: int) -> Ints:
    """The rectangle with the numbers of the shapes in it, -1 where none is."""
    found = np.full((height, width), -1)
    for number, (mask, spot) in enumerate(zip(masks, spots, strict=True)):
        shape = np.rot90(mask, -1) if spot.turned else mask
        rows, columns = shape.shape
        window = found[spot.row : spot.row + rows, spot.column : spot.column + columns]
        assert window.shape == shape.shape
        assert (window[shape] == -1).all()
        window[shape] = number
    return found


def blob(random: np.random.Generator) -> Bools:
    shape = tuple(random.integers(1, 9, 2))
    mask = random.random(shape) < random.choice([0.5, 1.0])
    mask[random.integers(shape[0]), :] = True
    return mask


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(0, 3))
def test_shapes_lie_apart(seed: int, gap: int) -> None:
    random = np.random.default_rng(seed)
    masks = [blob(random) for _ in range(12)]
    spots = place(masks, 40, 44, gap)
    assert spots is not None
    found = laid_out(masks, spots, 40, 44)
    rows, columns = np.nonzero(found >= 0)
    owner = found[rows, columns]
    near = np.maximum(np.abs(rows[:, None] - rows), np.abs(columns[:, None] - columns)) <= gap
    assert not (near & (owner[:, None] != owner)).any()


def test_a_rectangle_is_filled_to_the_last_cell() -> None:
    spots = place([np.ones((3, 5), dtype=bool)] * 4, 11, 7, 1)
    assert spots is not None
    assert (laid_out([np.ones((3, 5), dtype=bool)] * 4, spots, 11, 7) >= 0).sum() == 60
    assert place([np.ones((3, 5), dtype=bool)] * 5, 11, 7, 1) is None
    assert place([np.ones((8, 2), dtype=bool)], 8, 2, 2) == [Spot(0, 0, turned=True)]


@pytest.mark.parametrize("turned", [False, True])
def test_a_shape_fits_into_the_notch_of_another(turned: bool) -> None:
    notched = np.ones((4, 6), dtype=bool)
    notched[2:, 2:4] = False
    key = np.ones((1, 2) if turned else (2, 1), dtype=bool)
    spots = place([notched, key], 6, 4, 0)
    assert spots is not None
    assert (laid_out([notched, key], spots, 6, 4) >= 0).sum() == 22
