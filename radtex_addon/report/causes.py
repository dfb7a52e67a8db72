# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Error by cause: the object is baked again with half of each thing that a bake spends, and judged again."""

from __future__ import annotations

import logging
import tempfile
from collections.abc import Generator, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from pathlib import Path

import bpy

from ..bake.spec import BakeSpec, Layout
from ..bake.stopwatch import Stopwatch
from ..core.errors import InputError
from ..job import OutputFiles
from ..job.run import bake_and_keep
from ..scene.scratch import new_data_removed
from .finished import Finished, read_bake
from .gbuffer import BakedSurface
from .judging import judge, mean_flip, mean_psnr
from .progress import Step, Task, steps_of
from .sizes import gpu_bytes
from .views import View

log = logging.getLogger(__name__)

_MATTERS = 0.2  # decibels: what costs less is no cause


class Cause(StrEnum):
    """What a bake may have too little of; the value is the specification's field."""

    SAMPLES = "samples"
    CELLS = "bucket"
    TEXELS = "texels"


_SHOWS = {
    Cause.SAMPLES: "noise: blotches that no light explains",
    Cause.CELLS: "directions: reflections are blurred, and step where they should glide",
    Cause.TEXELS: "surface: textures, shadows and edges of light are blurred",
}


@dataclass(frozen=True)
class Halving:
    """What the bake is with half of one thing; `lost` decibels are what the whole has more."""

    cause: Cause
    value: int
    psnr: float
    flip: float | None
    lost: float
    paths: int
    bytes: int

    @property
    def shows(self) -> str:
        """How too little of it looks."""
        return _SHOWS[self.cause]


def halve(
    scene: bpy.types.Scene, spec: BakeSpec, name: str, views: Sequence[View], whole: float
) -> Generator[Step, None, list[Halving]]:
    """Bake the object `name` with half of each thing and judge that; `whole` is the bake's own mean PSNR.

    `spec` is the bake's own. What cannot be halved is left out. Everything made meanwhile goes away.
    """
    found = []
    for cause in Cause:
        less = _half(spec, cause)
        if less is None:
            continue
        about = f"half the {'cells' if cause is Cause.CELLS else cause}"
        try:
            found.append((yield from _judge_again(scene, less, name, views, whole, cause, about)))
        except InputError as error:  # such as too few texels for the islands of an unwrap
            log.warning("%s cannot be baked: %s", about, error)
    return found


def _judge_again(
    scene: bpy.types.Scene,
    spec: BakeSpec,
    name: str,
    views: Sequence[View],
    whole: float,
    cause: Cause,
    about: str,
) -> Generator[Step, None, Halving]:
    with tempfile.TemporaryDirectory(prefix="radtex-") as folder, new_data_removed():
        files = OutputFiles.of(name, spec, Path(folder), preview=False)
        baked = yield from steps_of(bake_and_keep(scene, name, spec, files, None, Stopwatch()), about)
        prepared = baked.prepared
        surface = BakedSurface(prepared.mesh, prepared.matrix_world, prepared.uv_layer)
        yield Step(Task.COMPARE, 0, 1, about)
        bake = read_bake(baked.made.files.sidecar)
        judged = judge(bake, surface, views)
        size = gpu_bytes(bake)
    psnr = mean_psnr(judged)
    value = int(getattr(spec, cause))
    return Halving(cause, value, psnr, mean_flip(judged), whole - psnr, baked.made.paths, size)


def _half(spec: BakeSpec, cause: Cause) -> BakeSpec | None:
    """The same bake with half of something; None where there would be nothing left."""
    if cause is Cause.SAMPLES:
        return replace(spec, samples=spec.samples // 2) if spec.samples >= 2 else None
    if cause is Cause.CELLS:
        return replace(spec, bucket=spec.bucket // 2) if spec.bucket >= 4 else None
    return replace(spec, texels=spec.texels // 2) if spec.texels >= 2 else None


def first_change(bake: Finished, halvings: Sequence[Halving]) -> str:
    """What to change first, and what that costs, in a sentence or two."""
    worst = max(halvings, key=lambda halving: halving.lost, default=None)
    if worst is None:
        return "The bake is too small for any of its settings to be halved."
    if worst.lost < _MATTERS:
        return (
            f"No setting matters much here: halving any costs less than {_MATTERS} dB. What is left lies in "
            "the layout itself" + ("; try --layout shared." if bake.layout is Layout.BUCKETS else ".")
        )
    flag, now = f"--{worst.cause}", 2 * worst.value
    shows = worst.shows.partition(":")[0]
    if worst.cause is Cause.SAMPLES:
        price = "twice the paths, and no bytes"
    elif worst.cause is Cause.CELLS:
        paths = "no paths" if bake.layout is Layout.SHARED else "four times the paths"
        price = f"{paths}, and {_grown(gpu_bytes(bake, cells=2), bake)}"
    else:
        price = f"about four times the paths, and {_grown(gpu_bytes(bake, texels=2), bake)}"
    return (
        f"First give it more {flag}: half of them costs most, {worst.lost:.1f} dB ({shows}). "
        f"{flag} {2 * now} takes {price}."
    )


def _grown(larger: int, bake: Finished) -> str:
    return f"{larger / 1e6:.1f} MB on a GPU instead of {gpu_bytes(bake) / 1e6:.1f}"
