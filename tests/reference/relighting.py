# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lookups in a bake of kind `transfer`."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from radtex_addon.core.arrays import Floats, Ints, as_floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.errors import ShapeError
from radtex_addon.core.hemisphere import direction_to_square
from radtex_addon.core.octahedron import direction_to_octahedron, octahedron_taps
from radtex_addon.core.sampler import checked_lookups, four_cells, four_texels
from radtex_addon.formats.transfer_files import with_views


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
