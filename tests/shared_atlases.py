# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Random atlases in the shared layout, every value another one."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from radtex_addon.core.arrays import Floats
from radtex_addon.core.condensed import CondensedAtlas, CondensedLobe
from radtex_addon.core.shared import Axis, Lobe, SharedAtlas, level_sizes
from radtex_addon.formats.sidecar import Sidecar

SHARPEST = 2.5e-5  # radians²


def random_shared_atlas(
    width: int = 7,
    height: int = 5,
    bucket: int = 6,
    surroundings: int = 48,
    levels: int = 5,
    lobes: Iterable[Axis] = tuple(Axis),
    seed: int = 1,
) -> SharedAtlas:
    """Light from 0.05 to 20, shifts below 0.87, spreads from a twentieth of SHARPEST to 1.5 radians²."""
    rng = np.random.default_rng(seed)

    def light(*shape: int) -> Floats:
        return np.exp(rng.uniform(np.log(0.05), np.log(20), (*shape, 3))).astype(np.float32)

    def lobe(axis: Axis) -> Lobe:
        base = (height, width, bucket, bucket)
        spread = np.exp(rng.uniform(np.log(SHARPEST / 20), np.log(1.5), (*base, 1)))
        ends = np.concatenate([rng.uniform(-0.5, 0.5, (*base, 3)), spread], axis=-1).astype(np.float32)
        return Lobe(axis, ends, light(*base), light(*base))

    return SharedAtlas(
        colour=light(2 * height + 1, 3 * width),
        irradiance=light(height, width),
        falloff=rng.uniform(0.1, 1, (16, 3)).astype(np.float32),
        surroundings=tuple(light(size, size) for size in level_sizes(surroundings, levels)),
        sharpest=SHARPEST,
        lobes=tuple(lobe(axis) for axis in lobes),
    )


def random_condensed_atlas(
    width: int = 7,
    height: int = 5,
    clusters: int = 4,
    rank: int = 2,
    bucket: int = 14,
    seed: int = 1,
    **others: Any,
) -> CondensedAtlas:
    """As `random_shared_atlas`, which takes `others`; weights are whole 127ths.

    A texel's values are from half to one and a half times its cluster's first bucket.
    """
    rng = np.random.default_rng(seed)
    maps = random_shared_atlas(width, height, bucket=1, seed=seed, **others)
    firsts = random_shared_atlas(clusters, 1, bucket, seed=seed, **others)

    def tiles(part: Floats) -> Floats:
        first = np.moveaxis(part, 0, 1)
        ratios = rng.uniform(-0.5 / rank, 0.5 / rank, (clusters, rank, *first.shape[2:]))
        return np.concatenate([first, first * ratios.astype(np.float32)], axis=1)

    def lobe(first: Lobe) -> CondensedLobe:
        cluster = rng.integers(0, clusters, (height, width), dtype=np.int32)
        weights = rng.integers(-127, 128, (height, width, rank)) / np.float32(127)
        parts = (tiles(part) for part in (first.ends, first.gain, first.rest))
        return CondensedLobe(first.axis, cluster, weights.astype(np.float32), *parts)

    return CondensedAtlas(
        colour=maps.colour,
        irradiance=maps.irradiance,
        falloff=maps.falloff,
        surroundings=maps.surroundings,
        sharpest=maps.sharpest,
        lobes=tuple(lobe(first) for first in firsts.lobes),
    )


def facts_about(atlas: SharedAtlas | CondensedAtlas) -> Sidecar:
    """What a bake of the object "Vase" would say of `atlas`."""
    height, width = atlas.irradiance.shape[:2]
    bucket = atlas.lobes[0].ends.shape[2] if atlas.lobes else 1
    return Sidecar(
        "Vase", "radiance", width, height, bucket, "RadTex", 16, 0, "portal", "RadTex 0.1.0", "5.2.3"
    )
