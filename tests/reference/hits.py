# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Radiance for rays that hit a baked surface, looked up in its atlas instead of traced further.

A ray gets the radiance that a viewer at its origin would see. At grazing angles an interpolated normal may
point away from a ray that hits the facet's front: such a ray gets the value at the horizon. A ray that meets
a facet's back does not count as a hit; rays from outside a closed object never do that.
"""

from __future__ import annotations

from radtex_addon.core.arrays import Floats, as_floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.errors import ShapeError
from radtex_addon.core.frame import normalised, orthonormal_frame, to_frame
from radtex_addon.core.sampler import Filter, sample


def sample_hit(
    image: Floats,
    layout: AtlasLayout,
    uv: Floats,
    ray: Floats,
    normal: Floats,
    tangent: Floats,
    sign: Floats,
    kind: Filter,
) -> Floats:
    """Radiance for rays at their hit points on the surface, (K, C).

    `image`, `uv` (K, 2) and `kind` as in `sampler.sample`. `ray` points towards the surface; `ray`, `normal`
    and `tangent` (K, 3) are in the same space, of any length but zero. `sign` (K,) is the bitangent's, as in
    `frame.orthonormal_frame`. Raises ShapeError for shapes that do not fit.
    """
    ray = as_floats("ray", ray, 3)
    if ray.shape != normal.shape:
        raise ShapeError(f"ray: expected shape {normal.shape}, as the normals have, got {ray.shape}")
    frame = orthonormal_frame(normal, tangent, sign)
    return sample(image, layout, uv, to_frame(-normalised(ray), *frame), kind)
