# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The shared layout's lookup: each term by itself, along both axes, and what odd inputs are told."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from radtex_addon.core.arrays import Floats
from radtex_addon.core.errors import ShapeError
from radtex_addon.core.frame import normalised
from radtex_addon.core.octahedron import octahedron_to_direction
from radtex_addon.core.shared import (
    Axis,
    Lobe,
    SharedAtlas,
    bilinear_texels,
    level_sizes,
    level_weights,
    sample_falloff,
    sample_shared,
    sample_surroundings,
)

HEIGHT, WIDTH = 3, 5
SHARPEST = 1e-4  # radians²
COUNT = 4000


def directions(size: int) -> Floats:
    """Directions of an octahedral image's cells, (size, size, 3)."""
    middle = (np.arange(size) + 0.5) / size
    return octahedron_to_direction(np.stack(np.meshgrid(middle, middle), axis=-1))


def smooth(d: Floats) -> Floats:
    """A world (..., 3), positive and different in every direction."""
    return np.stack([2 + d[..., 0], 1.5 + d[..., 1] * d[..., 2], 2 - d[..., 2] + 0.5 * d[..., 1]], axis=-1)


def ramp(height: int, width: int) -> Floats:
    """(height, width, 3): columns + 10 rows + 100 channels, which bilinear lookups keep."""
    j, i, c = np.meshgrid(np.arange(height), np.arange(width), np.arange(3), indexing="ij")
    return (1.0 + i + 10 * j + 100 * c).astype(np.float32)


def ramp_at(uv: Floats, height: int, width: int) -> Floats:
    x, y = np.clip(uv * [width, height] - 0.5, 0, [width - 1, height - 1]).T
    ramp_there: Floats = (1 + x + 10 * y)[:, None] + [0, 100, 200]
    return ramp_there


def lobe(
    axis: Axis, n: int = 4, shift: Any = 0, spread: Any = SHARPEST, gain: Any = 0, rest: Any = 0
) -> Lobe:
    """A lobe whose parts are broadcast over the texels and n x n cells; black unless it has gain or rest."""
    base = (HEIGHT, WIDTH, n, n)
    vectors = [np.broadcast_to(part, (*base, 3)).astype(np.float32) for part in (shift, gain, rest)]
    variance = np.broadcast_to(spread, base)[..., None].astype(np.float32)
    return Lobe(axis, np.concatenate([vectors[0], variance], axis=-1), *vectors[1:])


def black(*lobes: Lobe, **parts: Any) -> SharedAtlas:
    """An atlas that shows nothing, but for the lobes and the given parts."""
    nothing: dict[str, Any] = {
        "colour": np.zeros((HEIGHT, WIDTH, 3), dtype=np.float32),
        "irradiance": np.zeros((HEIGHT, WIDTH, 3), dtype=np.float32),
        "falloff": np.ones((16, 3), dtype=np.float32),
        "surroundings": (np.zeros((8, 8, 3), dtype=np.float32),),
    }
    return SharedAtlas(**(nothing | parts), sharpest=SHARPEST, lobes=lobes)


def around(size: int = 128) -> tuple[Floats]:
    """Surroundings of one level that show the smooth world."""
    return (smooth(directions(size)).astype(np.float32),)


def greys(*values: float) -> tuple[Floats, ...]:
    """A level of surroundings for each value, which shows it in every direction."""
    sides = level_sizes(32, len(values))
    return tuple(
        np.full((side, side, 3), value, dtype=np.float32) for side, value in zip(sides, values, strict=True)
    )


def fragments(seed: int = 1) -> tuple[Floats, Floats, Floats]:
    """Places on the atlas, normals, and viewers on the normals' side."""
    rng = np.random.default_rng(seed)
    normal, viewer = normalised(rng.normal(size=(2, COUNT, 3)))
    viewer *= np.sign(np.sum(normal * viewer, axis=1, keepdims=True))
    return rng.random((COUNT, 2)), normal, viewer


