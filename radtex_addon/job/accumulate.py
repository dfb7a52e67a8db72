# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Folding more samples into an atlas that is there."""

from __future__ import annotations

from dataclasses import dataclass, replace

from ..core.arrays import Floats
from ..core.errors import InputError
from ..formats.exr import read_buckets
from ..formats.sidecar import Sidecar
from .files import OutputFiles


@dataclass(frozen=True, eq=False)
class Earlier:
    """An earlier bake: its atlas (H*n, W*n, 4) and its sidecar."""

    pixels: Floats
    sidecar: Sidecar

    @property
    def samples(self) -> int:
        """For each cell."""
        return self.sidecar.samples

    def with_more(self, pixels: Floats, bake: Sidecar) -> tuple[Floats, Sidecar]:
        """The mean over both bakes' samples, float32, and what is to be said of it."""
        both = self.samples + bake.samples
        mean: Floats = pixels * (bake.samples / both) + self.pixels * (self.samples / both)
        return mean.astype("float32"), replace(bake, samples=both)


def read_earlier(files: OutputFiles, bake: Sidecar) -> Earlier:
    """The atlas that `files` name, as one that `bake` may be folded into.

    Raises InputError where it is of another mesh, size or capture, FormatError as `exr.read_buckets` does.
    """
    pixels, earlier = read_buckets(files.sidecar)
    differs = _difference(earlier, bake)
    if differs is None and pixels.shape[2] != 4:
        differs = f"has {pixels.shape[2]} channels, not 4"
    if differs is not None:
        raise InputError(f"{files.atlas} {differs}: accumulate onto an atlas of its own, or bake anew")
    return Earlier(pixels, earlier)


def _difference(earlier: Sidecar, bake: Sidecar) -> str | None:  # noqa: PLR0911 (a line for each reason)
    if not earlier.mesh:
        return "does not say of which mesh it is, as bakes of older RadTexes do not"
    sizes = [(one.width, one.height, one.bucket) for one in (earlier, bake)]
    if sizes[0] != sizes[1]:
        told = ["{} x {} texels of {} cells".format(*size) for size in sizes]
        return f"has {told[0]}, this bake {told[1]}"
    if earlier.mesh != bake.mesh:
        return "is of another mesh, or of the same unwrapped otherwise"
    if earlier.source != bake.source:
        return "shows what another object does, or was looked for at another distance"
    if earlier.layers:
        return "has layers, which are not accumulated"
    if earlier.capture != bake.capture:
        return f"was captured by {earlier.capture}, not by {bake.capture}"
    return None
