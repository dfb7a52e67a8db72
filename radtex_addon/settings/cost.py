# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a bake costs at most; computed by `cost` in `forms/NAME/form.py`, or inherited from the buckets.

Whether it fits into memory is no check of the specification, as machines differ.
"""

from __future__ import annotations

import shutil
from contextlib import suppress
from dataclasses import dataclass
from math import prod
from pathlib import Path

from ..bake.session import BYTES_PER_PIXEL
from ..core.errors import InputError, MemoryLimitError
from ..core.messages import Setting, do
from ..formats.disk.memory import physical_memory, readable_size
from ..formats.disk.path_checks import nearest_folder
from ..formats.image_files import Shapes
from .spec import BakeSpec
from .spec_checks import size_of

_LEAST_TILE = 32 << 20  # bytes that must be left for a render, unless the whole atlas needs less
_GPU_CHANNELS = 4  # a GPU texture of three channels takes as much memory as one of four


def check_memory(spec: BakeSpec) -> None:
    """Raises MemoryLimitError if a bake needs more memory than this machine has, or than the user allows."""
    asked = size_of(spec)
    memory, most = physical_memory(), spec.atlas_bytes + min(_LEAST_TILE, spec.pixel_count * BYTES_PER_PIXEL)
    needed = readable_size(most)
    if memory is not None and spec.atlas_bytes > memory:
        raise MemoryLimitError(
            f"{asked} needs {needed} of memory, this machine has {readable_size(memory)}",
            do("lower one of them"),
        )
    if spec.memory_mb is not None and most > spec.memory_mb << 20:
        allowed = readable_size(spec.memory_mb << 20)
        raise MemoryLimitError(
            f"{asked} needs {needed} of memory beside the scene, {allowed} are allowed",
            do("allow more", Setting.MEMORY),
            do("lower one of them"),
        )


def check_disk(spec: BakeSpec, folder: Path) -> None:
    """Raises InputError if the disk of the output's `folder` has no room for what a bake keeps there.

    Only of a bake whose arrays do not stay in memory.
    """
    needed = spec.disk_bytes
    if not needed:
        return
    with suppress(OSError):  # a disk that does not tell may have room
        free = shutil.disk_usage(nearest_folder(folder)).free
        if needed > free:
            raise InputError(
                f"{size_of(spec)} needs {readable_size(needed)} of the disk of {folder} while it is baked, "
                f"{readable_size(free)} are free",
                do("free its disk"),
                do("choose another folder", Setting.OUT),
                do("allow more memory", Setting.MEMORY),
                do("lower one of them"),
            )


@dataclass(frozen=True)
class Cost:
    """Upper limits for a bake of a square atlas.

    `side`: pixels of the largest image's longer side; `disk`: bytes of all images before compression; `gpu`:
    bytes of the same images as textures without mip levels; `memory`: bytes of main memory during the bake;
    `paths`: camera paths.
    """

    side: int
    disk: int
    gpu: int
    memory: int
    paths: int


def cost_of_images(spec: BakeSpec, shapes: Shapes) -> Cost:
    """The cost of a bake whose images, of floats, have these widths, heights and channels."""
    value = 2 if spec.half else 4
    return Cost(
        side=max(max(shape[:2]) for shape in shapes.values()),
        disk=value * sum(prod(shape) for shape in shapes.values()),
        gpu=value * _GPU_CHANNELS * sum(width * height for width, height, _ in shapes.values()),
        memory=spec.atlas_bytes,
        paths=spec.path_count,
    )
