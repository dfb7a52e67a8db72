# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A flat lightmap, as engines have had it for decades: what a texel shows on the mean, to all viewers alike.

Diffuse light is kept as its colour, four times as fine, times the light that falls in; the mean over the
hemisphere of all else that the texel shows, reflections among it, is a second light map. Of this a sample
counts as white at most, as bakers limit it, else the glare of a lamp, seen from one side, would be all
over; and it is blurred a little against noise, as bakers denoise it.
"""

from __future__ import annotations

import numpy as np

from radtex_addon.bake.pooling import Neighbours
from radtex_addon.core.sampler import bilinear
from radtex_addon.forms.layered.fit.view_dependence import pooled
from radtex_addon.report.gbuffer import Array, GBuffer
from radtex_addon.settings.spec import BakeSpec

from ..captured import Captured, OfCapture
from ..lightmaps import diffuse_map, means, sample_weights, texture_bytes, up_to_white
from ..method import Baked


def of_capture(captured: Captured) -> Baked:
    """The lightmap of a captured stage, its seconds left at 0.

    Its bytes are those of BC7 for the colour and of BC6H for light.
    """
    light = captured.capture.light
    weight = sample_weights(light)
    diffuse = diffuse_map(captured.capture, weight, captured.alpha is not None)
    other = means(weight, up_to_white(light.mirrored.astype(np.float32) + light.through))
    rest = light.plan.placed(pooled(Neighbours(light.plan), other), gutter=True)

    def radiance(buffer: GBuffer) -> Array:
        uv = buffer.uv[buffer.hit].astype(np.float32)
        return buffer.spread(diffuse.look(uv) + bilinear(rest, uv))

    return captured.baked(radiance, diffuse.bytes + texture_bytes(rest))


def make(texels: int, samples: int) -> OfCapture:
    """The flat lightmap of a stage's single paths."""
    return OfCapture("lightmap", BakeSpec(texels=texels, samples=samples), of_capture)
