# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Visibility of lamps by a bake of kind `shadow`."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from radtex_addon.core.arrays import Floats, Ints, as_floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.errors import ShapeError
from radtex_addon.core.frame import fallback_tangent
from radtex_addon.core.hemisphere import direction_to_square
from radtex_addon.core.sampler import Filter, blend_buckets, checked_lookups, four_cells
from radtex_addon.core.shadow import unpack_bits, word_count

_GOLDEN = np.pi * (3 - np.sqrt(5))


def visibility(words: Ints, layout: AtlasLayout, uv: Floats, direction: Floats, kind: Filter) -> Floats:
    """Visibility of a light at texture coordinates, 0 to 1: (K,), float32 or float64 as `uv` is.

    `words` (H, W, w), row 0 at the bottom; `uv` (K, 2); `direction` (K, 3), unit vectors to the light in the
    frame, clamped to the horizon. The cells' visibilities are blended as `core.sampler` blends radiance:
    `nearest` gives 0 or 1. Raises ShapeError for shapes that do not fit.
    """
    buckets = _buckets(words, layout)
    uv, direction = checked_lookups(uv, direction)
    return _seen(buckets, layout, uv, direction, kind)


def soft_visibility(words: Ints, layout: AtlasLayout, uv: Floats, lights: Floats, weight: Floats) -> Floats:
    """Share of an area light's irradiance that arrives, 0 to 1: (K,).

    `lights` (K, S, 3) are unit directions in the frame to points of the light, `weight` (K, S) the irradiance
    from each if nothing blocks it; the other arguments are as in `visibility`. Where all weights are 0 the
    share is 0.

    For the directions of cell centres the bits show well where a shadow's edge crosses the texels; for
    directions between them they do not. So the bits are blended widely, over nine texels and four cells: the
    edge then lies near a blend of one half. Doubling the slope there makes it sharper. The edge moves
    smoothly from cell to cell instead of jumping, and blocked areas stay blocked.
    """
    buckets, (lights, weight) = _buckets(words, layout), _checked_lights(lights, weight)
    uv, _ = checked_lookups(uv, lights[:, 0])
    texels, n = np.array([layout.width, layout.height], dtype=uv.dtype), layout.bucket
    blended = np.zeros((len(uv), n, n), dtype=uv.dtype)
    for texel, texel_weight in _nine_texels(uv * texels, texels):
        blended += texel_weight[:, None, None] * buckets[texel[:, 1], texel[:, 0], ..., 0]
    arrives, lookup = np.zeros(len(uv), dtype=uv.dtype), np.arange(len(uv))
    for sample in range(lights.shape[1]):
        seen = np.zeros(len(uv), dtype=uv.dtype)
        for cell, cell_weight in four_cells(direction_to_square(lights[:, sample]), n):
            seen += cell_weight * blended[lookup, cell[:, 1], cell[:, 0]]
        arrives += weight[:, sample] * np.clip(2 * seen - 0.5, 0, 1)
    return _share(arrives, weight)


def cell_visibility(
    words: Ints, layout: AtlasLayout, uv: Floats, lights: Floats, weight: Floats, kind: Filter
) -> Floats:
    """`soft_visibility` without blending between cells: the light's size averages over many cells anyway.

    It reads far less data, and with more than 8 x 8 cells is about as good. Texels are blended if `kind` is
    quadrilinear.
    """
    buckets, (lights, weight) = _buckets(words, layout), _checked_lights(lights, weight)
    arrives = np.zeros(len(lights), dtype=lights.dtype)
    for sample in range(lights.shape[1]):
        place, to_light = checked_lookups(uv, lights[:, sample])
        arrives += weight[:, sample] * _seen(buckets, layout, place, to_light, kind, whole=True)
    return _share(arrives, weight)


def _checked_lights(lights: Floats, weight: Floats) -> tuple[Floats, Floats]:
    lights, weight = as_floats("lights", lights, 3), np.asarray(weight)
    if lights.ndim != 3 or weight.shape != lights.shape[:2]:
        raise ShapeError(
            f"lights, weight: expected (K, S, 3) and (K, S), got {lights.shape} and {weight.shape}"
        )
    return lights, weight


def _share(arrives: Floats, weight: Floats) -> Floats:
    total = weight.sum(axis=1)
    share: Floats = np.divide(arrives, total, out=np.zeros_like(arrives), where=total > 0)
    return share


