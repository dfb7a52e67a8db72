# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Ways through the object: the ray in which light came into it, from surroundings that are looked up sharply.

Of closed glass they are followed through its distance field (`distance_field`). Else the chief ones are kept
in buckets, which lie as in the plain layout: over the hemisphere of viewers, in the fragment's own frame. A
refracted ray's part along the surface is the viewer's over the index of refraction, so that a way changes
evenly over such a bucket, and turns with a round surface.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import numpy as np

from ....core.arrays import Floats, Ints
from ....core.hemisphere import direction_to_square
from ....core.sampler import bilinear, bilinear_texels
from .distance_field import DistanceField, follow
from .environment import Around

Frame = tuple[Floats, Floats, Floats]  # tangent, bitangent and normal, (N, 3) each, in world space

CHANNELS = 8  # of a way: weight x direction, weight, weight x place, weight x variance
_APART, _ALIKE = 0.8, 0.95  # cosines between ways of different and of the same kind
_EVEN = 0.03  # radians²: variance of directions that lie as far apart as neighbouring cells' do


@dataclass(frozen=True, eq=False)
class Through:
    """Light that comes through; float32, linear.

    `ways` (h, w, n, n, 8) by bucket cell [q, p]: how much the chief path lets through, times its direction
    out of the object, itself, times the place from the texel at which its line comes nearest to it, times
    its lobe's variance (radians² along each axis); vectors are in the texel's frame. `colour` (H, W, 3): what
    that, or what comes through a field, is multiplied by. `rest` (h', w', m, m, 3), by the octahedron of the
    direction in which the viewer looks: all else. `field`: through which ways are followed in place of those
    in buckets, which shader nodes show.
    """

    ways: Floats
    colour: Floats
    rest: Floats
    field: DistanceField | None = None


def look_through(
    through: Through, around: Around, uv: Floats, offset: Floats, frame: Frame, viewer: Floats
) -> Floats:
    """What the chief paths show, (3, N), at texture coordinates (N, 2).

    `offset` (N, 3) is from the middle, `viewer` (N, 3), unit, all in world space.
    """
    colour = bilinear(through.colour, uv.astype(np.float32)).T
    if through.field is not None:
        return cast(Floats, shown_through(through.field, around, offset, frame[2], viewer) * colour)
    height, width, n = through.ways.shape[:3]
    cells, shares = square_taps(in_frame(viewer, frame), n)
    flat = through.ways.reshape(height * width, n * n, -1)
    found = agreeing(
        np.stack(
            [
                (part * share).astype(np.float32)[:, None] * flat[texel, cell]
                for texel, part in bilinear_texels(uv.astype(np.float32), width, height)
                for cell, share in zip(cells, shares, strict=True)
            ]
        )
    )
    return cast(Floats, shown_of(around, found, offset, frame) * colour)


def shown_through(
    field: DistanceField, around: Around, offset: Floats, normal: Floats, viewer: Floats
) -> Floats:
    """What glass of a field shows of the surroundings, (3, N); arguments as for `follow`.

    As if the surfaces by which light comes in and goes out were white.
    """
    tint = np.array(field.facts.tint, dtype=np.float32)[:, None]
    light = np.zeros((3, len(offset)), dtype=np.float32)
    for way in follow(field, offset, normal, viewer):
        some = np.flatnonzero(way.weight)
        seen = around.look(way.place[some], way.direction[some], way.variance[some])
        light[:, some] += seen * way.weight[some] * tint ** way.tints[some]
    return light


def agreeing(ways: Floats) -> Floats:
    """The sum (N, 8) of those of ways (T, N, 8) that go where the strongest one does, as bright as all.

    Where a face begins to be met, neighbouring cells' ways part; their mean is a way that no path takes.
    """
    length = np.linalg.norm(ways[..., :3], axis=-1)
    chief = np.take_along_axis(ways, length.argmax(axis=0)[None, :, None], axis=0)[0, :, :3]
    cosine = (ways[..., :3] * chief).sum(axis=-1)
    cosine /= np.maximum(length * np.linalg.norm(chief, axis=-1), 1e-12)
    kept = (ways * np.clip((cosine - _APART) / (_ALIKE - _APART), 0, 1)[..., None]).sum(axis=0)
    total = ways[..., 3].sum(axis=0)
    return cast(Floats, kept * (total / np.maximum(kept[:, 3], 1e-9))[:, None])


def in_frame(viewer: Floats, frame: Frame) -> Floats:
    """Bucket coordinates B (N, 2) of unit directions (N, 3) in frames of three vectors (N, 3) each."""
    local = np.stack([(viewer * axis).sum(axis=1) for axis in frame], axis=1)
    local[:, 2] = np.maximum(local[:, 2], 0)
    return direction_to_square(local / np.maximum(np.linalg.norm(local, axis=1, keepdims=True), 1e-9))


def square_taps(square: Floats, n: int) -> tuple[Ints, Floats]:
    """The four cells, by flat index q n + p, around bucket coordinates B (..., 2), and weights: (4, ...)."""
    place = np.clip((square + 1) / 2 * n - 0.5, 0, n - 1)
    corner = np.minimum(np.floor(place), n - 2).astype(np.intp)
    x, y = np.moveaxis(place - corner, -1, 0)
    first = corner[..., 1] * n + corner[..., 0]
    cells = np.stack([first, first + 1, first + n, first + n + 1])
    weights = np.stack([(1 - x) * (1 - y), x * (1 - y), (1 - x) * y, x * y])
    return cells, weights.astype(np.float32)


def shown_of(around: Around, ways: Floats, offset: Floats, frame: Frame) -> Floats:
    """What ways (N, 8), filtered, show of the surroundings from offsets (N, 3) in frames: (3, N).

    Where those that were filtered disagree, the surroundings are blurred by as much.
    """
    weight = np.maximum(ways[:, 3], 1e-6)
    length = np.linalg.norm(ways[:, :3], axis=1)
    apart = np.maximum(1 - length / weight - _EVEN, 0)
    variance = np.maximum(ways[:, 7] / weight + apart, 0).astype(np.float32)
    away = ways[:, :3] / np.maximum(length, 1e-9)[:, None]
    from_here = ways[:, 4:7] / weight[:, None]
    axes = np.stack(frame, axis=1)  # (N, axis, component)
    direction, moved = (np.einsum("na,nac->nc", local, axes) for local in (away, from_here))
    return cast(Floats, around.look(offset + moved, direction, variance) * ways[:, 3])
