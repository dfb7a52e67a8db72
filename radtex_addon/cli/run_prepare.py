# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Run `bake.py prepare`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path

import bpy

from ..core.errors import InputError
from ..core.quoting import quoted
from ..farm.farm_files import tasks_file
from ..farm.farm_manifest import renders_as_frames
from ..farm.frame_list import commands
from ..farm.prepare_farm import Farm, prepare_steps
from ..farm.prepare_tasks import PreparedTasks, prepare_tasks_steps
from ..farm.self_contained import Carried
from ..farm.tasks import TaskFarm
from ..formats.disk.memory import readable_size
from ..job.bake_plan import check_plans
from ..job.variants import Bake
from .arguments import Request
from .asset_plans import asset_lines, atlases_of, plans_of
from .collection_objects import with_collections
from .interruption import Interruption
from .opening import open_asked
from .options import ASSEMBLE
from .reporting import Report
from .wording import told

_MACHINES = (1, 4, 16, 64)  # of which it is told how long they would take
_LONG = 5400.0  # seconds, from which on hours are told
_LISTED = 20  # most files listed in the summary


def run_prepare(request: Request, report: Report, interruption: Interruption) -> None:
    """Write the farm's folder and print the commands that do its work. Raises RadTexError.

    One atlas in layout buckets, if that is named, becomes frames that any Blender renders; all else becomes
    tasks for machines with RadTex.
    """
    scene = open_asked(request, interruption)
    request = with_collections(scene, request, report)
    bakes = request.bakes
    whole = bakes.open_layout is not None or bakes.as_scene or bakes.assets
    asked = () if whole else bakes.asked(scene)
    if len(asked) == 1 and renders_as_frames(asked[0][1]):
        if request.stock_frames:
            raise InputError("--stock-frames: in layout buckets all is frames already: leave it out")
        _prepare_frames(scene, asked[0], request, report, interruption)
    else:
        _prepare_tasks(scene, request, report, interruption)


def _prepare_frames(
    scene: bpy.types.Scene, bake: Bake, request: Request, report: Report, interruption: Interruption
) -> None:
    name, spec = bake
    out, preview = request.bakes.folder, request.bakes.preview
    overwrite = request.bakes.may_replace(request.bakes.overwrite)
    steps = prepare_steps(scene, name, spec, out, preview=preview, overwrite=overwrite)
    farm = interruption.between(steps, partial(report.progress, name))
    report.event("done", object=name, summary=_summary(name, farm), **_facts(farm))


def _prepare_tasks(
    scene: bpy.types.Scene, request: Request, report: Report, interruption: Interruption
) -> None:
    bakes = request.bakes
    atlases = atlases_of(scene, bakes)
    plans = plans_of(scene, bakes, atlases)
    check_plans(scene, plans)
    for line in (line for plan in plans for line in plan.layout_lines):
        report.event("note", message=line)
    for found in asset_lines(scene, bakes, plans):
        report.event("note", **told(found))
    for atlas in atlases:
        report.event("note", message=atlas.told)
    wanted = [bake for plan in plans for bake in plan.wanted]
    steps = prepare_tasks_steps(
        scene,
        wanted,
        bakes.folder,
        preview=bakes.preview,
        overwrite=bakes.overwrite,
        frames=request.stock_frames,
    )
    name = scene.name  # it is removed meanwhile
    made = interruption.between(steps, partial(report.progress, name))
    report.event("done", object=name, summary=_summary_of_tasks(made), **_facts_of_tasks(made))


def _summary_of_tasks(made: PreparedTasks) -> tuple[str, ...]:
    farm = made.farm
    whole = replace(farm, tasks=farm.with_frames())
    hours = [f"{_hours(whole.seconds_for(machines))} on {machines}" for machines in _MACHINES]
    total = _hours(sum(task.seconds for task in whole.tasks))
    return (
        f"{len(farm.bakes)} atlases, {len(farm.tasks)} tasks, {readable_size(made.size)} to travel",
        *_carried(farm.carried, tasks_file(farm.folder)),
        f"by typical times {total} of one processor core; about {', '.join(hours)} of them",
        *_summary_of_frames(farm),
        f"do them, on as many machines as there are: {farm.command()}",
        f"then join them: {quoted(['python', 'bake.py', ASSEMBLE, str(farm.folder)])}",
    )


def _summary_of_frames(farm: TaskFarm) -> list[str]:
    """What machines without RadTex do first, if there is anything."""
    if not farm.frames:
        return []
    seconds = sum(each.seconds * each.count for each in farm.frames)
    blends = [quoted(["blender", "-b", str(each.blend(farm.folder)), "-a"]) for each in farm.frames]
    count = sum(each.count for each in farm.frames)
    lines = [
        f"first render {count} frames ({_hours(seconds)} of one core) on machines with nothing but Blender:",
        *(f"  {command}" for command in blends[:_LISTED]),
    ]
    if len(blends) > _LISTED:
        lines.append(f"  … and {len(blends) - _LISTED} more .blends in that folder")
    framed = {each.bake for each in farm.frames}
    others = [bake.key for bake in farm.bakes if bake.key not in framed]
    if others:
        said = ", ".join(others[:_LISTED]) + (" …" if len(others) > _LISTED else "")
        lines.append(f"no frames are of {said}, which machines with RadTex render alone")
    return lines


def _hours(seconds: float) -> str:
    return f"{max(seconds / 60, 0.1):.1f} minutes" if seconds < _LONG else f"{seconds / 3600:.1f} hours"


def _facts_of_tasks(made: PreparedTasks) -> dict[str, object]:
    farm = made.farm
    whole = replace(farm, tasks=farm.with_frames())
    return {
        "files": [str(farm.folder)],
        "job": farm.job,
        "tasks": [task.name for task in farm.tasks],
        "bytes": made.size,
        "seconds": {str(machines): round(whole.seconds_for(machines)) for machines in _MACHINES},
        "carried": [asdict(each) for each in farm.carried],
        "stock_frames": [each.to_facts() for each in farm.frames],
    }


def _summary(name: str, farm: Farm) -> tuple[str, ...]:
    manifest = farm.manifest
    height, width = manifest.pixels
    blender, _ = commands(farm.files, range(1, manifest.sheets + 1))
    beside = f", with {len(farm.beside)} files beside the .blend" if farm.beside else ""
    made = (
        f"{name}: {manifest.sheets} frames of {width} x {height} pixels at {manifest.spec.samples} spp, "
        f"{farm.texels} texels covered, for {manifest.device}{beside}"
    )
    return (
        made,
        *_carried(farm.carried, farm.files.manifest),
        f"render them: {blender}",
        f"then join them: {quoted(['python', 'bake.py', ASSEMBLE, str(farm.files.folder)])}",
    )


def _carried(carried: Sequence[Carried], listing: Path) -> list[str]:
    """A heading, and a line for each file of this machine that is included with the farm's folder."""
    lines = [f"  {each}" for each in carried[:_LISTED]]
    if not lines:
        return ["no other file of this machine goes along with its folder"]
    if left := len(carried) - len(lines):
        lines.append(f"  … and {left} more, which {listing.name} lists")
    return ["these files of this machine go along with its folder:", *lines]


def _facts(farm: Farm) -> dict[str, object]:
    manifest = farm.manifest
    return {
        "files": [str(farm.files.folder)],
        "job": manifest.job,
        "blend": str(farm.files.blend),
        "frames": [1, manifest.sheets],
        "beside": list(farm.beside),
        "carried": [asdict(each) for each in farm.carried],
        "device": manifest.device,
    }
