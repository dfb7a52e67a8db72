# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shadows in one bit a cell: how they are packed, and how lights look them up.

A bit is 1 where the direction of its cell's centre is blocked. A visibility is 1 where nothing blocks.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from .arrays import Bools, Floats, Ints, as_floats
from .atlas import AtlasLayout
from .errors import ShapeError
from .frame import fallback_tangent
from .hemisphere import direction_to_square
from .sampler import Filter, blend_buckets, checked_lookups, four_cells

WORD = 32  # bits

_GOLDEN = np.pi * (3 - np.sqrt(5))


def word_count(bucket: int) -> int:
    """How many 32-bit words hold a texel's bits."""
    return -(-bucket * bucket // WORD)


def pack_bits(blocked: Bools) -> npt.NDArray[np.uint32]:
    """Cells (..., n, n), [q, p], as words (..., `word_count`(n)): bit q * n + p, the least significant first.

    Bits beyond the last cell are 0. Raises ShapeError for another shape.
    """
    if blocked.ndim < 2 or blocked.shape[-1] != blocked.shape[-2]:
        raise ShapeError(f"blocked: expected shape (..., n, n), got {blocked.shape}")
    n = blocked.shape[-1]
    bits = np.zeros((*blocked.shape[:-2], word_count(n) * WORD), dtype=bool)
    bits[..., : n * n] = blocked.reshape(*blocked.shape[:-2], n * n)
    packed = np.packbits(bits, axis=-1, bitorder="little")
    return packed.view("<u4").astype(np.uint32, copy=False)


def unpack_bits(words: Ints, bucket: int) -> Bools:
    """What `pack_bits` packed: (..., n, n). Raises ShapeError for another number of words."""
    count = word_count(bucket)
    if words.ndim < 1 or words.shape[-1] != count or words.dtype.kind not in "iu":
        raise ShapeError(f"words: expected whole numbers of shape (..., {count}), got {words.shape}")
    stored = np.ascontiguousarray(words, dtype="<u4").view(np.uint8)
    bits = np.unpackbits(stored, axis=-1, count=bucket * bucket, bitorder="little")
    cells: Bools = bits.reshape(*words.shape[:-1], bucket, bucket).astype(bool)
    return cells


def visibility(words: Ints, layout: AtlasLayout, uv: Floats, direction: Floats, kind: Filter) -> Floats:
    """Whether a light is seen at texture coordinates, 0 to 1: (K,), float32 or float64 as `uv` is.

    `words` (H, W, w), row 0 at the bottom; `uv` (K, 2); `direction` (K, 3), unit vectors to the light in the
    frame, below whose horizon the rim answers. The cells' visibilities are blended as `core.sampler` blends
    radiance: `nearest` is 0 or 1. Raises ShapeError for shapes that do not fit.
    """
    buckets = _buckets(words, layout)
    uv, direction = checked_lookups(uv, direction)
    return _seen(buckets, layout, uv, direction, kind)


def soft_visibility(words: Ints, layout: AtlasLayout, uv: Floats, lights: Floats, weight: Floats) -> Floats:
    """Which share of a light's irradiance arrives, 0 to 1: (K,).

    `lights` (K, S, 3) are unit directions in the frame to points of the light, `weight` (K, S) what light of
    each would arrive, were nothing in the way; the others are as in `visibility`. Where all weights are 0 the
    share is 0.

    A shadow's edge crosses the middles of neighbouring cells at neighbouring places, which bits know well,
    while of its direction between two cells they know nothing. So bits are blended wide, over nine texels and
    four cells, where the edge lies about where the blend is a half, and then sharpened, twice as steep: the
    edge wanders from cell to cell instead of jumping, and what is blocked stays so.
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
    """`soft_visibility` by whole cells, of which the light's own size blends many.

    It reads far less, and with more than 8 x 8 cells is about as good. `kind` says whether it blends texels.
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

    Along an axis they are (1/2 - g, 1, 1/2 + g) / 2 where the position is g beyond the nearest middle: a box
    of one texel's width, blurred by one of two.
    """
    nearest = np.floor(position)
    beyond = position - nearest - 0.5
    along = np.stack([0.5 - beyond, np.ones_like(beyond), 0.5 + beyond]) / 2
    for y in range(3):
        for x in range(3):
            texel = np.clip(nearest + np.array([x - 1, y - 1]), 0, size - 1).astype(np.intp)
            yield texel, along[x, :, 0] * along[y, :, 1]


def sun_directions(to_sun: Floats, angle: float, count: int) -> Floats:
    """Directions (..., S, 3), even in solid angle, over a sun's disc, in the space of `to_sun` (..., 3).

    `angle` is the disc's diameter in radians, as Blender's sun has it. One direction is its middle.
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
    """What a sun's irradiance at a right angle is to the mean cosine over `sun_directions`: 2 / (1 + cos).

    Of its disc of even radiance L, that is L pi sin² over L times its solid angle times the mean cosine.
    """
    return float(2 / (1 + np.cos(angle / 2)))


def disc_points(count: int) -> Iterator[tuple[float, float]]:
    """Points of the unit disc, each standing for as much of its area: a sunflower's seeds (Vogel, 1979)."""
    for index in range(count):
        radius, turn = np.sqrt((index + 0.5) / count), index * _GOLDEN
        yield float(radius * np.cos(turn)), float(radius * np.sin(turn))


def square_points(count: int) -> Iterator[tuple[float, float]]:
    """Points of the square [-1, 1]^2, each standing for as much of its area.

    Roberts's sequence of plastic numbers (2018): steps of 1/g and 1/g^2, g^3 = g + 1.
    """
    golden = 1.32471795724474602596
    for index in range(count):
        yield (2 * ((0.5 + (index + 1) / golden) % 1.0) - 1, 2 * ((0.5 + (index + 1) / golden**2) % 1.0) - 1)


def area_weights(position: Floats, normal: Floats, points: Floats, axis: Floats) -> tuple[Floats, Floats]:
    """Directions (K, S, 3) and weights (K, S) of points of a flat light, for `soft_visibility`.

    `position` and `normal` (K, 3), the light's `points` (S, 3), which it shines from along its unit `axis`
    (3,), in one space. A weight is cos at the surface times cos at the light over the squared distance, 0
    where either faces away.
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
    """Blended visibilities; of `whole` cells only where `kind` blends texels."""
    texels, n = np.array([layout.width, layout.height], dtype=uv.dtype), layout.bucket
    b = direction_to_square(direction)
    if whole:
        b = (np.clip(np.floor((b + 1) / 2 * n), 0, n - 1) + 0.5) / n * 2 - 1
    return blend_buckets(buckets, uv * texels, b, texels, kind)[:, 0]
