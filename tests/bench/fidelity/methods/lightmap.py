# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A flat lightmap, as engines have had it for decades: what a texel shows on the mean, to all viewers alike.

Diffuse light is kept as its colour, four times as fine, times the light that falls in; the mean over the
hemisphere of all else that the texel shows, reflections among it, is a second light map. Of this a sample
counts as white at most, as bakers limit it, else the glare of a lamp, seen from one side, would be all
over; and it is blurred a little against noise, as bakers denoise it.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from time import perf_counter

import numpy as np

from radtex_addon.bake.pooling import Neighbours
from radtex_addon.bake.spec import BakeSpec
from radtex_addon.core.bilinear import bilinear
from radtex_addon.forms.layered.fit.harmonics import pooled
from radtex_addon.report.gbuffer import Array, GBuffer

from ..captured import Captured, capture_stage
from ..lightmaps import diffuse_map, means, sample_weights, texture_bytes, up_to_white
from ..method import Baked
from ..scenes import Stage


class Lightmap:
    """Bakes and looks up; `bytes` are those of BC7 for the colour and of BC6H for light."""

    name = "lightmap"

    def __init__(self, spec: BakeSpec) -> None:
        self.spec = spec

    def bake(self, stage: Stage, folder: Path) -> Baked:
        started = perf_counter()
        captured = capture_stage(stage, self.spec, folder)
        return replace(of_capture(captured), seconds=perf_counter() - started)


def of_capture(captured: Captured) -> Baked:
    """The lightmap of a captured stage, its seconds left at 0."""
    light = captured.capture.light
    weight = sample_weights(light)
    diffuse = diffuse_map(captured.capture, weight, captured.alpha is not None)
    other = means(weight, up_to_white(light.mirrored.astype(np.float32) + light.through))
    rest = light.plan.placed(pooled(Neighbours(light.plan), other), gutter=True)

    def radiance(buffer: GBuffer) -> Array:
        uv = buffer.uv[buffer.hit].astype(np.float32)
        return buffer.spread(diffuse.look(uv) + bilinear(rest, uv))

    return captured.baked(radiance, diffuse.bytes + texture_bytes(rest))


def make(texels: int, samples: int) -> Lightmap:
    """The flat lightmap of a stage's single paths."""
    return Lightmap(BakeSpec(texels=texels, samples=samples))
