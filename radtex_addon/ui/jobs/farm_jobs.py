# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Farms as background jobs: prepare one of the scene as it is, and assemble what machines have made."""

from __future__ import annotations

from time import sleep
from typing import TYPE_CHECKING

from . import jobs

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    import bpy

    from ...core.sampler import Filter
    from ...farm.farm_folder import FarmFolder
    from ...job.variants import Bake
    from ...worker.job import Job
    from ...worker.order import Order

_PULSE = 0.05  # seconds between two looks at a worker that is waited for


def preparation(
    scene: bpy.types.Scene, bakes: Sequence[Bake], farm: Path, preview: Filter | None, *, overwrite: bool
) -> Order:
    """Save a copy of the scene; returns the order to prepare the folder `farm` of it.

    Raises BakeError as `hand_over`.
    """
    from ...worker.handover import hand_over
    from ...worker.orders import order_preparation
    from ..settings.preferences import preferred

    handover = hand_over(scene, preferred().cache)
    return order_preparation(handover, bakes, farm, preview, overwrite=overwrite)


def assembly(farm: FarmFolder, out: Path, *, overwrite: bool, overwrite_any: bool) -> Order:
    """The order to assemble a farm. Raises BakeError if no work folder can be made."""
    from ...worker.handover import work_folder
    from ...worker.orders import order_assembly
    from ..settings.preferences import preferred

    names = [name for name, _ in farm.bakes]
    folder = work_folder(preferred().cache)
    return order_assembly(folder, farm.folder, names, out, overwrite=overwrite, overwrite_any=overwrite_any)


def is_busy(farm: Path) -> bool:
    """Whether a job that has not ended prepares or assembles this farm."""
    return any(not job.ended and job.order.facts.get("farm") == str(farm) for job in jobs.snapshot())


def run_here(order: Order) -> Job:
    """Let a worker do the order, and wait for it. Raises BakeError if it fails."""
    from ...core.errors import BakeError
    from ...worker.handover import this_program
    from ...worker.queue import Queue

    queue = Queue(this_program())
    try:
        queue.add(order)
        while queue.advance():
            sleep(_PULSE)
        (job,) = queue.snapshot()
    finally:
        queue.close()
    if job.state != "done":
        raise BakeError.of(job.message)
    return job
