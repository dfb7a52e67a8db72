# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays that end in an atlas: what a ray finds where it hits a baked surface, instead of being traced on.

The surface shows a ray what it would show a viewer where the ray comes from. At a slant a smooth normal turns
away from rays that do hit the front: these take the rim, the light that leaves at grazing angles. A ray that
meets a facet's back is no hit; of a closed object none does that comes from outside.
"""

from __future__ import annotations

import numpy as np

from .arrays import Floats, as_floats
from .atlas import AtlasLayout
from .errors import ShapeError
from .frame import normalised, orthonormal_frame, to_frame
from .sampler import Filter, sample
from .shared import SharedAtlas, sample_shared


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
    """Radiance that rays find where they hit the surface, (K, C).

    `image`, `uv` (K, 2) and `kind` as in `sampler.sample`. `ray`, which leads to the surface, `normal` and
    `tangent` (K, 3), in one space, of any length but zero, and `sign` (K,), the bitangent's, as in
    `frame.orthonormal_frame`. Raises ShapeError for shapes that do not fit.
    """
    ray = as_floats("ray", ray, 3)
    if ray.shape != normal.shape:
        raise ShapeError(f"ray: expected shape {normal.shape}, as the normals have, got {ray.shape}")
    frame = orthonormal_frame(normal, tangent, sign)
    return sample(image, layout, uv, to_frame(-normalised(ray), *frame), kind)


def sample_shared_hit(atlas: SharedAtlas, uv: Floats, normal: Floats, ray: Floats) -> Floats:
    """The same of the shared layout, (K, 3) float32: unit `normal` and unit `ray` (K, 3) in world space."""
    return sample_shared(atlas, uv, normal, hit_viewer(ray, normal))


def hit_viewer(ray: Floats, normal: Floats) -> Floats:
    """Unit directions to the viewers whose places rays take, on or above the horizon; all (K, 3), unit.

    A ray along the normal itself comes from no side, and gives what rounding makes of zero.
    """
    along = np.sum(as_floats("ray", ray, 3) * normal, axis=-1, keepdims=True)
    return normalised(np.maximum(along, 0) * normal - ray)
