# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Ten thousand lookups of a bake in the shared layout."""

from __future__ import annotations

import numpy as np

from radtex_addon.core.arrays import Floats
from radtex_addon.core.frame import normalised
from radtex_addon.core.shared import SharedAtlas, sample_shared
from tests.lookups import COUNT, Lookups


def random_fragments(width: int, height: int, seed: int = 3) -> Lookups:
    """Fragments anywhere and at every edge: texel seams, atlas border, axes and folds of the octahedron.

    Every tenth viewer may stand behind its surface. Without tangents, which this layout does not know.
    """
    rng = np.random.default_rng(seed)
    size = np.array([width, height])
    uv = rng.uniform(0, 1, (COUNT, 2))
    uv[:500] = (rng.integers(0, size + 1, (500, 2)) + rng.uniform(-2e-3, 2e-3, (500, 2))) / size
    viewer, normal = (normalised(rng.normal(size=(COUNT, 3))) for _ in range(2))
    viewer[600:1000, 2] = rng.uniform(-1e-3, 1e-3, 400)  # where the octahedron folds
    viewer[1000:1200] = rng.permuted([[0, 0, 1], [0, -1, 0]] * 100, axis=1)  # its corners
    viewer[1200:1300, 0] = 0
    normal[1100:1300] = normalised(viewer[1100:1300])
    facing = np.sum(normal * viewer, axis=1, keepdims=True)
    viewer = np.where((facing < 0) & (rng.random((COUNT, 1)) < 0.9), -viewer, viewer)
    stretched = [v * rng.uniform(0.3, 3, (COUNT, 1)) for v in (normal, viewer)]
    unused = np.zeros((COUNT, 3)), np.zeros(COUNT)
    return Lookups(*(a.astype(np.float32) for a in (uv, stretched[0], *unused, stretched[1])))


def shared_answers(atlas: SharedAtlas, lookups: Lookups) -> Floats:
    """What the reference sampler sees, (K, 3)."""
    normal, viewer = (normalised(vectors.astype(float)) for vectors in (lookups.normal, lookups.viewer))
    return sample_shared(atlas, lookups.uv.astype(float), normal, viewer)
