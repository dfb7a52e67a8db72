# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A lightmap of spherical harmonics: nine colours a texel, or 16, tell how its light changes with the viewer.

Engines keep in such maps the light that falls in; here they hold, better for a mirror, what leaves towards
the viewer, in the texel's own frame. The diffuse light's mean is kept apart, as its colour, four times as
fine, times the light that falls in; the harmonics are fitted to all else, up to white: the glare of a lamp or
window would ring through the harmonics all over the hemisphere. What
they make negative is shown as black.
"""

from __future__ import annotations

import numpy as np

from radtex_addon.core.hemisphere import square_to_direction
from radtex_addon.core.sampler import bilinear
from radtex_addon.report.gbuffer import Array, GBuffer
from radtex_addon.settings.spec import BakeSpec

from ..captured import Captured, OfCapture
from ..directional import fitted_equations, harmonics, solve_with_ridge
from ..lightmaps import diffuse_map, means, sample_weights, texture_bytes, up_to_white
from ..method import Baked

_RIDGE = 0.03  # a third of a harmonic's mean square


def of_capture(captured: Captured, bands: int = 2) -> Baked:
    """The lightmap of a captured stage, of harmonics up to band 2 or 3; its seconds left at 0.

    Its bytes are those of an image in BC6H for each, and of the diffuse light's textures.
    """
    light, count = captured.capture.light, (bands + 1) ** 2
    weight = sample_weights(light)
    diffuse = diffuse_map(captured.capture, weight, captured.alpha is not None)
    shown = light.diffuse.astype(np.float32) - means(weight, light.diffuse)[:, None]
    shown += up_to_white(light.mirrored.astype(np.float32) + light.through)
    direction = square_to_direction(light.square[:])
    equations = fitted_equations(light.plan, direction, shown, weight, lambda d: harmonics(d, bands))
    del shown
    fitted = solve_with_ridge(equations, [0.0] + [_RIDGE] * (count - 1))
    image = light.plan.placed(fitted.reshape(-1, count * 3), gutter=True)

    def radiance(buffer: GBuffer) -> Array:
        uv = buffer.uv[buffer.hit].astype(np.float32)
        towards = harmonics(buffer.incidence[buffer.hit].astype(np.float32), bands)
        coefficients = bilinear(image, uv).reshape(-1, count, 3)
        seen = diffuse.look(uv) + np.einsum("ka,kac->kc", towards, coefficients)
        return buffer.spread(np.maximum(seen, 0))

    return captured.baked(radiance, diffuse.bytes + count * texture_bytes(image))


def make(texels: int, samples: int) -> OfCapture:
    """The lightmap of nine spherical harmonics of a stage's single paths."""
    return OfCapture("sh", BakeSpec(texels=texels, samples=samples), of_capture)
