# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lightmaps made of light samples: means, and how textures are looked up."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radtex_addon.bake.blocks import in_blocks, planes
from radtex_addon.bake.light_samples import LightSamples
from radtex_addon.bake.plan import plan_of_some
from radtex_addon.core.arrays import Floats
from radtex_addon.core.colour_spaces import LUMINANCE
from radtex_addon.core.hemisphere import cell_solid_angles_sr, square_to_direction
from radtex_addon.core.sampler import bilinear
from radtex_addon.forms.layered.fit.diffuse import GRAZING

from .single_paths import SinglePaths

_BLACK = 1e-3  # a colour's channel that tells nothing of the light
BLOCK = 16  # bytes of a block of 4 x 4 texels, in BC6H (HDR) as in BC7


@dataclass(frozen=True, eq=False)
class DiffuseMap:
    """Diffuse light: its colour (H', W', 3), times the light that falls in, (H, W, 3), both float32, linear.

    The product is the mean of the diffuse radiance over the hemisphere of viewers, by solid angle.
    """

    colour: Floats
    irradiance: Floats

    def look(self, uv: Floats) -> Floats:
        """Diffuse radiance at texture coordinates (K, 2): (K, 3)."""
        light: Floats = bilinear(self.colour, uv) * bilinear(self.irradiance, uv)
        return light

    @property
    def bytes(self) -> int:
        """The colour in BC7, the light in BC6H; no mipmaps."""
        return texture_bytes(self.colour) + texture_bytes(self.irradiance)


def sample_weights(light: LightSamples) -> Floats:
    """Each sample's share of its texel's hemisphere, by solid angle, (K, S) float32; rows sum to 1.

    Samples that no viewer can see, and those that graze the surface, have none; where a texel has no other,
    all of its samples count alike.
    """
    angle = cell_solid_angles_sr(light.plan.layout.bucket).ravel()
    weight = np.empty(light.seen.shape, dtype=np.float32)

    def weigh(some: slice) -> None:
        cosine = square_to_direction(light.square[some])[..., 2]
        counted = np.where(light.seen[some] & (cosine > GRAZING), angle, 0)
        total = counted.sum(axis=1, keepdims=True)
        weight[some] = np.where(total > 0, counted / np.maximum(total, 1e-12), 1 / len(angle))

    in_blocks(weigh, *weight.shape)
    return weight


def means(weight: Floats, values: Floats) -> Floats:
    """Means (K, 3) float32 of samples (K, S, 3) by their weights (K, S)."""

    def mean(some: slice) -> Floats:
        found: Floats = (planes(values[some]) * weight[some]).sum(axis=2)
        return found

    return np.concatenate(in_blocks(mean, *weight.shape), axis=1).T


def up_to_white(values: Floats) -> Floats:
    """Linear colours (..., 3), those of a luminance above 1 dimmed to it."""
    limited: Floats = values / np.maximum(values @ LUMINANCE, 1)[..., None]
    return limited


def diffuse_map(capture: SinglePaths, weight: Floats, cut_out: bool = False) -> DiffuseMap:
    """The diffuse light of a capture, of samples that count by `weight` (K, S).

    The colour pass along the normal is lighter or darker than its mean over viewers, a coat being clearer
    from the front; the light makes up for that, by one factor a channel for all texels. Where alpha has
    `cut_out` texels, which are black, these have the light of the nearest others.
    """
    light = capture.light
    plan, diffuse = light.plan, means(weight, light.diffuse)
    finer = capture.colour.shape[0] // plan.layout.height
    height, width = plan.layout.height, plan.layout.width
    blocks = capture.colour.reshape(height, finer, width, finer, 3).mean(axis=(1, 3))
    frontal = blocks.reshape(-1, 3)[plan.texel].sum(axis=0)
    seen = light.colour.sum(axis=0)
    colour = light.colour * np.divide(frontal, seen, out=np.ones_like(seen), where=seen > 0)
    irradiance = np.divide(diffuse, colour, out=np.zeros_like(diffuse), where=colour > _BLACK)
    lit = (colour > _BLACK).any(axis=1)
    if cut_out and lit.any():
        plan, irradiance = plan_of_some(plan, lit), irradiance[lit]
    return DiffuseMap(capture.colour.astype(np.float32), plan.placed(irradiance, gutter=True))


def texture_bytes(image: Floats) -> int:
    """Bytes of an image (H, W, 3) as a GPU holds it compressed, a byte a texel; nothing for a constant."""
    height, width = image.shape[:2]
    return 0 if height == width == 1 else -(-height // 4) * -(-width // 4) * BLOCK
