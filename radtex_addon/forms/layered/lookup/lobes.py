# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A material's lobes and falloffs by N.V, as they are looked up; and what a lobe sees past the object.

Kept is a picture of what the object leaves free, blurred by its cells and by buckets that are pooled. A sharp
lobe needs a sharper edge: where the edge is straight, blurring a half-space by a lobe of another width
changes F(d / s) into F(d / t), where F(x) = 1/2 + x / (2 sqrt(2 + x²)).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import numpy as np

from ....core.arrays import Floats, Ints

_KEPT = 5.0  # the blur of the kept mask, pooled over buckets, times its cells along a side, radians
_EDGE = 0.04  # the sharpest edge that is shown, radians: cells do not tell where it is any better
_LEAST_WEIGHT = 1e-9
LOWEST = 0.01  # the sine above the surface of the lowest mirror direction, as in Cycles
LOBES = 2
STEPS = 16  # of N.V


def falloff_at(falloff: Floats, material: Ints, cosine: Floats) -> Floats:
    """The falloffs (M, B, 3) of materials (N,) at N.V (N,), linear between their points: (N, 3)."""
    count = falloff.shape[1]
    own = np.minimum(material, len(falloff) - 1)
    place = np.clip(cosine * count - 0.5, 0, count - 1)
    low = np.minimum(place.astype(np.intp), count - 2)
    part = (place - low)[:, None].astype(falloff.dtype)
    return cast(Floats, falloff[own, low] * (1 - part) + falloff[own, low + 1] * part)


@dataclass(frozen=True, eq=False)
class Material:
    """One material's lobes at N.V = (k + 0.5) / STEPS: `weight` (LOBES, STEPS, 3), `variance` (LOBES, STEPS).

    `bend` (STEPS,): by how much their axis leaves the mirror direction for the normal, radians.
    """

    weight: Floats
    variance: Floats
    bend: Floats

    def at(self, cosine: Floats) -> tuple[Floats, Floats, Floats]:
        """Weights (LOBES, 3, N), variances (LOBES, N) and bends (N,) at N.V (N,)."""
        place = np.clip(cosine * STEPS - 0.5, 0, STEPS - 1)
        low = np.minimum(place.astype(np.intp), STEPS - 2)
        above = (place - low).astype(np.float32)

        def between(table: Floats) -> Floats:
            return cast(Floats, table.take(low, axis=-1) * (1 - above) + table.take(low + 1, axis=-1) * above)

        weight = between(np.moveaxis(self.weight, 2, 1))
        return weight, np.exp(between(np.log(self.variance))), between(self.bend)

    def mean_variance(self, cosine: Floats) -> Floats:
        """The mean of both lobes' variances, by weight, at N.V (N,): (N,)."""
        weight, variance, _ = self.at(cosine)
        bright = weight.sum(axis=1) + _LEAST_WEIGHT
        return cast(Floats, (bright * variance).sum(axis=0) / bright.sum(axis=0))


def lobe(squared: Floats, variance: Floats) -> Floats:
    """The lobe of a width² at squared chords from its axis, per steradian.

    GGX (Walter et al., 2007) mirrored at normal incidence, with a width² of 2 a² / (1 - a²): in the plane it
    is Student's distribution with two degrees of freedom.
    """
    return (1 + variance / 2) / (2 * np.pi * variance) / (1 + squared / (2 * variance)) ** 2


def lifted(axis: Floats, face: Floats) -> Floats:
    """Mirror directions (3, ...) about shading normals that turn them below the surface, raised onto it.

    `face` (3, ...): the mesh's normals. Cycles turns such shading normals until what is mirrored is above the
    surface (`ensure_valid_specular_reflection`); float32.
    """
    raised = axis + np.maximum(LOWEST - (axis * face).sum(axis=0), 0) * face
    raised /= np.sqrt((raised * raised).sum(axis=0))
    return cast(Floats, raised.astype(np.float32, copy=False))


def bent(axis: Floats, normal: Floats, bend: Floats) -> Floats:
    """Axes (N, 3) turned by so many radians (N,) towards the normal."""
    aside = towards(axis, normal)
    return cast(Floats, (axis.T * np.cos(bend) + aside.T * np.sin(bend)).astype(np.float32).T)


def towards(axis: Floats, normal: Floats) -> Floats:
    """Unit vectors (N, 3) across the axes, in their plane with the normal."""
    axis, normal = axis.T, normal.T
    towards = normal - (normal * axis).sum(axis=0) * axis
    return cast(Floats, (towards / np.maximum(np.linalg.norm(towards, axis=0), 1e-6)).T)


def seen_free(kept: Floats, variance: Floats, cells: int) -> Floats:
    """The kept mask (N,) as a lobe of widths² (N,) sees it: (N,)."""
    sharper = np.maximum(_KEPT / cells / np.sqrt(variance + _EDGE**2), 1)
    place = np.clip(2 * kept - 1, -1, 1) * sharper
    return cast(
        Floats, (0.5 + 0.5 * place / np.sqrt(1 - (place / sharper) ** 2 + place**2)).astype(np.float32)
    )
