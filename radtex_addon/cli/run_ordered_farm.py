# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Prepare and assemble farms as the panel orders it, beside `bake.py prepare` and `assemble`."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path

from ..core.sampler import Filter
from ..farm.assemble_farm import Assembled, assemble_steps
from ..farm.assemble_tasks import assemble_tasks_steps
from ..farm.farm_files import tasks_file
from ..farm.prepare_tasks import prepare_tasks_steps
from ..farm.tasks import read_tasks
from ..formats.disk.memory import readable_size
from ..job.variants import Bake, title_of
from .interruption import Interruption
from .opening import open_asked
from .options import ProgressStyle
from .reporting import Report

_MACHINES = (1, 4, 16)  # of which it is told how long they would take


@dataclass(frozen=True)
class OrderedFarm:
    """Bakes, which were checked, to be prepared for a farm in `folder`; the scene is as for a bake.

    `blend` is the path of the session's file, `Path()` if it was never saved.
    """

    bakes: tuple[Bake, ...]
    folder: Path
    preview: Filter | None
    overwrite: bool
    blend: Path
    scene: Path | None
    demo: bool
    progress: ProgressStyle
    verbose: bool
    in_scene: str | None
    unsaved_images: Path | None
    parent_pipe: bool


@dataclass(frozen=True)
class OrderedAssembly:
    """The folder `farm`, whose bakes go to `folder`."""

    farm: Path
    folder: Path
    overwrite: bool
    overwrite_any: bool


def run_ordered_farm(request: OrderedFarm, report: Report, interruption: Interruption) -> None:
    """Write the farm's folder, and report what is in it, and how long it takes. Raises RadTexError."""
    scene = open_asked(request, interruption)
    steps = prepare_tasks_steps(
        scene,
        request.bakes,
        request.folder,
        preview=request.preview,
        overwrite=request.overwrite,
        blend=request.blend,
    )
    made = interruption.between(steps, partial(report.progress, scene.name))
    farm = made.farm
    report.event(
        "done",
        object=farm.scene,
        summary=f"{len(farm.bakes)} atlases, {len(farm.tasks)} tasks, {readable_size(made.size)} to travel",
        files=[str(farm.folder)],
        tasks=len(farm.tasks),
        bytes=made.size,
        expected=[[machines, farm.seconds_for(machines)] for machines in _MACHINES],
        carried=[str(each) for each in farm.carried],
        listing=str(tasks_file(farm.folder)),
    )


def run_ordered_assembly(request: OrderedAssembly, report: Report, interruption: Interruption) -> None:
    """Check and join what machines have made, of either sort of farm, and report all of it at once.

    Raises RadTexError.
    """
    interruption.ask_when_input_ends()
    made: tuple[Assembled, ...]
    options = {"overwrite": request.overwrite, "overwrite_any": request.overwrite_any}
    step = partial(report.progress, request.farm.name)
    if tasks_file(request.farm).is_file():
        farm = read_tasks(request.farm)
        made = interruption.between(assemble_tasks_steps(farm, request.folder, **options), step)
    else:
        made = (interruption.between(assemble_steps(request.farm, request.folder, **options), step),)
    report.event(
        "done",
        object=request.farm.name,
        summary=", ".join(title_of(each.name, each.spec) for each in made),
        files=[str(path) for each in made for path in each.result.files.all],
        clamped=sum(each.result.clamped for each in made),
    )