def along(axis: Axis, normal: Floats, viewer: Floats) -> Floats:
    """Where the lobe's axis points, (K, 3)."""
    if axis is Axis.THROUGH:
        return -viewer
    mirrored: Floats = 2 * np.sum(normal * viewer, axis=1, keepdims=True) * normal - viewer
    return mirrored


both_axes = pytest.mark.parametrize("axis", Axis)


def test_without_lobes_a_fragment_shows_colour_times_light_times_falloff() -> None:
    slope = (np.arange(16) + 0.5)[:, None] / 16 * [0.2, 0.5, 0.8] + 0.1
    own = ramp(HEIGHT, WIDTH)
    atlas = black(colour=ramp(7, 11), irradiance=own, falloff=slope, surroundings=greys(1e3))
    uv, normal, viewer = fragments()
    cosine = np.clip(np.sum(normal * viewer, axis=1, keepdims=True), 0.5 / 16, 1 - 0.5 / 16)
    light = ramp_at(uv, 7, 11) * ramp_at(uv, HEIGHT, WIDTH)
    found = sample_shared(atlas, uv, normal, viewer)
    assert found.dtype == np.float32
    np.testing.assert_allclose(found, light * (cosine * [0.2, 0.5, 0.8] + 0.1), rtol=1e-5)


@both_axes
def test_constant_buckets_blend_as_plain_bilinear_colours(axis: Axis) -> None:
    colours = np.random.default_rng(2).random((HEIGHT, WIDTH, 1, 1, 3))
    _, normal, viewer = fragments()
    i, j = np.random.default_rng(3).integers(0, [WIDTH - 1, HEIGHT - 1], (COUNT, 2)).T
    part = np.random.default_rng(4).random((COUNT, 2))
    uv = (np.stack([i, j], axis=-1) + part + 0.5) / [WIDTH, HEIGHT]
    x, y = part[:, :1], part[:, 1:]
    flat = colours[:, :, 0, 0]
    low = flat[j, i] * (1 - x) + flat[j, i + 1] * x
    high = flat[j + 1, i] * (1 - x) + flat[j + 1, i + 1] * x
    found = sample_shared(black(lobe(axis, rest=colours)), uv, normal, viewer)
    np.testing.assert_allclose(found, low * (1 - y) + high * y, atol=2e-6)


@both_axes
def test_beyond_the_atlas_lies_its_edge(axis: Axis) -> None:
    colours = np.random.default_rng(2).random((HEIGHT, WIDTH, 1, 1, 3))
    uv = np.array([[-3, -3], [0, 0], [1, 1], [7, 7], [-1, 7]], float)
    up = np.tile([0, 0, 1.0], (5, 1))
    corners = colours[[0, 0, -1, -1, -1], [0, 0, -1, -1, 0], 0, 0]
    found = sample_shared(black(lobe(axis, rest=colours)), uv, up, up)
    np.testing.assert_allclose(found, corners, atol=1e-6)


@both_axes
def test_texels_are_blended_at_the_same_axis_whatever_their_normals(axis: Axis) -> None:
    """Each texel's bucket is the same picture, brighter or darker: nothing but the brightness is blended."""
    rest = ramp(HEIGHT, WIDTH)[:, :, None, None] * smooth(directions(32))
    uv, normal, viewer = fragments()
    found = sample_shared(black(lobe(axis, 32, rest=rest)), uv, normal, viewer)
    truth = smooth(along(axis, normal, viewer))
    error = np.abs(found / ramp_at(uv, HEIGHT, WIDTH) - truth)
    assert np.median(error) < 2e-3
    assert error.max() < 0.05  # half a cell's slope, where the octahedron has its edges


