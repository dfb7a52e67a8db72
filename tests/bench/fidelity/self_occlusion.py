# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Ambient occlusion of an object by itself, and what it means for reflections."""

from __future__ import annotations

from typing import cast

import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from radtex_addon.bake.plan import CapturePlan
from radtex_addon.core.arrays import Floats

RAYS = 32  # of a texel
_START = 1e-3  # of the object's size: how far from its surface rays start


def ambient_visibility(plan: CapturePlan, corners: Floats) -> Floats:
    """The share (K, 1) of the cosine-weighted hemisphere above each of the plan's texels that is open.

    Nothing blocks but the triangles (F, 3, 3), in world space.
    """
    tree = cast(
        BVHTree,
        BVHTree.FromPolygons(
            corners.reshape(-1, 3).tolist(),
            np.arange(3 * len(corners)).reshape(-1, 3).tolist(),
            all_triangles=True,
        ),
    )
    count = len(plan.texel)
    tangent, bitangent, normal = (
        axis.reshape(-1, 3)[:count] for axis in (plan.tangent, plan.bitangent, plan.normal)
    )
    facet = plan.facet.reshape(-1, 3)[:count]
    size = float(np.linalg.norm(np.ptp(plan.points, axis=0)))
    starts = [Vector(place) for place in (plan.points + _START * size * facet).tolist()]
    turns = np.random.default_rng(0).random(count) * 2 * np.pi
    radius = np.sqrt((np.arange(RAYS) + 0.5) / RAYS)  # Malley's method: even on the disc, then lifted
    open_rays, above = np.zeros(count), np.zeros(count)
    for number, across in enumerate(radius.tolist()):
        azimuth = turns + number * np.pi * (3 - np.sqrt(5))
        away = (
            across * (np.cos(azimuth)[:, None] * tangent + np.sin(azimuth)[:, None] * bitangent)
            + np.sqrt(1 - across**2) * normal
        )
        possible = np.sum(away * facet, axis=1) > 0
        met = (
            tree.ray_cast(start, direction)[0] for start, direction in zip(starts, away.tolist(), strict=True)
        )
        free = np.fromiter((place is None for place in met), bool, count)
        open_rays += free & possible
        above += possible
    share: Floats = (open_rays / np.maximum(above, 1))[:, None].astype(np.float32)
    return share


def specular_visibility(visibility: Floats, cosine: Floats, roughness: Floats, frontal: Floats) -> Floats:
    """By how much reflections are dimmed, (K, 3), where so much of the hemisphere is open (K,).

    Lagarde and de Rousiers, "Moving Frostbite to Physically Based Rendering" (2014); what the object mirrors
    of itself is put back by its colour `frontal` (K, 3): Jimenez et al., "Practical Real-Time Strategies for
    Accurate Indirect Occlusion" (2016).
    """
    sharpness = np.exp2(-16 * roughness**2 - 1)
    dimmed = np.clip((cosine + visibility) ** sharpness - 1 + visibility, 0, 1)[:, None]
    a, b, c = 2.0404 * frontal - 0.3324, -4.7951 * frontal + 0.6417, 2.7552 * frontal + 0.6903
    found: Floats = np.maximum(dimmed, ((dimmed * a + b) * dimmed + c) * dimmed)
    return found
