# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""One try of a relation: a random scene, bakes of it, and how far two bakes are from each other."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeAlias

import bpy
import numpy as np

from radtex_addon.core.arrays import Floats
from radtex_addon.formats.containers.exr import read_atlas
from radtex_addon.job import bake_object
from radtex_addon.settings.spec import BakeSpec
from tests.bench.metamorphic.scenes import BODY, build

SPEC = BakeSpec(texels=12, bucket=4, samples=8, half=False, uv_layer="UVMap")
BLOCK = 4  # texels along the side of a block whose mean is held against noise
SIGMAS = 8.0  # of noise, which two bakes tell roughly: 10 tries of other seeds came to 4.9, right ones to 7.1
ROUNDING = 2e-3  # of the light: what float32 alters where a scene stands elsewhere


@dataclass(frozen=True)
class Outcome:
    """How far a try was from its relation, and how far it may be, in the same unit."""

    deviation: float
    allowed: float

    @property
    def holds(self) -> bool:
        """Whether it did; a deviation that is no number did not."""
        return self.deviation <= self.allowed


class Trial:
    """A random scene, and what it takes to bake it; `seed` alone decides what it is."""

    def __init__(self, seed: int) -> None:
        self.rng = np.random.default_rng(seed)
        self.body: Any = build(self.rng)

    @property
    def scene(self) -> Any:
        """The scene that is open."""
        return bpy.context.scene

    def bake(self, name: str = BODY, scene: Any = None, **wishes: Any) -> Floats:
        """Buckets (H, W, n, n, 4) float32 of a bake by SPEC, but for the wishes."""
        view_layer = wishes.pop("view_layer", None)
        spec = replace(SPEC, **wishes)
        with tempfile.TemporaryDirectory() as folder:
            result = bake_object(scene or self.scene, name, spec, Path(folder) / "out", view_layer=view_layer)
            pixels, _ = read_atlas(result.files.atlas)
            return result.layout.to_buckets(pixels.astype(np.float32)).copy()

    def noisy(self, **wishes: Any) -> tuple[Floats, Floats]:
        """Two bakes of the same, with different noise."""
        return self.bake(seed=1, **wishes), self.bake(seed=2, **wishes)


Relation: TypeAlias = Callable[[Trial], Outcome | None]  # None where the scene is none for it


def same_bits(first: Floats, second: Floats) -> Outcome:
    """The largest difference, which must be 0."""
    if first.shape != second.shape:
        return Outcome(float("inf"), 0)
    return Outcome(float(np.abs(first.astype(float) - second.astype(float)).max()), 0)


def nearly(first: Floats, second: Floats, allowed: float = 1e-4) -> Outcome:
    """The mean difference as a share of the mean: for what has the same noise."""
    scale = max(float(np.abs(first[..., :3]).mean()), 1e-6)
    return Outcome(float(np.abs(first - second)[..., :3].mean()) / scale, allowed)


def same_light(noisy: tuple[Floats, Floats], other: Floats, rounding: float = ROUNDING) -> Outcome:
    """By how many sigmas of noise the means of blocks of texels, or of all, differ at worst.

    Two bakes of the same tell how much noise there is. Values are tone mapped by x / (1 + x), which keeps
    equal distributions equal and fireflies from ruling the means.
    """
    if noisy[0].shape != other.shape:
        return Outcome(float("inf"), SIGMAS)
    first, second, third = (_texels(buckets) for buckets in (*noisy, other))
    noise = (first - second) / np.sqrt(2)
    overall = noise.var()
    middle = (first + second) / 2
    worst = 0.0
    whole = slice(0, len(first)), slice(0, first.shape[1])
    for part in (whole, *_blocks(first.shape)):
        apart = abs(float((third - middle)[part].mean()))
        count = noise[part].size / 3  # colours go together
        variance = (0.5 * float(np.mean(noise[part] ** 2)) + 0.5 * overall) * 1.5 / count
        floor = rounding * float(middle[part].mean()) + 1e-5
        worst = max(worst, max(apart - floor, 0) / float(np.sqrt(variance) + 1e-7))
    return Outcome(worst, SIGMAS)


def _texels(buckets: Floats) -> Floats:
    """Mean tone mapped light of texels, (H, W, 3) float64."""
    light = np.maximum(buckets[..., :3].astype(np.float64), 0)
    texels: Floats = (light / (1 + light)).mean(axis=(2, 3))
    return texels


def _blocks(shape: tuple[int, ...]) -> list[tuple[slice, slice]]:
    rows, columns = (range(0, side, BLOCK) for side in shape[:2])
    return [(slice(row, row + BLOCK), slice(column, column + BLOCK)) for row in rows for column in columns]
