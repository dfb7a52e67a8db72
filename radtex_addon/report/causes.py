# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Error by cause: the object is baked again with half the samples, cells and texels, and judged each time."""

from __future__ import annotations

import logging
from collections.abc import Generator, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

import bpy

from ..bake.progress import Stopwatch
from ..core.errors import InputError
from ..formats.disk.temporary import temporary_folder
from ..job import OutputFiles
from ..job.baking import bake_unchecked
from ..scene.scratch import new_data_removed
from ..settings.spec import BakeSpec
from .finished_bake import Finished, read_bake
from .gbuffer import BakedSurface
from .judging import judge, mean_flip, mean_psnr
from .report_progress import ReportStep, ReportTask, steps_of
from .sizes import gpu_bytes
from .views import TracedView

log = logging.getLogger(__name__)

_MATTERS = 0.2  # decibels: the least loss that counts as a cause


class Cause(StrEnum):
    """What a bake may have too little of; the value is the specification's field."""

    SAMPLES = "samples"
    CELLS = "bucket"
    TEXELS = "texels"

    @property
    def word(self) -> str:
        """What a bake is given more of."""
        return "cells" if self is Cause.CELLS else str(self)


_SHOWS = {
    Cause.SAMPLES: "noise: blotches that no light explains",
    Cause.CELLS: "directions: reflections are blurred, and step where they should glide",
    Cause.TEXELS: "surface: textures, shadows and edges of light are blurred",
}
_ABOUT = {
    Cause.SAMPLES: "half the samples",
    Cause.CELLS: "half the cells",
    Cause.TEXELS: "half the texels",
}


@dataclass(frozen=True)
class HalvedBake:
    """The result of a bake with one setting halved; `lost` is by how many decibels its PSNR is lower.

    `value` is the halved setting.
    """

    cause: Cause
    value: int
    psnr: float
    flip: float | None
    lost: float
    paths: int
    bytes: int

    @property
    def name(self) -> str:
        """A description of the bake, such as "half of --texels: 64"."""
        return f"half of {self.cause.word}: {self.value}"

    @property
    def shows(self) -> str:
        """What too little of the setting looks like."""
        return _SHOWS[self.cause]


def bake_variants(
    scene: bpy.types.Scene, spec: BakeSpec, name: str, views: Sequence[TracedView], whole: float
) -> Generator[ReportStep, None, list[HalvedBake]]:
    """Bake the object `name` again for each cause, and judge each bake; `whole` is the bake's own mean PSNR.

    `spec` is the bake's own. Settings that cannot be halved are left out. All files and data of these bakes
    are deleted.
    """
    found = []
    for cause in Cause:
        other = _without(spec, cause)
        if other is None:
            continue
        try:
            found.append((yield from _judge_again(scene, other, name, views, whole, cause)))
        except InputError as error:  # such as too few texels for the islands of an unwrap
            log.warning("%s cannot be baked: %s", _ABOUT[cause], error)
    return found


def _judge_again(
    scene: bpy.types.Scene,
    spec: BakeSpec,
    name: str,
    views: Sequence[TracedView],
    whole: float,
    cause: Cause,
) -> Generator[ReportStep, None, HalvedBake]:
    about = _ABOUT[cause]
    with temporary_folder() as folder, new_data_removed():
        files = OutputFiles.of(name, spec, folder, preview=False)
        steps = bake_unchecked(scene, name, spec, files, None, Stopwatch(), warns=False)
        baked = yield from steps_of(steps, about)
        prepared = baked.prepared
        surface = BakedSurface(prepared.mesh, prepared.matrix_world, prepared.uv_layer)
        yield ReportStep(ReportTask.COMPARE, 0, 1, about)
        bake = read_bake(baked.made.files.sidecar)
        judged = judge(bake, surface, views)
        size = gpu_bytes(bake)
    psnr = mean_psnr(judged)
    flip, paths = mean_flip(judged), baked.made.paths
    return HalvedBake(cause, int(getattr(spec, cause)), psnr, flip, whole - psnr, paths, size)


def _without(spec: BakeSpec, cause: Cause) -> BakeSpec | None:
    """The same bake with one setting halved; None if that is impossible."""
    if cause is Cause.SAMPLES:
        return replace(spec, samples=spec.samples // 2) if spec.samples >= 2 else None
    if cause is Cause.CELLS:
        if not spec.form.any_cells:
            return None
        return replace(spec, bucket=spec.bucket // 2) if spec.bucket >= 4 else None
    return replace(spec, texels=spec.texels // 2, density=None) if spec.texels >= 2 else None


def first_change(bake: Finished, variants: Sequence[HalvedBake]) -> str:
    """Advice in a sentence or two: which setting to change first, and its cost in paths and bytes."""
    worst = max(variants, key=lambda variant: variant.lost, default=None)
    if worst is None:
        return "The bake is too small for any of its settings to be halved."
    if worst.lost < _MATTERS:
        return (
            f"No setting matters much here: halving any costs less than {_MATTERS} dB. What is left lies in "
            "the layout itself" + ("; try the layered layout." if not bake.form.traits.by_paths else ".")
        )
    word, shows = worst.cause.word, worst.shows.partition(":")[0]
    more = 4 * worst.value
    return (
        f"First give it more {word}: half of them costs most, {worst.lost:.1f} dB ({shows}). "
        f"{more} {word} take {_price(worst.cause, bake)}."
    )


def _price(cause: Cause, bake: Finished) -> str:
    """The cost in paths and bytes of doubling a setting."""
    if cause is Cause.SAMPLES:
        return "twice the paths, and no bytes"
    paths = "four times the paths" if cause is Cause.CELLS else "about four times the paths"
    twice = gpu_bytes(bake, cells=2) if cause is Cause.CELLS else gpu_bytes(bake, texels=2)
    return f"{paths}, and {_grown(twice, bake)}"


def _grown(larger: int, bake: Finished) -> str:
    return f"{larger / 1e6:.1f} MB on a GPU instead of {gpu_bytes(bake) / 1e6:.1f}"