def _nine_texels(position: Floats, size: Floats) -> Iterator[tuple[Ints, Floats]]:
    """The nine texels (K, 2) around each position (K, 2), in texels, x first, and their weights (K,).

    Along an axis the weights are (1/2 - g, 1, 1/2 + g) / 2, g being the offset from the nearest centre: a box
    of one texel's width, blurred by a box of two.
    """
    nearest = np.floor(position)
    beyond = position - nearest - 0.5
    along = np.stack([0.5 - beyond, np.ones_like(beyond), 0.5 + beyond]) / 2
    for y in range(3):
        for x in range(3):
            texel = np.clip(nearest + np.array([x - 1, y - 1]), 0, size - 1).astype(np.intp)
            yield texel, along[x, :, 0] * along[y, :, 1]


def sun_directions(to_sun: Floats, angle: float, count: int) -> Floats:
    """Directions (..., S, 3) over a sun's disc, uniform in solid angle, in the space of `to_sun` (..., 3).

    `angle` is the disc's diameter in radians, as of Blender's sun. A `count` of 1 gives the centre.
    """
    to_sun = as_floats("to_sun", to_sun, 3)
    across = fallback_tangent(to_sun)
    up = np.cross(to_sun, across)
    ways = []
    for x, y in disc_points(count):
        share = x * x + y * y if count > 1 else 0.0
        cosine = 1 - share * (1 - np.cos(angle / 2))
        sine = np.sqrt(max(1 - cosine * cosine, 0)) / np.sqrt(max(share, 1e-30))
        ways.append(cosine * to_sun + sine * (x * across + y * up))
    return np.stack(ways, axis=-2)


def sun_weight(angle: float) -> float:
    """Factor from the mean cosine over `sun_directions` to irradiance, which is 1 at normal incidence.

    It is 2 / (1 + cos(angle / 2)), since for a surface that faces the sun the mean cosine over the disc is
    (1 + cos(angle / 2)) / 2: for a uniform radiance L, the irradiance L pi sin²(angle / 2) divided by L times
    the solid angle.
    """
    return float(2 / (1 + np.cos(angle / 2)))


def disc_points(count: int) -> Iterator[tuple[float, float]]:
    """Points on the unit disc, each for an equal share of its area: Vogel's sunflower spiral (1979)."""
    for index in range(count):
        radius, turn = np.sqrt((index + 0.5) / count), index * _GOLDEN
        yield float(radius * np.cos(turn)), float(radius * np.sin(turn))


def square_points(count: int) -> Iterator[tuple[float, float]]:
    """Points on the square [-1, 1]^2, each for an equal share of its area.

    Roberts's R2 sequence (2018), by the plastic number g: steps of 1/g and 1/g^2, g^3 = g + 1.
    """
    golden = 1.32471795724474602596
    for index in range(count):
        yield (2 * ((0.5 + (index + 1) / golden) % 1.0) - 1, 2 * ((0.5 + (index + 1) / golden**2) % 1.0) - 1)


def area_weights(position: Floats, normal: Floats, points: Floats, axis: Floats) -> tuple[Floats, Floats]:
    """Directions (K, S, 3) and weights (K, S) of points of a flat light, for `soft_visibility`.

    `position` and `normal` (K, 3) of the surface, the light's `points` (S, 3) and the unit `axis` (3,) along
    which it shines are in the same space. A weight is cos at the surface times cos at the light over the
    squared distance, 0 where either faces away.
    """
    toward = points[None] - position[:, None]
    squared = np.maximum(np.sum(toward * toward, axis=-1), 1e-30)
    direction = toward / np.sqrt(squared)[..., None]
    facing = np.maximum(np.sum(direction * normal[:, None], axis=-1), 0)
    leaving = np.maximum(-(direction @ axis), 0)
    return direction, facing * leaving / squared


def _buckets(words: Ints, layout: AtlasLayout) -> Floats:
    """Visibilities (H, W, n, n, 1) float32."""
    expected = (layout.height, layout.width, word_count(layout.bucket))
    if words.shape != expected:
        raise ShapeError(f"words: expected shape {expected}, got {words.shape}")
    return (~unpack_bits(words, layout.bucket)).astype(np.float32)[..., None]


def _seen(
    buckets: Floats, layout: AtlasLayout, uv: Floats, direction: Floats, kind: Filter, whole: bool = False
) -> Floats:
    """Blended visibilities (K,); with `whole` cells are not blended, only texels if `kind` does so."""
    texels, n = np.array([layout.width, layout.height], dtype=uv.dtype), layout.bucket
    b = direction_to_square(direction)
    if whole:
        b = (np.clip(np.floor((b + 1) / 2 * n), 0, n - 1) + 0.5) / n * 2 - 1
    return blend_buckets(buckets, uv * texels, b, texels, kind)[:, 0]
