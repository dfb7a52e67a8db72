# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The flat lightmap: one mean colour per texel, for viewers that do not support radiance textures.

Each texel's radiance is averaged over the solid angle of the hemisphere above it.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..core.arrays import Bools, Floats
from ..core.atlas import AtlasLayout
from ..core.errors import FormatError
from ..core.gutter import LEAST_AGREEMENT, gutter_agreement
from ..core.hemisphere import cell_solid_angles_sr, equisolid_inverse
from ..core.messages import Setting, do
from ..formats.codecs.srgb import to_srgb
from ..formats.containers.exr import loss_of, stored_compression
from ..formats.containers.png import encode_png

_ROUNDED = 1e-4  # by how much the means of equal buckets may differ
_LEAST_ALPHA = 1 / 512  # eight bits round smaller values to 0
_GOLDEN = np.pi * (3 - np.sqrt(5))
_BRIGHT = 99.5  # percent of the texels that the picture shows unclipped


def mean_of_buckets(pixels: Floats, layout: AtlasLayout) -> Floats:
    """The mean (H, W, C), float32, of an atlas (H*n, W*n, C), each cell weighted by its solid angle.

    One channel is repeated to grey, (H, W, 3).
    """
    weight = (cell_solid_angles_sr(layout.bucket) / (2 * np.pi)).astype(np.float32)
    buckets = layout.to_buckets(pixels)
    rows = (np.einsum("wqpc,qp->wc", row.astype(np.float32), weight) for row in buckets)
    light: Floats = np.stack(list(rows))
    return np.broadcast_to(light, (*light.shape[:2], 3)) if light.shape[2] == 1 else light


def check_stored(sidecar: Path, covered: Bools, *stored: Floats) -> None:
    """`check_surface` with means of buckets (H, W, C), some of their cells (H, W, G, C), or both."""
    loss = max(loss_of(stored_compression(sidecar.with_suffix(".exr"))), _ROUNDED)
    check_surface(sidecar, covered, loss, *stored)


def check_surface(sidecar: Path, covered: Bools, loss: float, *stored: Floats) -> None:
    """Raise FormatError if the atlas's gutter is not that of a surface's `covered` texels.

    Not in any of the images that are `stored`: cells keep copies where each has its own gutter, which means
    lose, and means where compression is lossy.
    """
    if max(gutter_agreement(covered, one, loss) for one in stored) < LEAST_AGREEMENT:
        raise FormatError(
            f"the preview beside {sidecar} is of another bake",
            do("bake it again with a preview", Setting.SAVE_PREVIEW),
        )


def even_directions(count: int) -> Floats:
    """Directions (count, 3) in the frame, each for the same solid angle, in a spiral as a sunflower's seeds.

    The equisolid projection preserves areas: points spread evenly on the disc are so on the hemisphere.
    """
    index = np.arange(count)
    radius, angle = np.sqrt((index + 0.5) / count), index * _GOLDEN
    return equisolid_inverse(np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1))


def flat_png(light: Floats) -> tuple[bytes, float]:
    """An sRGB PNG of light (H, W, 3 or 4), row 0 at v = 0, and the factor by which the light was multiplied.

    The factor is 1 unless more than a few texels are brighter than white. Light with alpha is premultiplied;
    the PNG's colours are not, as PNG and glTF require.
    """
    colour, alpha = light[..., :3], np.clip(light[..., 3:], 0, 1)
    if alpha.size:
        colour = np.divide(colour, alpha, out=np.zeros_like(colour), where=alpha > _LEAST_ALPHA)
    brightest = float(np.percentile(colour.max(axis=2), _BRIGHT))
    scale = 1 / brightest if brightest > 1 else 1.0
    return encode_png(np.concatenate([to_srgb(colour * scale), alpha], axis=2)[::-1]), scale
