# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A lightmap of spherical harmonics: nine colours a texel tell how its light changes with the viewer.

Engines keep in such maps the light that falls in; here they hold, better for a mirror, what leaves towards
the viewer, in the texel's own frame. The diffuse light's mean is kept apart, as its colour, four times as
fine, times the light that falls in; the harmonics are fitted to all else, up to white: the glare of a lamp or
window would ring through nine harmonics all over the hemisphere.
"""

from __future__ import annotations

from pathlib import Path
from time import perf_counter

import numpy as np

from radtex_addon.bake.spec import BakeSpec
from radtex_addon.core.bilinear import bilinear
from radtex_addon.core.hemisphere import square_to_direction
from radtex_addon.forms.layered.fit.bucket_grid import BucketGrid
from radtex_addon.forms.layered.fit.harmonics import COUNT, basis, fit_harmonics
from radtex_addon.report.gbuffer import Array, GBuffer

from ..captured import capture_stage
from ..lightmaps import diffuse_map, means, sample_weights, texture_bytes, up_to_white
from ..method import Baked
from ..scenes import Stage

_RIDGE = 0.03  # a third of a harmonic's mean square


class HarmonicsLightmap:
    """Bakes and looks up; `bytes` are those of nine images in BC6H, and of the diffuse light's textures."""

    name = "sh"

    def __init__(self, spec: BakeSpec) -> None:
        self.spec = spec

    def bake(self, stage: Stage, folder: Path) -> Baked:
        started = perf_counter()
        captured = capture_stage(stage, self.spec, folder)
        light = captured.capture.light
        weight = sample_weights(light)
        diffuse = diffuse_map(captured.capture, weight, captured.alpha is not None)
        shown = light.diffuse.astype(np.float32) - means(weight, light.diffuse)[:, None]
        shown += up_to_white(light.mirrored.astype(np.float32) + light.through)
        fitted = fit_harmonics(
            square_to_direction(light.square[:]), shown, weight, BucketGrid.of(light.plan, 1), _RIDGE
        )
        del shown
        image = light.plan.placed(fitted.reshape(-1, COUNT * 3), gutter=True)

        def radiance(buffer: GBuffer) -> Array:
            uv = buffer.uv[buffer.hit].astype(np.float32)
            towards = basis(buffer.incidence[buffer.hit].astype(np.float32))
            coefficients = bilinear(image, uv).reshape(-1, COUNT, 3)
            seen = diffuse.look(uv) + np.einsum("ka,kac->kc", towards, coefficients)
            return buffer.spread(np.maximum(seen, 0))

        return Baked(
            paths=captured.paths,
            seconds=perf_counter() - started,
            bytes=diffuse.bytes + COUNT * texture_bytes(image) + captured.alpha_bytes,
            radiance=radiance,
            mesh=captured.prepared.mesh,
            matrix_world=captured.matrix_world,
            uv_layer=captured.prepared.uv_layer,
            alpha=captured.look_alpha,
        )


def make(texels: int, samples: int) -> HarmonicsLightmap:
    """The lightmap of spherical harmonics of a stage's single paths."""
    return HarmonicsLightmap(BakeSpec(texels=texels, samples=samples))
