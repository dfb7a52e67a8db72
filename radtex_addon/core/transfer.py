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

from collections.abc import Iterable

import numpy as np

from .arrays import Floats, Ints, as_floats
from .atlas import AtlasLayout
from .errors import ShapeError
from .hemisphere import direction_to_square
from .octahedron import cell_directions, direction_to_octahedron, octahedron_taps
from .sampler import checked_lookups, four_cells, four_texels


def with_views(layout: AtlasLayout, views: int) -> AtlasLayout:
    """The layout of the stored atlas, whose texels have `views` x `views` buckets each."""
    return AtlasLayout(layout.width * views, layout.height * views, layout.bucket)


def sample_transfer(
    image: Floats,
    layout: AtlasLayout,
    uv: Floats,
    light: Floats,
    viewer: Floats | None = None,
    views: int = 1,
) -> Floats:
    """Radiance at texture coordinates under a light of irradiance 1, bilinear in texels and in cells.

    `image` (H*k*n, W*k*n, C), k being `views`, row 0 at the bottom; `uv` (K, 2), clamped to the atlas's edge;
    `light` (K, 3) the directions to the light in the frame, of any length but zero. With several `views`,
    `viewer` (K, 3) are unit directions to the viewer in the frame, and the four views around each are
    blended. Returns (K, C), float32 or float64 as `uv` is. Raises ShapeError for shapes that do not fit.
    """
    uv, light = checked_lookups(uv, light)
    n, texels = layout.bucket, np.array([layout.width, layout.height], dtype=uv.dtype)
    stored = with_views(layout, views)
    buckets = stored.to_buckets(image).reshape(stored.height, stored.width, n * n, -1)
    taps = list(octahedron_taps(direction_to_octahedron(light), n))
    total = np.zeros((len(uv), image.shape[2]), dtype=uv.dtype)
    for view, view_weight in _views(uv, viewer, views):
        for texel, texel_weight in four_texels(uv * texels, texels):
            x, y = (texel * views + view).T
            for cell, cell_weight in taps:
                total += (view_weight * texel_weight * cell_weight)[:, None] * buckets[y, x, cell]
    return total


def _views(uv: Floats, viewer: Floats | None, views: int) -> list[tuple[Ints, Floats]]:
    """The views (K, 2) that lookups blend, with their weights (K,)."""
    if views == 1:
        return [(np.zeros((len(uv), 2), dtype=np.intp), np.ones(len(uv), dtype=uv.dtype))]
    if viewer is None:
        raise ShapeError(f"transfer atlas of {views} x {views} views: the viewer's directions are missing")
    _, viewer = checked_lookups(uv, viewer)
    return list(four_cells(direction_to_square(viewer), views))


def relight(
    image: Floats,
    layout: AtlasLayout,
    uv: Floats,
    lights: Iterable[tuple[Floats, Floats]],
    viewer: Floats | None = None,
    views: int = 1,
) -> Floats:
    """Radiance (K, 3) at texture coordinates (K, 2) under several lights, the rest as in `sample_transfer`.

    Each of the `lights` is a pair: directions (K, 3) to the light in the frame, and its irradiance on a plane
    facing it, (3,), or (K, 3) if it varies from point to point, as a point lamp's does.
    """
    total = np.zeros((len(uv), 3), dtype=as_floats("uv", uv, 2).dtype)
    for direction, irradiance in lights:
        total += sample_transfer(image, layout, uv, direction, viewer, views)[:, :3] * irradiance
    return total


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
