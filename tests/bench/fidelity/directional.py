# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Functions of direction fitted to what each texel shows: spherical harmonics, and spherical Gaussians.

Equations are those of least squares, (K, A, A + 3) float32, of A functions and three colours, for each of the
K texels.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from radtex_addon.bake.blocks import in_blocks
from radtex_addon.bake.plan import CapturePlan
from radtex_addon.bake.pooling import Neighbours
from radtex_addon.core.arrays import Floats
from radtex_addon.forms.layered.fit.view_dependence import basis, pooled

_TINY = 1e-9  # for texels without samples
_AT_ONCE = 1 << 14  # samples in hand
_SWEEPS = 200  # of the non-negative fit; lobes that overlap take tens

Functions = Callable[[Floats], Floats]  # unit directions (..., 3) in the texel's frame -> (..., A)


def harmonics(direction: Floats, bands: int) -> Floats:
    """The real spherical harmonics up to band 2 or 3 of unit directions (..., 3): (..., 9 or 16).

    Sloan, "Stupid Spherical Harmonics (SH) Tricks" (2008), appendix A2.
    """
    first = basis(direction)
    if bands == 2:
        return first
    x, y, z = np.moveaxis(direction, -1, 0)
    third = [
        0.590044 * y * (3 * x * x - y * y),
        2.890611 * x * y * z,
        0.457046 * y * (5 * z * z - 1),
        0.373176 * z * (5 * z * z - 3),
        0.457046 * x * (5 * z * z - 1),
        1.445306 * z * (x * x - y * y),
        0.590044 * x * (x * x - 3 * y * y),
    ]
    return np.concatenate([first, np.stack(third, axis=-1)], axis=-1)


def lobe_axes(count: int) -> Floats:
    """Axes of lobes spread evenly over the hemisphere, by a spiral: (count, 3) float32."""
    z = 1 - (np.arange(count) + 0.5) / count
    turn = np.arange(count) * np.pi * (3 - np.sqrt(5))
    across = np.sqrt(1 - z * z)
    return np.stack([across * np.cos(turn), across * np.sin(turn), z], axis=1).astype(np.float32)


def gaussians(direction: Floats, axes: Floats, sharpness: float) -> Floats:
    """Spherical Gaussians exp(s (axis . direction - 1)), for axes (A, 3): unit (..., 3) -> (..., A).

    Wang et al., "All-Frequency Rendering of Dynamic, Spatially-Varying Reflectance" (2009).
    """
    found: Floats = np.exp(np.float32(sharpness) * (direction @ axes.T - 1))
    return found


def fitted_equations(
    plan: CapturePlan, direction: Floats, values: Floats, weight: Floats, functions: Functions
) -> Floats:
    """The equations of samples (K, S, 3) in directions (K, S, 3), pooled with the neighbours' of each texel.

    `weight` (K, S) sums to 1 for each texel.
    """

    def sums(some: slice) -> Floats:
        columns = functions(direction[some].astype(np.float32))
        weighted = (columns * weight[some][..., None]).swapaxes(1, 2)
        both = np.concatenate([columns, values[some].astype(np.float32)], axis=2)
        found: Floats = np.matmul(weighted, both)
        return found

    texels, samples = weight.shape
    table = np.concatenate(in_blocks(sums, texels, samples, _AT_ONCE))
    return pooled(Neighbours(plan), table.reshape(len(table), -1)).reshape(table.shape)


def solve_with_ridge(equations: Floats, ridge: Sequence[float]) -> Floats:
    """Coefficients (K, A, 3) float32; a function's square costs its `ridge`, beside a mean square error."""
    count = len(ridge)
    penalty = np.diag(np.maximum(ridge, _TINY))

    def solve(some: slice) -> Floats:
        table = equations[some].astype(np.float64)
        found: Floats = np.linalg.solve(table[..., :count] + penalty, table[..., count:])
        return found.astype(np.float32)

    return np.concatenate(in_blocks(solve, len(equations), 1, _AT_ONCE))


def solve_non_negative(equations: Floats, ridge: float) -> Floats:
    """The same, no coefficient below 0: by coordinate descent, which converges for a convex problem."""
    count = equations.shape[1]

    def solve(some: slice) -> Floats:
        against = equations[some, :, :count].astype(np.float64) + np.eye(count) * max(ridge, _TINY)
        towards = equations[some, :, count:].astype(np.float64)
        found: Floats = np.zeros_like(towards)
        for _ in range(_SWEEPS):
            for one in range(count):
                left = towards[:, one] - np.einsum("kb,kbc->kc", against[:, one], found)
                found[:, one] = np.maximum(found[:, one] + left / against[:, one, one, None], 0)
        return found.astype(np.float32)

    return np.concatenate(in_blocks(solve, len(equations), 1, 1 << 11))