@both_axes
def test_without_a_shift_the_far_world_is_seen_along_the_axis(axis: Axis) -> None:
    uv, normal, viewer = fragments()
    found = sample_shared(black(lobe(axis, gain=1), surroundings=around()), uv, normal, viewer)
    error = np.abs(found - smooth(along(axis, normal, viewer)))
    assert np.median(error) < 2e-4
    assert error.max() < 0.012


@both_axes
def test_gain_tints_the_surroundings_and_rest_adds_to_them(axis: Axis) -> None:
    gain = ramp(HEIGHT, WIDTH)[:, :, None, None]
    atlas = black(lobe(axis, gain=gain, rest=[1, 2, 3]), surroundings=greys(0.25))
    uv, normal, viewer = fragments()
    expected = 0.25 * ramp_at(uv, HEIGHT, WIDTH) + [1, 2, 3]
    np.testing.assert_allclose(sample_shared(atlas, uv, normal, viewer), expected, rtol=1e-5)


@both_axes
def test_a_shift_moves_the_lookup_and_is_blended_before_it(axis: Axis) -> None:
    shift = ramp(HEIGHT, WIDTH)[:, :, None, None] / 300 - 0.4
    uv, normal, viewer = fragments()
    end = normalised(along(axis, normal, viewer) + ramp_at(uv, HEIGHT, WIDTH) / 300 - 0.4)
    found = sample_shared(black(lobe(axis, shift=shift, gain=1), surroundings=around()), uv, normal, viewer)
    assert np.abs(found - smooth(end)).max() < 0.012


@both_axes
def test_a_round_room_is_seen_where_its_wall_stands(axis: Axis) -> None:
    """From a place off its middle, which the shift of each direction makes up for."""
    place, cells = np.array([0.4, -0.3, 0.2]), directions(32)
    shift = on_the_sphere(place, cells, 2.5) - cells
    uv, normal, viewer = fragments()
    wall = on_the_sphere(place, along(axis, normal, viewer), 2.5)
    atlas = black(lobe(axis, 32, shift=shift, gain=0.5), surroundings=around())
    assert np.abs(sample_shared(atlas, uv, normal, viewer) - 0.5 * smooth(wall)).max() < 0.006


def on_the_sphere(place: Floats, direction: Floats, radius: float) -> Floats:
    """Unit vectors to where rays from a place inside cut a sphere around the origin."""
    towards = np.sum(place * direction, axis=-1, keepdims=True)
    length = np.sqrt(towards**2 - np.sum(place**2) + radius**2) - towards
    cut: Floats = (place + length * direction) / radius
    return cut


@both_axes
def test_spreads_are_blended_as_variances(axis: Axis) -> None:
    """Half-way between 1 and 16 times the sharpest lies 8.5 times: level 1.54, not 1."""
    spread = np.where(np.arange(WIDTH) < 2, 1, 16)[:, None, None] * SHARPEST
    atlas = black(lobe(axis, spread=spread, gain=1), surroundings=greys(0, 1, 2, 3))
    up = np.array([[0, 0, 1.0]])
    found = sample_shared(atlas, np.array([[2 / WIDTH, 0.5]]), up, up)
    np.testing.assert_allclose(found, np.log2(8.5) / 2, rtol=1e-5)


def test_lobes_add_up_each_along_its_own_axis() -> None:
    lobes = [lobe(Axis.MIRROR, 32, rest=smooth(directions(32))), lobe(Axis.THROUGH, 32, shift=0.3, gain=0.7)]
    uv, normal, viewer = fragments()
    alone = [sample_shared(black(one, surroundings=around()), uv, normal, viewer) for one in lobes]
    both = sample_shared(black(*lobes, surroundings=around()), uv, normal, viewer)
    assert np.abs(alone[0] - alone[1]).max() > 0.5
    np.testing.assert_allclose(both, alone[0] + alone[1], rtol=1e-6)


