# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The shared layout's lookup: each term by itself, and rays that find what stands around the object."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from radtex_addon.core.arrays import Floats
from radtex_addon.core.errors import ShapeError
from radtex_addon.core.octahedron import octahedron_to_direction
from radtex_addon.core.shared import SharedAtlas, meet_surroundings, sample_falloff, sample_shared

HEIGHT, WIDTH = 3, 5
AWAY = 1e-6  # nearness of a world that no position matters to
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


def black(**parts: Floats) -> SharedAtlas:
    """An atlas that shows nothing, but for the given parts."""
    nothing: dict[str, Any] = {
        "rest": np.zeros((HEIGHT, WIDTH, 4, 4, 4)),
        "surroundings": np.zeros((8, 8, 3)),
        "nearness": np.full((8, 8), AWAY),
        "middle": np.zeros(3),
        "colour": np.zeros((HEIGHT, WIDTH, 3)),
        "irradiance": np.zeros((HEIGHT, WIDTH, 3)),
        "falloff": np.ones((16, 3)),
    }
    return SharedAtlas(**{name: part.astype(np.float32) for name, part in (nothing | parts).items()})


def with_gain(rest: Floats, gain: float) -> Floats:
    return np.concatenate([rest, np.full((*rest.shape[:-1], 1), gain)], axis=-1)


def unit(rng: np.random.Generator, count: int = COUNT) -> Floats:
    vectors = rng.normal(size=(count, 3))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def fragments(seed: int = 1) -> tuple[Floats, Floats, Floats, Floats]:
    """Places on the atlas, positions, normals and viewers on the normals' side."""
    rng = np.random.default_rng(seed)
    normal, viewer = unit(rng), unit(rng)
    viewer *= np.sign(np.sum(normal * viewer, axis=1, keepdims=True))
    return rng.random((COUNT, 2)), rng.uniform(-1, 1, (COUNT, 3)), normal, viewer


def mirrored(normal: Floats, viewer: Floats) -> Floats:
    return 2 * np.sum(normal * viewer, axis=1, keepdims=True) * normal - viewer


def degrees_between(a: Floats, b: Floats) -> Floats:
    """Angles between unit vectors (K, 3), exact for small ones."""
    angle: Floats = np.degrees(2 * np.arcsin(np.clip(np.linalg.norm(a - b, axis=1) / 2, 0, 1)))
    return angle


def test_without_gain_a_fragment_shows_colour_times_light_times_falloff_and_the_rest() -> None:
    slope = (np.arange(16) + 0.5)[:, None] / 16 * [0.2, 0.5, 0.8] + 0.1
    rest = np.broadcast_to(ramp(HEIGHT, WIDTH)[:, :, None, None], (HEIGHT, WIDTH, 4, 4, 3))
    atlas = black(
        rest=with_gain(rest, 0),
        surroundings=np.full((8, 8, 3), 1e3),
        colour=ramp(7, 11),
        irradiance=ramp(HEIGHT, WIDTH),
        falloff=slope,
    )
    uv, position, normal, viewer = fragments()
    cosine = np.clip(np.sum(normal * viewer, axis=1, keepdims=True), 0.5 / 16, 1 - 0.5 / 16)
    own = ramp_at(uv, HEIGHT, WIDTH)
    expected = ramp_at(uv, 7, 11) * own * (cosine * [0.2, 0.5, 0.8] + 0.1) + own
    found = sample_shared(atlas, uv, position, normal, viewer)
    assert found.dtype == np.float32
    np.testing.assert_allclose(found, expected, rtol=1e-5)


