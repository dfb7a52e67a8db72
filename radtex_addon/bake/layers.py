# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Layers: parts of the light, each stored as an atlas of its own beside the whole."""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum

import numpy as np

from ..core.arrays import Floats
from ..core.atlas import AtlasLayout
from ..core.hemisphere import cell_solid_angles_sr

WHOLE = 4  # channels of the atlas itself, RGBA; its layers' follow
OF_LAYER = 3  # channels of each layer: RGB, or X, Y, Z


class Layer(StrEnum):
    """A light pass; base and rest, which add up to the whole; or the normals of what is seen."""

    DIFFUSE = "diffuse"
    GLOSSY = "glossy"
    TRANSMISSION = "transmission"
    VOLUME = "volume"
    EMISSION = "emission"
    ENVIRONMENT = "environment"
    NORMAL = "normal"
    BASE = "base"
    REST = "rest"


LIGHT = (
    Layer.DIFFUSE,
    Layer.GLOSSY,
    Layer.TRANSMISSION,
    Layer.VOLUME,
    Layer.EMISSION,
    Layer.ENVIRONMENT,
)  # add up to the whole


def captured(layers: Sequence[Layer]) -> tuple[Layer, ...]:
    """The layers that Cycles has to render for `layers`, in the order of their channels."""
    wanted = set(layers)
    if wanted & {Layer.BASE, Layer.REST}:
        wanted.add(Layer.DIFFUSE)
    return tuple(layer for layer in Layer if layer in wanted - {Layer.BASE, Layer.REST})


def split_layers(image: Floats, layout: AtlasLayout, layers: Sequence[Layer]) -> dict[str, Floats]:
    """Split an atlas image (H*n, W*n, 4 + 3 per captured layer) into its layers, in the order of `layers`.

    Each is (H*n, W*n, 3), row 0 at the bottom; but the base is (H, W, 3), one value per texel: the mean of
    its diffuse light over the hemisphere, rounded to half floats as in files. Base and rest add up to the
    image's first three channels.
    """
    found = {
        layer: image[..., WHOLE + OF_LAYER * place : WHOLE + OF_LAYER * (place + 1)]
        for place, layer in enumerate(captured(layers))
    }
    if {Layer.BASE, Layer.REST} & set(layers):
        base = _mean_over_hemisphere(layout.to_buckets(found[Layer.DIFFUSE]))
        found[Layer.BASE] = base.astype(np.float16).astype(np.float32)
        n = layout.bucket
        found[Layer.REST] = image[..., :3] - found[Layer.BASE].repeat(n, axis=0).repeat(n, axis=1)
    return {layer: found[layer] for layer in layers}


def _mean_over_hemisphere(buckets: Floats) -> Floats:
    """The mean of each bucket of (H, W, n, n, C), weighted by solid angle: (H, W, C)."""
    weights = cell_solid_angles_sr(buckets.shape[2])
    mean: Floats = np.einsum("jiqpc,qp->jic", buckets, weights / weights.sum())
    return mean
