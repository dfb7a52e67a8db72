# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Load the existing atlas for --accumulate and --refresh."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ...core.arrays import Floats, Ints
from ...core.errors import InputError
from ...core.near_digest import is_same
from ...formats.bucket_files import count_text, read_counts
from ...formats.containers.exr import read_buckets
from ...formats.sidecar import Sidecar
from ...settings.options import MARKED


@dataclass(frozen=True, eq=False)
class PreviousAtlas:
    """An earlier bake: its atlas (H*n, W*n, 4) float32, each texel's samples per cell, (H, W).

    `denoised`: whether its cells are.
    """

    pixels: Floats
    counts: Ints
    denoised: bool = False


def read_earlier(sidecar: Path, bake: Sidecar) -> PreviousAtlas:
    """Read the atlas beside a `sidecar`, for a `bake` that adds samples to it or refreshes it.

    Raises InputError if it is of another mesh, size or capture, FormatError as `exr.read_buckets` does.
    """
    pixels, earlier = read_buckets(sidecar)
    differs = difference(earlier, bake)
    if differs is None and pixels.shape[2] != 4:
        differs = f"has {pixels.shape[2]} channels, not 4"
    if differs is not None:
        atlas = sidecar.with_suffix(".exr")
        raise InputError(f"{atlas} {differs}: accumulate onto an atlas of its own, or bake anew")
    counts: Ints = np.full((earlier.height, earlier.width), earlier.samples, dtype=np.int64)
    if earlier.texel_samples:
        counts = read_counts(earlier.texel_samples, earlier.width, earlier.height, str(sidecar))
    return PreviousAtlas(pixels.astype(np.float32), counts, earlier.denoised)


def with_counts(bake: Sidecar, counts: Ints) -> Sidecar:
    """The sidecar with each texel's samples per cell, `counts` (H, W); its `samples` is the smallest."""
    return replace(bake, samples=int(counts.min()), texel_samples=count_text(counts))


def difference(earlier: Sidecar, bake: Sidecar) -> str | None:  # noqa: PLR0911 (a line for each reason)
    """Why samples of a `bake` cannot be added to an `earlier` one; None if they can."""
    if not earlier.mesh:
        return "does not say of which mesh it is, as bakes of older RadTexes do not"
    if earlier.objects != bake.objects:
        return "is of other objects, or names them in another order"
    sizes = [(one.width, one.height, one.bucket) for one in (earlier, bake)]
    if sizes[0] != sizes[1]:
        told = ["{} x {} texels of {} cells".format(*size) for size in sizes]
        return f"has {told[0]}, this bake {told[1]}"
    if not is_same(earlier.mesh, bake.mesh):
        return "is of another mesh, or of the same unwrapped otherwise"
    if earlier.source != bake.source:
        return "shows what another object does, or was looked for at another distance"
    if earlier.lights != bake.lights:
        return "is of other lamps"
    if other := [name for name in MARKED if (name in earlier.marks) != (name in bake.marks)]:
        return MARKED[other[0]].on if other[0] in earlier.marks else MARKED[other[0]].off
    if earlier.layers:
        return "has layers, which are not accumulated"
    if earlier.capture != bake.capture:
        return f"was captured by {earlier.capture}, not by {bake.capture}"
    return None