def test_constant_buckets_blend_as_plain_bilinear_colours() -> None:
    colours = np.random.default_rng(2).random((HEIGHT, WIDTH, 1, 1, 3))
    atlas = black(rest=with_gain(np.broadcast_to(colours, (HEIGHT, WIDTH, 4, 4, 3)), 0))
    _, position, normal, viewer = fragments()
    i, j = np.random.default_rng(3).integers(0, [WIDTH - 1, HEIGHT - 1], (COUNT, 2)).T
    part = np.random.default_rng(4).random((COUNT, 2))
    uv = (np.stack([i, j], axis=-1) + part + 0.5) / [WIDTH, HEIGHT]
    x, y = part[:, :1], part[:, 1:]
    flat = colours[:, :, 0, 0]
    low = flat[j, i] * (1 - x) + flat[j, i + 1] * x
    high = flat[j + 1, i] * (1 - x) + flat[j + 1, i + 1] * x
    found = sample_shared(atlas, uv, position, normal, viewer)
    np.testing.assert_allclose(found, low * (1 - y) + high * y, atol=2e-6)


def test_beyond_the_atlas_lies_its_edge() -> None:
    colours = np.random.default_rng(2).random((HEIGHT, WIDTH, 1, 1, 3))
    atlas = black(rest=with_gain(np.broadcast_to(colours, (HEIGHT, WIDTH, 4, 4, 3)), 0))
    uv = np.array([[-3, -3], [0, 0], [1, 1], [7, 7], [-1, 7]], float)
    up = np.tile([0, 0, 1.0], (5, 1))
    corners = colours[[0, 0, -1, -1, -1], [0, 0, -1, -1, 0], 0, 0]
    np.testing.assert_allclose(sample_shared(atlas, uv, up, up, up), corners, atol=1e-6)


def test_rest_is_looked_up_where_the_mirror_looks() -> None:
    rest = np.broadcast_to(smooth(directions(32)), (HEIGHT, WIDTH, 32, 32, 3))
    uv, position, normal, viewer = fragments()
    found = sample_shared(black(rest=with_gain(rest, 0)), uv, position, normal, viewer)
    error = np.abs(found - smooth(mirrored(normal, viewer)))
    assert np.median(error) < 2e-3
    assert error.max() < 0.05  # half a cell's slope, where the octahedron has its edges


def test_a_far_world_is_seen_in_the_mirrors_direction_wherever_the_fragment_is() -> None:
    atlas = black(rest=with_gain(np.zeros((HEIGHT, WIDTH, 4, 4, 3)), 1), surroundings=smooth(directions(128)))
    uv, position, normal, viewer = fragments()
    found = sample_shared(atlas, uv, position, normal, viewer)
    error = np.abs(found - smooth(mirrored(normal, viewer)))
    assert np.median(error) < 2e-4
    assert error.max() < 0.012
    np.testing.assert_allclose(found, sample_shared(atlas, uv, 0 * position, normal, viewer), atol=1e-5)


def test_a_round_room_is_seen_where_its_wall_stands() -> None:
    middle, radius = np.array([1, -2, 3.0]), 2.5
    atlas = black(
        rest=with_gain(np.zeros((HEIGHT, WIDTH, 4, 4, 3)), 0.5),
        surroundings=smooth(directions(128)),
        nearness=np.full((64, 64), 1 / radius),
        middle=middle,
    )
    uv, offset, normal, viewer = fragments()
    wall = on_the_sphere(offset, mirrored(normal, viewer), radius)
    found = sample_shared(atlas, uv, middle + offset, normal, viewer)
    assert np.abs(found - 0.5 * smooth(wall)).max() < 0.006


def on_the_sphere(position: Floats, direction: Floats, radius: float) -> Floats:
    """Unit vectors to where rays from positions inside cut a sphere around the origin."""
    along = np.sum(position * direction, axis=1)
    length = np.sqrt(along**2 - np.sum(position**2, axis=1) + radius**2) - along
    cut: Floats = (position + length[:, None] * direction) / radius
    return cut


@given(st.floats(1.05, 100), st.floats(-4, 4), st.integers(0, 2**32 - 1))
def test_a_sphere_is_met_exactly_at_any_scale(radius: float, magnitude: float, seed: int) -> None:
    rng, unit_of_length = np.random.default_rng(seed), 10**magnitude
    middle = unit(rng, 1)[0] * unit_of_length
    position, direction = unit(rng, 200) * rng.random((200, 1)), unit(rng, 200)
    nearness = np.full((16, 16), 1 / (radius * unit_of_length), dtype=np.float32)
    found = meet_surroundings(nearness, middle, middle + position * unit_of_length, direction)
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), 1, atol=1e-6)
    np.testing.assert_allclose(found, on_the_sphere(position, direction, radius), atol=1e-4)


