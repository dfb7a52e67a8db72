# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A lightmap of spherical Gaussians: nine lobes a texel tell how its light changes with the viewer.

Neubelt and Pettineo, "Advanced Lighting R&D at Ready At Dawn Studios" (2015), for The Order: 1886, which
keeps the light that falls in, in lobes of fixed axes and sharpness. Here, as in the lightmap of harmonics,
the lobes hold what leaves towards the viewer, in the texel's own frame: as many bytes as nine harmonics.
Amplitudes are fitted by least squares, none below 0, so nothing rings; the sharpness is one for the object:
that one of a few whose fit to half of the samples comes nearest to the other half. The diffuse light's mean
is kept apart.
"""

from __future__ import annotations

import numpy as np

from radtex_addon.bake.plan import CapturePlan
from radtex_addon.core.arrays import Floats
from radtex_addon.core.hemisphere import square_to_direction
from radtex_addon.core.sampler import bilinear
from radtex_addon.report.gbuffer import Array, GBuffer
from radtex_addon.settings.spec import BakeSpec

from ..captured import Captured, OfCapture
from ..directional import fitted_equations, gaussians, lobe_axes, solve_non_negative
from ..lightmaps import diffuse_map, sample_weights, texture_bytes, up_to_white
from ..method import Baked

LOBES = 9
SHARPNESS = (2.0, 4.0, 8.0, 16.0)  # lobes of 8 overlap by half with their neighbours
_RIDGE = 1e-3  # about a hundredth of a lobe's mean square
_AXES = lobe_axes(LOBES)


def of_capture(captured: Captured) -> Baked:
    """The lightmap of a captured stage, its seconds left at 0.

    Its bytes are those of nine images in BC6H, and of the diffuse light's textures.
    """
    light = captured.capture.light
    weight = sample_weights(light)
    diffuse = diffuse_map(captured.capture, weight, captured.alpha is not None)
    shown = up_to_white(light.mirrored.astype(np.float32) + light.through)
    direction = square_to_direction(light.square[:]).astype(np.float32)
    sharpness, fitted = fit_gaussians(light.plan, direction, shown, weight)
    del shown
    image = light.plan.placed(fitted.reshape(-1, LOBES * 3), gutter=True)

    def radiance(buffer: GBuffer) -> Array:
        uv = buffer.uv[buffer.hit].astype(np.float32)
        towards = gaussians(buffer.incidence[buffer.hit].astype(np.float32), _AXES, sharpness)
        amplitudes = bilinear(image, uv).reshape(-1, LOBES, 3)
        return buffer.spread(diffuse.look(uv) + np.einsum("ka,kac->kc", towards, amplitudes))

    return captured.baked(radiance, diffuse.bytes + LOBES * texture_bytes(image))


def fit_gaussians(
    plan: CapturePlan, direction: Floats, values: Floats, weight: Floats
) -> tuple[float, Floats]:
    """The best sharpness, and with it the amplitudes (K, LOBES, 3), of samples (K, S, 3)."""
    halves = [slice(first, None, 2) for first in (0, 1)]

    def fit(sharpness: float, some: slice = slice(None)) -> Floats:
        share = weight[:, some]
        share = share / np.maximum(share.sum(axis=1, keepdims=True), 1e-12)
        equations = fitted_equations(
            plan, direction[:, some], values[:, some], share, lambda d: gaussians(d, _AXES, sharpness)
        )
        return solve_non_negative(equations, _RIDGE)

    def error(sharpness: float) -> float:
        """How far the fit to the first half of the samples is from the second."""
        known, other = halves
        found = fit(sharpness, known)
        total = 0.0
        for begin in range(0, len(found), 256):
            some = slice(begin, begin + 256)
            told = gaussians(direction[some, other], _AXES, sharpness) @ found[some]
            apart = ((told - values[some, other]) ** 2).sum(axis=2)
            total += float((apart * weight[some, other]).sum())
        return total

    best = min(SHARPNESS, key=error)
    return best, fit(best)


def make(texels: int, samples: int) -> OfCapture:
    """The lightmap of spherical Gaussians of a stage's single paths."""
    return OfCapture("sg", BakeSpec(texels=texels, samples=samples), of_capture)