def test_light_below_zero_is_none() -> None:
    lobes = [lobe(Axis.MIRROR, rest=[-2, 1, -1]), lobe(Axis.THROUGH, rest=[1, -0.5, 2])]
    found = sample_shared(black(*lobes), *fragments())
    np.testing.assert_allclose(found, np.broadcast_to([0, 0.5, 1], (COUNT, 3)), atol=1e-6)


@pytest.mark.parametrize("level", range(4))
def test_a_blur_of_a_level_s_own_variance_is_that_level(level: int) -> None:
    direction, spread = normalised(np.random.default_rng(5).normal(size=(100, 3))), SHARPEST * 4.0**level
    found = sample_surroundings(greys(1, 10, 100, 1000), SHARPEST, direction, np.full(100, spread))
    np.testing.assert_allclose(found, 10.0**level, rtol=2e-5)


def test_between_levels_the_blur_is_linear_and_beyond_them_the_last() -> None:
    levels = np.linspace(-2, 6, 801)
    direction = np.tile([0.3, -0.5, 0.2], (len(levels), 1))
    found = sample_surroundings(greys(5, 1, 7, 2), SHARPEST, direction, SHARPEST * 4.0**levels)
    expected = np.interp(levels, range(4), [5, 1, 7, 2])
    np.testing.assert_allclose(found, np.repeat(expected[:, None], 3, axis=1), atol=2e-5)


def test_without_any_blur_the_sharpest_level_is_seen() -> None:
    found = sample_surroundings(greys(5, 1), SHARPEST, np.eye(3), np.array([0, -1.0, 1e-30]))
    np.testing.assert_array_equal(found, np.full((3, 3), 5))


def test_surroundings_are_seen_in_directions_of_any_length() -> None:
    direction, spread = normalised(np.random.default_rng(5).normal(size=(COUNT, 3))), np.zeros(COUNT)
    lengths = np.geomspace(1e-3, 1e3, COUNT)[:, None]
    found = sample_surroundings(around(), SHARPEST, direction, spread)
    assert np.abs(found - smooth(direction)).max() < 0.012
    stretched = sample_surroundings(around(), SHARPEST, direction * lengths, spread)
    np.testing.assert_allclose(stretched, found, atol=1e-5)


@given(st.floats(0, 10), st.integers(1, 9), st.floats(1e-9, 1))
def test_levels_weigh_one_together_and_at_most_two_of_them_anything(
    spread: float, count: int, sharpest: float
) -> None:
    levels, weights = zip(*level_weights(np.array([spread]), sharpest, count), strict=True)
    assert levels == tuple(range(count))
    assert sum(weights) == pytest.approx(1, abs=1e-6)
    some = np.flatnonzero(np.concatenate(weights))
    assert np.ptp(some) <= 1


def test_levels_halve_down_to_the_least() -> None:
    assert level_sizes(50, 6) == [50, 25, 12, 8, 8, 8]
    assert level_sizes(8, 1) == [8]


def test_falloff_is_linear_between_its_points_and_level_beyond() -> None:
    curve = np.random.default_rng(7).random((16, 3))
    cosine = np.linspace(-0.5, 1.5, 401)
    points = (np.arange(16) + 0.5) / 16
    expected = np.stack([np.interp(cosine, points, curve[:, c]) for c in range(3)], axis=-1)
    np.testing.assert_allclose(sample_falloff(curve, cosine), expected, atol=1e-12)


