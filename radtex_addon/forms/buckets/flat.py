# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The flat lightmap of an image of buckets: their means."""

from __future__ import annotations

import numpy as np

from ...core.arrays import Floats
from ...core.atlas import AtlasLayout
from ...core.surface import SurfaceMesh
from ...core.texel_map import covered_texels
from ...formats.bucket_files import open_buckets
from ...formats.containers.exr_rows import ImageRows
from ...formats.sidecar import Sidecar
from ...formats.sidecar_file import SidecarFile
from ...textures.flat_lightmap import check_means, mean_of_buckets

_ALPHA = 3  # its channel
_OPAQUE = 0.999  # alpha: means of half floats may be slightly below 1


def flat_buckets(sidecar: SidecarFile, surface: SurfaceMesh, used: slice) -> Floats:
    """The mean (H, W, C) of the `used` channels of each bucket of an atlas, float32, row 0 at v = 0.

    One channel becomes grey, (H, W, 3). Raises FormatError for files that cannot be read, and if the
    atlas is of another surface.
    """
    image, facts = open_buckets(sidecar)
    light = _means(image, facts, used)
    check_means(sidecar.path, covered_texels(surface, facts.width, facts.height), light)
    return light


def light_channels(sidecar: SidecarFile) -> slice:
    """RGB, and alpha if any cell is transparent: light is premultiplied by it."""
    image, _ = open_buckets(sidecar)
    clear = image.channels > _ALPHA and any((rows[..., _ALPHA] < _OPAQUE).any() for _, rows in image.bands())
    return slice(_ALPHA + 1 if clear else _ALPHA)


def _means(image: ImageRows, facts: Sidecar, used: slice) -> Floats:
    means = []
    for _, band in image.bands(facts.bucket):
        some = AtlasLayout(facts.width, len(band) // facts.bucket, facts.bucket)
        means.append(mean_of_buckets(band[..., used], some))
    return np.concatenate(means)