def test_a_floor_is_met_within_a_degree() -> None:
    rng = np.random.default_rng(5)
    depth, middle = 1.5, np.array([4, 5, 6.0])
    nearness = np.maximum(-directions(64)[..., 2] / depth, 1e-3).astype(np.float32)
    position, direction = unit(rng), unit(rng)
    direction[:, 2] = -np.abs(direction[:, 2])
    seen = (np.sum(position * direction, axis=1) > 0) & (direction[:, 2] < -0.2)
    position, direction = position[seen], direction[seen]
    meeting = position + (-depth - position[:, 2:]) / direction[:, 2:] * direction
    found = meet_surroundings(nearness, middle, middle + position, direction)
    error = degrees_between(found, meeting / np.linalg.norm(meeting, axis=1, keepdims=True))
    assert np.median(error) < 0.1
    assert np.percentile(error, 99) < 1


def test_rays_that_pass_what_is_there_still_point_somewhere() -> None:
    """Outside the sphere there may be no cut at all: the ray's nearest place to the middle is taken."""
    rng = np.random.default_rng(6)
    position, direction = unit(rng) * 3, unit(rng)
    found = meet_surroundings(np.ones((8, 8), dtype=np.float32), np.zeros(3), position, direction)
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), 1, atol=1e-6)
    passing = np.sum(position**2, axis=1) - np.sum(position * direction, axis=1) ** 2 > 1.01
    across = np.abs(np.sum(found * direction, axis=1))[passing]
    assert across.max() < 1e-4


def test_falloff_is_linear_between_its_points_and_level_beyond() -> None:
    curve = np.random.default_rng(7).random((16, 3))
    cosine = np.linspace(-0.5, 1.5, 401)
    points = (np.arange(16) + 0.5) / 16
    expected = np.stack([np.interp(cosine, points, curve[:, c]) for c in range(3)], axis=-1)
    np.testing.assert_allclose(sample_falloff(curve, cosine), expected, atol=1e-12)


def test_no_fragments_are_no_error() -> None:
    none = np.zeros((0, 3))
    assert sample_shared(black(), np.zeros((0, 2)), none, none, none).shape == (0, 3)


@pytest.mark.parametrize(
    ("name", "shape", "message"),
    [
        ("rest", (3, 5, 4, 4, 3), r"rest: expected shape \(3, 5, 4, 4, 4\), got \(3, 5, 4, 4, 3\)"),
        ("rest", (3, 5, 4, 6, 4), "rest: expected shape"),
        ("rest", (3, 5, 4), r"rest: expected shape \(H, W, n, n, 4\), got \(3, 5, 4\)"),
        ("surroundings", (8, 9, 3), "surroundings: expected shape"),
        ("surroundings", (8, 8), r"surroundings: expected shape \(M, M, 3\), got \(8, 8\)"),
        ("nearness", (4, 8), "nearness: expected shape"),
        ("middle", (2,), r"middle: expected shape \(3\), got \(2,\)"),
        ("colour", (6, 7, 4), "colour: expected shape"),
        ("irradiance", (5, 3, 3), r"irradiance: expected shape \(3, 5, 3\), got \(5, 3, 3\)"),
        ("falloff", (16,), r"falloff: expected shape \(B, 3\), got \(16,\)"),
    ],
)
def test_wrong_parts_are_named(name: str, shape: tuple[int, ...], message: str) -> None:
    with pytest.raises(ShapeError, match=message):
        black(**{name: np.zeros(shape)})


@pytest.mark.parametrize("wrong", ["uv", "position", "normal", "viewer"])
def test_wrong_fragments_are_named(wrong: str) -> None:
    fields = {"uv": np.zeros((4, 2))} | {name: np.zeros((4, 3)) for name in ("position", "normal", "viewer")}
    fields[wrong] = np.zeros((5, 4))
    with pytest.raises(ShapeError, match=f"{wrong}: expected shape"):
        sample_shared(black(), **fields)
