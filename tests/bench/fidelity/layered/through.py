# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The lobe of light that comes through the object, in the shared layout: where paths end, and what is left.

Shift, spread and gain come from paths in a scene where all else glows evenly, so that no light's noise is in
them; the rest is fitted as the mirrored light's is.
"""

from __future__ import annotations

import numpy as np

from radtex_addon.bake import fit as shared_fit
from radtex_addon.bake.blocks import in_blocks
from radtex_addon.bake.ends import fit_ends
from radtex_addon.bake.gloss import LobeSamples, fit_gain
from radtex_addon.bake.light_samples import EndSamples, LightSamples, SurroundingsSamples
from radtex_addon.bake.pooling import Neighbours, Taps, upsampled
from radtex_addon.bake.progress import finished
from radtex_addon.bake.surroundings import Surroundings
from radtex_addon.core.arrays import Bools, Floats
from radtex_addon.core.shared import Axis, SharedAtlas

from .residual import fit_rest

_SIZE = 256  # cells along a side of the picture that light comes through from
_CELLS, _REST_CELLS = 16, 8  # along the sides of buckets
_FAINT = 1e-3  # of all light: what comes through and is less is left out


def lets_through(alone: EndSamples, light: LightSamples) -> bool:
    """Whether enough light comes through the object to be fitted."""
    through = light.through.sum(dtype=np.float64)
    total = through + light.mirrored.sum(dtype=np.float64) + light.diffuse.sum(dtype=np.float64)
    return bool(through > _FAINT * total and alone.through_weight.any())


def fit_through(
    light: LightSamples,
    ends: EndSamples,
    surroundings: SurroundingsSamples,
    used: Bools,
    neighbours: Neighbours,
) -> SharedAtlas:
    """Fit the lobe to light and to paths' ends in the surroundings; `used` (K, S): samples that count."""
    plan = light.plan
    picture = Surroundings.of(surroundings, _SIZE)
    fit = shared_fit._LobeFit(light, ends, used, picture, neighbours, _CELLS)
    white, single = fit._white(Axis.THROUGH)
    paths = fit._traced(white)
    start = np.zeros((3, len(plan.texel), _CELLS**2), dtype=np.float32)
    found = finished(fit_ends(paths, neighbours, _CELLS, start))
    gain = fit_gain(paths.place, white, single, neighbours, _CELLS)
    samples = LobeSamples(plan, Axis.THROUGH, light.square, light.through, used)
    place, shown = _shown(samples, found, gain, picture)
    rest = upsampled(fit_rest(place, light.through, used, shown, neighbours, _REST_CELLS), _CELLS)
    return SharedAtlas(
        colour=np.zeros((1, 1, 3), dtype=np.float32),
        irradiance=np.zeros((plan.layout.height, plan.layout.width, 3), dtype=np.float32),
        falloff=np.ones((2, 3), dtype=np.float32),
        surroundings=picture.levels,
        sharpest=picture.sharpest,
        lobes=(shared_fit._placed(plan, Axis.THROUGH, [found, gain, rest]),),
    )


def _shown(samples: LobeSamples, ends: Floats, gain: Floats, picture: Surroundings) -> tuple[Floats, Floats]:
    """The samples' places on the octahedron (2, K, S), and what they show of the picture (3, K, S)."""
    shape = samples.used.shape
    place, shown = (np.empty((count, *shape), dtype=np.float32) for count in (2, 3))

    def look(some: slice) -> None:
        axis, place[:, some] = samples.along(some)
        taps = Taps.of(place[:, some], _CELLS)
        there = taps.gather(ends[:, some])
        met = picture.look((axis + there[:3]).reshape(3, -1).T, there[3].ravel())
        shown[:, some] = taps.gather(gain[:, some]) * met.T.reshape(axis.shape)

    in_blocks(look, shape[0], shape[1])
    return place, shown
