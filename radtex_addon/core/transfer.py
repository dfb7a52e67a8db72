# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The reference sampler of kind `transfer`: a texel's radiance under a light from any direction.

A bucket is an octahedral map (`core.octahedron`) of the directions to the light in the texel's frame: its
middle is the normal, its corners are the direction opposite to it. A cell holds the radiance that leaves the
texel under a directional light that gives an irradiance of 1 on a plane facing it. Light is linear: the
contributions of several lights add up.

A texel captured from k x k views has k x k buckets, and the atlas has W k x H k: the bucket of view (a, b) is
number (i k + a, j k + b). Views are arranged in a square like the cells of a bucket of radiance.
"""

from __future__ import annotations

import numpy as np

from .arrays import Floats
from .atlas import AtlasLayout
from .errors import ShapeError
from .octahedron import cell_directions, direction_to_octahedron, octahedron_taps


def with_views(layout: AtlasLayout, views: int) -> AtlasLayout:
    """The layout of the stored atlas, whose texels have `views` x `views` buckets each."""
    return AtlasLayout(layout.width * views, layout.height * views, layout.bucket)


def lookup_solid_angles_sr(size: int, finer: int = 16) -> Floats:
    """Weight of each cell of a map in the integral of bilinear lookups over the sphere: (size * size,).

    Computed from `finer` x `finer` directions for each cell. A direction's solid angle is proportional to
    1 / |p|^3, p being its point on |x| + |y| + |z| = 1. The sum is 4 pi.
    """
    direction = cell_directions(size * finer).astype(np.float64)
    share = np.abs(direction).sum(axis=-1) ** 3
    total = np.zeros(size * size)
    for cell, weight in octahedron_taps(direction_to_octahedron(direction), size):
        total += np.bincount(cell, weight * share, size * size)
    return total * (4 * np.pi / total.sum())


def mean_over_lights(image: Floats, layout: AtlasLayout, views: int = 1) -> Floats:
    """Radiance of texels under white surroundings of radiance 1: (H, W, C), float32, the mean of all views.

    A piece of sky of solid angle w gives an irradiance of w on a plane facing it. Raises ShapeError if the
    image does not fit the layout.
    """
    n, stored = layout.bucket, with_views(layout, views)
    if image.shape[:2] != (stored.pixel_height, stored.pixel_width):
        raise ShapeError(f"transfer atlas: expected {stored.pixel_height} x {stored.pixel_width} pixels")
    weight = lookup_solid_angles_sr(n).astype(np.float32).reshape(n, n)
    rows = (np.einsum("wqpc,qp->wc", row.astype(np.float32), weight) for row in stored.to_buckets(image))
    light = np.stack(list(rows)).reshape(layout.height, views, layout.width, views, -1)
    mean: Floats = light.mean(axis=(1, 3))
    return mean
