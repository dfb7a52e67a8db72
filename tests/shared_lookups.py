# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Ten thousand lookups of a bake in the shared layout."""

from __future__ import annotations

import re

import numpy as np

from radtex_addon.core.arrays import Floats
from radtex_addon.core.frame import normalised
from radtex_addon.core.shared import SharedAtlas, sample_shared
from tests.lookups import COUNT, Lookups
from tests.reference.hits import sample_shared_hit


def random_fragments(width: int, height: int, seed: int = 3) -> Lookups:
    """Fragments anywhere, at texel seams, beyond the atlas's edges, and where the octahedron folds.

    Every tenth viewer may stand behind its surface. Without tangents, which this layout does not know.
    """
    rng = np.random.default_rng(seed)
    size = np.array([width, height])
    uv = rng.uniform(-0.05, 1.05, (COUNT, 2))
    uv[:500] = (rng.integers(0, size + 1, (500, 2)) + rng.uniform(-2e-3, 2e-3, (500, 2))) / size
    normal, viewer = normalised(rng.normal(size=(2, COUNT, 3)))
    corners = np.concatenate([np.eye(3), -np.eye(3)])[rng.integers(0, 6, 1000)]
    viewer[600:1600] = corners + rng.normal(size=(1000, 3)) * rng.choice([0, 1e-3], (1000, 1))
    edge = (np.arange(1600, 2600), rng.integers(0, 3, 1000))
    viewer[edge] *= rng.choice([0, 1e-4], 1000)
    normal[1100:2100] = viewer[1100:2100]  # so that the mirror looks there, too
    behind = np.sum(normal * viewer, axis=1, keepdims=True) < 0
    viewer = np.where(behind & (np.arange(COUNT) % 10 > 0)[:, None], -viewer, viewer)
    stretched = [normalised(v) * rng.uniform(0.3, 3, (COUNT, 1)) for v in (normal, viewer)]
    unused = np.zeros((COUNT, 3)), np.zeros(COUNT)
    return Lookups(*(a.astype(np.float32) for a in (uv, stretched[0], *unused, stretched[1])))


def shared_answers(atlas: SharedAtlas, lookups: Lookups) -> Floats:
    """What the reference sampler sees, (K, 3)."""
    normal, viewer = (normalised(vectors.astype(float)) for vectors in (lookups.normal, lookups.viewer))
    return sample_shared(atlas, lookups.uv.astype(float), normal, viewer)


def by_ray(lookup: str) -> str:
    """A shader's `radtex_shared(..., N, V)` or `radtex_condensed(..., N, V)`, by the ray from the viewer."""
    return re.sub(r"radtex_(shared|condensed)\(", r"radtex_\1_hit(", lookup).replace("N, V)", "N, -V)")


def shared_hit_answers(atlas: SharedAtlas, lookups: Lookups) -> Floats:
    """What the reference finds by rays from where the viewers are, (K, 3)."""
    normal, viewer = (normalised(vectors.astype(float)) for vectors in (lookups.normal, lookups.viewer))
    return sample_shared_hit(atlas, lookups.uv.astype(float), normal, -viewer)
