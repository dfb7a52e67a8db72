# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Diffuse light that changes with the viewer by more than the falloff: of skin, wax, jade.

Light that wanders below the surface comes from elsewhere for each viewer, as paths are refracted when they
enter. Nine spherical harmonics of the viewer's direction tell it, where they are worth more than their noise.
"""

from __future__ import annotations

import numpy as np

from ....bake.blocks import in_blocks
from ....bake.light_samples import LightSamples
from ....bake.plan import CapturePlan
from ....bake.pooling import Neighbours
from ....core.arrays import Bools, Floats
from ....core.hemisphere import square_to_direction
from ....core.octahedron import cell_directions
from ..lookup.falloffs import falloff_at
from .harmonics import basis, fit_harmonics
from .own_light import Surface

_RIDGE = 0.03  # as of the lightmap of spherical harmonics; with less, noise is told, too
_AT_ONCE = 1 << 13  # samples in hand, of nine numbers each
_SEED = 1


def view_dependence(
    light: LightSamples, facing: Floats, surface: Surface, cells: int, neighbours: Neighbours
) -> Floats | None:
    """What diffuse samples have beyond the surface's diffuse light: (3, K, cells * cells).

    By the mirror direction about the shading normals. `facing` (K, S): N.V of the samples that count,
    of others 0. None where harmonics of half of the samples do not predict the other half.
    """
    used = facing > 0
    direction = square_to_direction(light.square).astype(np.float32)

    def left(some: slice) -> Floats:
        cosine = np.maximum(direction[some][..., 2], 0)
        material = np.repeat(surface.material[some], cosine.shape[1])
        model = falloff_at(surface.falloff, material, cosine.ravel()).reshape(*cosine.shape, 3)
        rest: Floats = (light.diffuse[some] - surface.diffuse[some, None] * model).astype(np.float16)
        return rest

    values = np.concatenate(in_blocks(left, *used.shape))
    half = np.random.default_rng(_SEED).random(used.shape) < 0.5
    found = fit_harmonics(direction, values, _shares(used & half), neighbours, _RIDGE)
    if _gain(direction, values, used & ~half, found) <= 0:
        return None
    found = fit_harmonics(direction, values, _shares(used), neighbours, _RIDGE)
    return _by_mirror_direction(light.plan, found, surface.normal, cells)


def _shares(used: Bools) -> Floats:
    shares: Floats = (used / np.maximum(used.sum(axis=1, keepdims=True), 1)).astype(np.float32)
    return shares


def _gain(direction: Floats, values: Floats, used: Bools, found: Floats) -> float:
    """By how much coefficients (K, 9, 3) lessen the squares of values (K, S, 3) that are `used`."""

    def gain(some: slice) -> float:
        told = np.einsum("ksa,kac->ksc", basis(direction[some]), found[some], optimize=True)
        less = told * (2 * values[some].astype(np.float32) - told)
        return float(less[used[some]].sum(dtype=np.float64))

    texels, samples = used.shape
    gains: list[float] = in_blocks(gain, texels, samples, _AT_ONCE)
    return sum(gains)


def _by_mirror_direction(plan: CapturePlan, found: Floats, normal: Floats, cells: int) -> Floats:
    axis = cell_directions(cells).astype(np.float32)
    count = len(plan.texel)
    frame = [
        field.reshape(-1, 3)[:count].astype(np.float32)
        for field in (plan.tangent, plan.bitangent, plan.normal)
    ]

    def look(some: slice) -> Floats:
        about = normal[some]
        viewer = 2 * (axis @ about.T).T[..., None] * about[:, None] - axis
        local = np.stack([np.einsum("kmc,kc->km", viewer, one[some]) for one in frame], axis=-1)
        local[..., 2] = np.maximum(local[..., 2], 0)
        local /= np.maximum(np.linalg.norm(local, axis=-1, keepdims=True), 1e-6)
        told: Floats = np.einsum("kma,kac->ckm", basis(local), found[some], optimize=True)
        return told.astype(np.float32)

    by_cell: Floats = np.concatenate(in_blocks(look, count, len(axis)), axis=1)
    return by_cell
