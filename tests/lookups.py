# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Ten thousand lookups of a random atlas, and how a shader's answers are held against the reference."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from radtex_addon.core import hemisphere as hs
from radtex_addon.core.arrays import Bools, Floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.frame import normalised, orthonormal_frame, to_frame
from radtex_addon.core.sampler import Filter, sample
from tests.reference.hits import sample_hit

SIDE = 100  # the lookups fill a square picture
COUNT = SIDE * SIDE
LAYOUT = AtlasLayout(13, 7, 6)  # nothing is a power of two, and the atlas is not square
NEAR = 1e-4  # of a texel or a cell: so close to an edge float32 may fall on either side


@dataclass(frozen=True)
class Lookups:
    """float32: `uv` (K, 2); `normal`, `tangent`, `viewer` (K, 3) of any length in one space; `sign` (K,)."""

    uv: Floats
    normal: Floats
    tangent: Floats
    sign: Floats
    viewer: Floats

    @property
    def incidence(self) -> Floats:
        """The viewer's directions in the reference's frames, (K, 3) float64."""
        exact = [a.astype(float) for a in (self.normal, self.tangent, self.sign)]
        return to_frame(normalised(self.viewer.astype(float)), *orthonormal_frame(*exact))


def random_atlas(seed: int = 1) -> Floats:
    """An atlas of LAYOUT, (H*n, W*n, 4) float16, row 0 at the bottom: every cell another colour and alpha."""
    rng = np.random.default_rng(seed)
    image = np.exp(rng.uniform(np.log(0.05), np.log(20), (LAYOUT.pixel_height, LAYOUT.pixel_width, 4)))
    image[..., 3] = rng.uniform(0.05, 1, image.shape[:2])
    return image.astype(np.float16)


def constant_buckets(seed: int = 2) -> Floats:
    """An atlas whose buckets each hold one colour, all different."""
    colours = np.random.default_rng(seed).integers(1, 80, (LAYOUT.height, LAYOUT.width, 1, 1, 4)) / 8
    return LAYOUT.from_buckets(np.broadcast_to(colours, (LAYOUT.height, LAYOUT.width, 6, 6, 4))).astype(
        np.float16
    )


def random_lookups(seed: int = 3) -> Lookups:
    """Lookups anywhere and at every edge: seams, atlas border, pole, rim, horizon, fallback tangents."""
    rng = np.random.default_rng(seed)
    uv = rng.uniform(0, 1, (COUNT, 2))
    size = np.array([LAYOUT.width, LAYOUT.height])
    uv[:500] = (
        rng.integers(0, size + 1, (500, 2)) + rng.uniform(-2e-3, 2e-3, (500, 2))
    ) / size  # seams, border
    uv[500:600] = (rng.integers(0, size, (100, 2)) + 0.5) / size
    incidence = normalised(rng.normal(size=(COUNT, 3)))
    incidence[:, 2] = np.abs(incidence[:, 2])
    incidence[1000:1010] = [0, 0, 1]  # where four cells meet
    incidence[1100:1600, 2] = rng.uniform(-1e-3, 1e-3, 500)  # the rim, from both sides
    incidence[1600:2000, 2] *= -0.9  # below the horizon
    incidence = normalised(incidence)
    normal = normalised(rng.normal(size=(COUNT, 3)))
    tangent = normalised(rng.normal(size=(COUNT, 3)))
    parallel = slice(2000, 2500)
    tangent[parallel] = normal[parallel]
    normal[2500:2600], tangent[2500:2600] = [0, 0, -1], [0, 0, 0]
    sign = np.where(rng.random(COUNT) < 0.5, -1.0, 1.0)
    t, bt, n = orthonormal_frame(normal, tangent, sign)
    viewer = incidence[:, :1] * t + incidence[:, 1:2] * bt + incidence[:, 2:] * n
    stretched = [v * rng.uniform(0.3, 3, (COUNT, 1)) for v in (normal, tangent, viewer)]
    return Lookups(*(a.astype(np.float32) for a in (uv, *stretched[:2], sign, stretched[2])))


def hit_answers(atlas: Floats, lookups: Lookups) -> Floats:
    """What the reference finds by rays from where the viewers are, quadrilinear, (K, C)."""
    ray, normal, tangent, sign = (
        a.astype(float) for a in (-lookups.viewer, lookups.normal, lookups.tangent, lookups.sign)
    )
    uv = lookups.uv.astype(float)
    return sample_hit(atlas.astype(float), LAYOUT, uv, ray, normal, tangent, sign, Filter.QUADRILINEAR)


def worst_error(result: Floats, atlas: Floats, lookups: Lookups, kind: Filter) -> tuple[float, float]:
    """The worst relative error of `result` (K, C) and the share of lookups that fell across an edge nearby.

    Only a lookup within NEAR of an edge between texels or cells may do so, and must then be right beyond it.
    """
    atlas, uv, incidence = (
        atlas[..., : result.shape[1]].astype(float),
        lookups.uv.astype(float),
        lookups.incidence,
    )
    error = relative_error(result, sample(atlas, LAYOUT, uv, incidence, kind))
    across = np.flatnonzero((error > 1e-3) & _near_an_edge(uv, incidence, kind))
    error[across] = _error_beyond(result[across], atlas, uv[across], incidence[across], kind)
    return float(error.max()), len(across) / len(error)


def relative_error(result: Floats, expected: Floats) -> Floats:
    """The largest error of each row's channels, relative to what was expected."""
    error: Floats = np.max(np.abs(result - expected) / np.abs(expected), axis=-1)
    return error


def _near_an_edge(uv: Floats, incidence: Floats, kind: Filter) -> Bools:
    places = np.full((len(uv), 4), 0.5)
    if kind is not Filter.QUADRILINEAR:
        places[:, :2] = uv * [LAYOUT.width, LAYOUT.height]
    if kind is Filter.NEAREST:
        places[:, 2:] = (hs.direction_to_square(incidence) + 1) / 2 * LAYOUT.bucket
    near: Bools = np.any(np.abs(places - np.round(places)) < NEAR, axis=1)
    return near


def _error_beyond(result: Floats, atlas: Floats, uv: Floats, incidence: Floats, kind: Filter) -> Floats:
    """The smallest error against the reference a little to every side."""
    b, errors = hs.direction_to_square(incidence), [np.full(len(uv), np.inf)]
    for step in product((-2 * NEAR, 0, 2 * NEAR), repeat=4):
        moved_uv = uv + np.array(step[:2]) / [LAYOUT.width, LAYOUT.height]
        moved_b = np.clip(b + np.array(step[2:]) * 2 / LAYOUT.bucket, -1, 1)
        beyond = sample(atlas, LAYOUT, moved_uv, hs.square_to_direction(moved_b), kind)
        errors.append(relative_error(result, beyond))
    smallest: Floats = np.min(errors, axis=0)
    return smallest


def squared_steps(normal: Floats, there: Bools, side: int) -> Floats:
    """|dFdx N|² + |dFdy N|² as a GPU takes them, in blocks of 2 x 2 pixels: (N,) of normals (N, 3) in rows.

    The picture has `side` pixels a side; where one of two is not `there` (N,), it counts as no step.
    """
    grid, known = normal.reshape(side, side, 3), there.reshape(side, side)
    total = np.zeros((side, side))
    for axis in (0, 1):
        first, second = (np.arange(start, side, 2) for start in (0, 1))
        step = ((grid.take(second, axis) - grid.take(first, axis)) ** 2).sum(axis=2)
        step *= known.take(first, axis) & known.take(second, axis)
        total += step.repeat(2, axis)
    return total.ravel()
