# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bits, their order and their lookups; lights that are partly hidden."""

from __future__ import annotations

import numpy as np
import pytest

from radtex_addon.core import shadow
from radtex_addon.core.arrays import Bools, Floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.errors import ShapeError
from radtex_addon.core.hemisphere import cell_centres, square_to_direction
from radtex_addon.core.sampler import Filter
from tests.reference import shadows

LAYOUT = AtlasLayout(5, 3, 8)


def random_bits(layout: AtlasLayout = LAYOUT, seed: int = 1) -> Bools:
    n = layout.bucket
    return np.random.default_rng(seed).random((layout.height, layout.width, n, n)) < 0.5


@pytest.mark.parametrize(("n", "words"), [(2, 1), (5, 1), (6, 2), (8, 2), (9, 3), (16, 8)])
def test_bits_come_back_and_lie_where_the_contract_says(n: int, words: int) -> None:
    blocked = random_bits(AtlasLayout(3, 4, n))
    packed = shadow.pack_bits(blocked)
    assert packed.shape == (4, 3, words)
    assert packed.dtype == np.uint32
    np.testing.assert_array_equal(shadow.unpack_bits(packed, n), blocked)
    for q, p in ((0, 0), (0, n - 1), (n - 1, 0), (n - 1, n - 1), (n // 2, 1)):
        one = np.zeros((n, n), dtype=bool)
        one[q, p] = True
        value = sum(int(word) << 32 * place for place, word in enumerate(shadow.pack_bits(one)))
        assert value == 1 << (q * n + p)


def test_a_lookup_at_a_cells_centre_is_its_bit() -> None:
    blocked = random_bits()
    words = shadow.pack_bits(blocked)
    j, i, q, p = (axis.ravel() for axis in np.indices(blocked.shape))
    uv = (np.stack([i, j], axis=1) + 0.5) / [LAYOUT.width, LAYOUT.height]
    direction = square_to_direction(cell_centres(8))[q, p]
    for kind in Filter:
        seen = shadows.visibility(words, LAYOUT, uv, direction, kind)
        np.testing.assert_allclose(seen, ~blocked[j, i, q, p], atol=1e-12)


@pytest.mark.parametrize("blended", [True, False])
def test_soft_shadows_of_a_half_plane_are_the_share_of_the_sun_above_it(blended: bool) -> None:
    n = 64
    layout = AtlasLayout(1, 1, n)
    edge = np.radians(40)  # all that is lower towards +x is blocked
    centres = square_to_direction(cell_centres(n))
    blocked = np.arctan2(centres[..., 2], centres[..., 0]) < edge
    words = shadow.pack_bits(blocked[None, None])
    size = np.radians(20)
    for above in np.radians([-12, -6, -2, 0, 3, 8, 12]):
        sun = np.array([[np.cos(edge + above), 0, np.sin(edge + above)]])
        lights = shadows.sun_directions(sun, size, 512)
        even, uv = np.ones((1, 512)), np.full((1, 2), 0.5)
        if blended:
            share = shadows.soft_visibility(words, layout, uv, lights, even)
        else:
            share = shadows.cell_visibility(words, layout, uv, lights, even, Filter.LINEAR)
        t = np.clip(above / (size / 2), -1, 1)
        expected = 0.5 + (t * np.sqrt(1 - t * t) + np.arcsin(t)) / np.pi  # of a disc above a line
        assert abs(share[0] - expected) < 0.04  # of a sun about 10 cells wide


def test_an_edge_wanders_between_cells_instead_of_jumping() -> None:
    """A wall's edge passes cell after cell at place after place; a narrow light sees it pass evenly."""
    n, width = 8, 64
    layout = AtlasLayout(width, 1, n)
    column = cell_centres(n)[0, :, 0]
    edge = 0.125 * (np.arange(width) - 31.5)  # of each texel, along B's first axis: two texels a cell
    blocked = np.broadcast_to((column < edge[:, None])[:, None], (width, n, n))
    words = shadow.pack_bits(blocked[None])
    place = np.linspace(26, 38, 97)
    uv = np.stack([place / width, np.full(len(place), 0.5)], axis=1)
    b = np.stack([np.linspace(-0.15, 0.15, 64), np.full(64, 0.02)], axis=1)
    lights: Floats = np.broadcast_to(square_to_direction(b), (len(uv), 64, 3))
    even = np.ones(lights.shape[:2])
    expected = np.clip((0.15 - np.interp(place - 0.5, np.arange(width), edge)) / 0.3, 0, 1)
    blended = shadows.soft_visibility(words, layout, uv, lights, even)
    whole = shadows.cell_visibility(words, layout, uv, lights, even, Filter.QUADRILINEAR)
    error, of_cells = (float(np.sqrt(np.mean((found - expected) ** 2))) for found in (blended, whole))
    print(f"RMS {error:.3f}, of whole cells {of_cells:.3f}")
    assert error < 0.5 * of_cells


def test_a_suns_points_fill_its_disc_evenly() -> None:
    axis = np.array([0.0, 0.6, 0.8])
    found = shadows.sun_directions(axis, 0.2, 1000)
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), 1)
    cosine = found @ axis
    assert cosine.min() >= np.cos(0.1)
    np.testing.assert_allclose(np.mean(cosine), (1 + np.cos(0.1)) / 2, rtol=1e-6)
    assert np.mean(cosine) * shadows.sun_weight(0.2) == pytest.approx(1)  # its irradiance at a right angle
    across = np.cross(axis, [1.0, 0, 0])
    assert abs(np.mean(found @ across)) < 1e-4
    np.testing.assert_allclose(shadows.sun_directions(axis, 0.2, 1), [axis])


def test_an_area_lights_weights_add_up_to_its_irradiance() -> None:
    """A disc of radius a, straight above at height h, has the form factor a² / (a² + h²)."""
    h, a, up = 2.0, 1.0, np.array([[0.0, 0, 1]])
    points = np.array([[a * x, a * y, h] for x, y in shadows.disc_points(4000)])
    weight, behind = (shadows.area_weights(np.zeros((1, 3)), up, points, way)[1] for way in (-up[0], up[0]))
    assert abs(weight.mean() * a * a - a * a / (a * a + h * h)) < 1e-3
    assert (behind == 0).all()


def test_wrong_shapes_are_named() -> None:
    with pytest.raises(ShapeError, match=r"blocked: expected shape \(\.\.\., n, n\)"):
        shadow.pack_bits(np.zeros((2, 3), dtype=bool))
    with pytest.raises(ShapeError, match=r"words: .*\(\.\.\., 2\)"):
        shadow.unpack_bits(np.zeros((2, 3), dtype=np.uint32), 8)