def test_texels_around_a_place_weigh_one_together_and_are_its_neighbours() -> None:
    uv = np.random.default_rng(8).uniform(-0.5, 1.5, (COUNT, 2))
    taps = list(bilinear_texels(uv, WIDTH, HEIGHT))
    np.testing.assert_allclose(sum(weight for _, weight in taps), 1, rtol=1e-12)
    inside = np.clip(uv * [WIDTH, HEIGHT] - 0.5, 0, [WIDTH - 1, HEIGHT - 1])
    for texel, weight in taps:
        assert weight.min() >= 0
        away = np.stack([texel % WIDTH, texel // WIDTH], axis=-1) - inside
        assert np.abs(away).max() <= 1


def test_no_fragments_are_no_error() -> None:
    none = np.zeros((0, 3))
    atlas = black(lobe(Axis.MIRROR), lobe(Axis.THROUGH))
    assert sample_shared(atlas, np.zeros((0, 2)), none, none).shape == (0, 3)


@pytest.mark.parametrize(
    ("name", "shape", "message"),
    [
        ("ends", (3, 5, 4, 4, 3), r"through ends: expected shape \(H, W, n, n, 4\), got \(3, 5, 4, 4, 3\)"),
        ("ends", (3, 5, 4, 6, 4), "through ends: expected shape"),
        ("ends", (3, 5, 4), "through ends: expected shape"),
        ("gain", (3, 5, 4, 4, 4), r"through gain: expected shape \(H, W, n, n, 3\), got \(3, 5, 4, 4, 4\)"),
        ("gain", (3, 5, 2, 2, 3), "through gain: expected shape"),
        ("rest", (5, 3, 4, 4, 3), "through rest: expected shape"),
        ("rest", (3, 5, 3), "through rest: expected shape"),
    ],
)
def test_wrong_parts_of_a_lobe_are_named(name: str, shape: tuple[int, ...], message: str) -> None:
    parts = {"ends": (3, 5, 4, 4, 4), "gain": (3, 5, 4, 4, 3), "rest": (3, 5, 4, 4, 3)} | {name: shape}
    with pytest.raises(ShapeError, match=message):
        Lobe(Axis.THROUGH, **{part: np.zeros(size) for part, size in parts.items()})


@pytest.mark.parametrize(
    ("name", "shape", "message"),
    [
        ("colour", (6, 7, 4), r"colour: expected 3 axes, the last of 3, got shape \(6, 7, 4\)"),
        ("irradiance", (3, 5), "irradiance: expected 3 axes"),
        ("falloff", (16,), r"falloff: expected 2 axes, the last of 3, got shape \(16,\)"),
    ],
)
def test_wrong_parts_of_an_atlas_are_named(name: str, shape: tuple[int, ...], message: str) -> None:
    with pytest.raises(ShapeError, match=message):
        black(**{name: np.zeros(shape)})


@pytest.mark.parametrize(
    "shapes",
    [
        [],
        [(8, 9, 3)],
        [(8, 8)],
        [(8, 8, 4)],
        [(4, 4, 3)],
        [(32, 32, 3), (17, 17, 3)],
        [(32, 32, 3), (16, 16, 3), (16, 16, 3)],
        [(16, 16, 3), (8, 8, 3), (4, 4, 3)],
    ],
)
def test_levels_that_do_not_halve_are_refused(shapes: list[tuple[int, ...]]) -> None:
    with pytest.raises(ShapeError, match="surroundings: expected shapes"):
        black(surroundings=tuple(np.zeros(shape) for shape in shapes))


def test_lobes_that_fit_neither_the_maps_nor_each_other_are_refused() -> None:
    with pytest.raises(ShapeError, match=r"mirror ends: shape \(3, 5, 4, 4, 4\) does not fit"):
        black(lobe(Axis.MIRROR), irradiance=np.zeros((5, 3, 3)))
    with pytest.raises(ShapeError, match=r"through ends: shape \(3, 5, 6, 6, 4\) does not fit"):
        black(lobe(Axis.MIRROR), lobe(Axis.THROUGH, 6))


@pytest.mark.parametrize("wrong", ["uv", "normal", "viewer"])
def test_wrong_fragments_are_named(wrong: str) -> None:
    fields = {"uv": np.zeros((4, 2)), "normal": np.zeros((4, 3)), "viewer": np.zeros((4, 3))}
    fields[wrong] = np.zeros((5, 4))
    with pytest.raises(ShapeError, match=f"{wrong}: expected shape"):
        sample_shared(black(), **fields)
