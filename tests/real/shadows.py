# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What shaders must say of random bits: a light, a sun, a rectangle at each of `random_lookups`."""

from __future__ import annotations

import numpy as np

from radtex_addon.core.arrays import Floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.frame import normalised, orthonormal_frame, to_frame
from radtex_addon.core.sampler import Filter
from radtex_addon.core.shadow import pack_bits
from radtex_addon.formats.shadow_files import Words
from tests.lookups import Lookups
from tests.reference.shadows import (
    area_weights,
    cell_visibility,
    soft_visibility,
    square_points,
    sun_directions,
    sun_weight,
    visibility,
)

ONE, SUN, RECTANGLE = range(3)
POINTS = 12
ANGLE = 0.3
CORNER, ACROSS, UP = (-0.5, -0.4, 2.0), (1.0, 0.2, 0.0), (0.0, 0.3, 0.9)


def random_words(layout: AtlasLayout) -> Words:
    shape = (layout.height, layout.width, layout.bucket, layout.bucket)
    return pack_bits(np.random.default_rng(4).random(shape) < 0.5)


def expected(words: Words, layout: AtlasLayout, lookups: Lookups, mode: int, layers: bool) -> Floats:
    """The reference's answers, (K,), to the mode; with `layers` those of whole cells."""
    normal, tangent, sign, light, uv = (
        field.astype(float)
        for field in (lookups.normal, lookups.tangent, lookups.sign, lookups.viewer, lookups.uv)
    )
    frame = orthonormal_frame(normal, tangent, sign)
    kind = Filter.QUADRILINEAR
    if mode == ONE:
        return visibility(words, layout, uv, to_frame(normalised(light), *frame), kind)
    if mode == SUN:
        ways = sun_directions(normalised(light), ANGLE, POINTS)
        weight = np.maximum(np.einsum("ksx,kx->ks", ways, frame[2]), 0)
        scale = sun_weight(ANGLE)
    else:
        sides = np.cross(ACROSS, UP)
        scale = float(np.linalg.norm(sides))
        places = (np.array(list(square_points(POINTS))) + 1) / 2
        points = np.array(CORNER) + places @ np.array([ACROSS, UP])
        ways, weight = area_weights(light, frame[2], points, sides / scale)
    local = np.stack([to_frame(ways[:, k], *frame) for k in range(POINTS)], axis=1)
    if layers:
        share = cell_visibility(words, layout, uv, local, weight, kind)
    else:
        share = soft_visibility(words, layout, uv, local, weight)
    arrives: Floats = weight.mean(axis=1) * scale * share
    return arrives


def stacked(words: Words) -> Words:
    """Words (H, W, w) as layers (L, H, W, 2) of an array texture."""
    pairs = np.pad(words, ((0, 0), (0, 0), (0, words.shape[2] % 2)))
    return np.ascontiguousarray(pairs.reshape(*pairs.shape[:2], -1, 2).transpose(2, 0, 1, 3))


def check(found: Floats, wanted: Floats, mode: int, whole: bool, name: str) -> None:
    """Raise AssertionError where answers are not the reference's.

    Of whole cells, a light's point may lie so close to an edge that float32 falls beyond.
    """
    off = np.abs(found - wanted) / (1 + np.abs(wanted))
    across = float(np.mean(off > 5e-4))
    print(f"{name}, mode {mode}: worst of {len(off)} {off.max():.1e}, across {across:.2%}")
    assert across <= (1e-3 if whole and mode != ONE else 0)
    assert off.max() < 2 / POINTS
    assert wanted.std() > 0.02
