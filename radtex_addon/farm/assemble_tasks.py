# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Move what a farm's tasks have made to where a bake on one machine would have written it."""

from __future__ import annotations

import logging
import shutil
from collections.abc import Generator
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

from ..bake.piece_store import PieceStore
from ..bake.progress import Stage, Stopwatch
from ..core.errors import BakeError, FormatError
from ..formats.disk.atomic import check_writable, refusal
from ..formats.disk.regular import digest
from ..forms.layered.capture.parts import Part
from ..job.baking import BakeResult, bake_unchecked, finished_baker
from ..job.previews import save_preview_of
from ..scene.scratch import at_frame, new_data_removed
from ..store.bake_folder import BakeFolder
from ..store.output_files import BakeOutput
from ..store.ownership import Overwrite
from .assemble_farm import Assembled
from .farm_progress import AnyStep, FarmStep, FarmTask
from .run_task import open_scene, pieces_of
from .tasks import WHOLE, FarmBake, TaskFarm

log = logging.getLogger(__name__)

_STAGES = {WHOLE: Stage.FIT, Part.MAPS: Stage.PROBE} | dict.fromkeys(
    (Part.AROUND, Part.EXITS, Part.MISLED), Stage.SURROUNDINGS
)  # all others are captures
_NAMED = 12  # most tasks that are named


class TasksLeftError(BakeError):
    """Tasks are to be done; so many bakes are `finished`."""

    def __init__(self, problem: str, finished: int) -> None:
        super().__init__(problem)
        self.finished = finished


def assemble_tasks_steps(
    farm: TaskFarm,
    out: Path | None = None,
    *,
    overwrite: bool = False,
    overwrite_any: bool = False,
    some: bool = False,
) -> Generator[AnyStep, None, tuple[Assembled, ...]]:
    """Check that all bakes are done, and write their files into `out`, by default beside the farm's folder.

    If previews were asked for, **the farm's scene is open afterwards**. `overwrite` replaces no better bake
    and none of another .blend without `overwrite_any`. Yields progress. Raises TasksLeftError, which names
    the tasks that are to be done, if not all are; InputError for files that would be overwritten; then
    nothing is written. With `some` bakes are enough, if any is done: those are written, and a warning names
    the tasks.
    """
    out = farm.folder.absolute().parent if out is None else out
    bakes = yield from _finished(farm, some)
    check_writable(out)
    replaces = Overwrite(overwrite, overwrite_any, Path(farm.blend))
    places = [_place(farm, bake, out) for bake in bakes]
    there = [_is_there(farm, bake, place) for bake, place in zip(bakes, places, strict=True)]
    for place in (place for place, is_there in zip(places, there, strict=True) if not is_there):
        place.check_may_write(replaces)
    made = [
        BakeOutput.of(farm.done(bake.last).result, place.files)
        if is_there
        else _write(farm, bake, place, replaces)
        for bake, place, is_there in zip(bakes, places, there, strict=True)
    ]
    if farm.preview is not None:
        for bake, output, is_there in zip(bakes, made, there, strict=True):
            if not is_there:
                yield from _save_preview(farm, bake, output)
    return tuple(
        Assembled(bake.name, bake.spec, BakeResult(**vars(output), seconds=_seconds(farm, bake)))
        for bake, output in zip(bakes, made, strict=True)
    )


def _place(farm: TaskFarm, bake: FarmBake, out: Path) -> BakeFolder:
    return BakeFolder(bake.name, bake.spec, out, farm.preview is not None)


def _finished(farm: TaskFarm, some: bool) -> Generator[FarmStep, None, list[FarmBake]]:
    """The bakes whose files are there. Names the tasks that are to be done in one line, if not all are.

    That is a warning where `some` bakes are enough, else raises TasksLeftError.
    """
    faults: list[str] = []
    for number, bake in enumerate(farm.bakes):
        yield FarmStep(FarmTask.CHECK, number, len(farm.bakes))
        task = bake.last
        if farm.is_done(task):
            try:
                fault = farm.result_faults(task)
            except FormatError as error:
                fault = error.message.problem
            if fault:
                farm.set_undone(task)
                faults.append(fault)
    unfinished = {bake.key for bake in farm.bakes if not farm.is_done(bake.last)}
    finished = [bake for bake in farm.bakes if bake.key not in unfinished]
    left = [task.name for task in farm.left() if task.bake in unfinished]
    if left:
        said = f"{', '.join(left[:_NAMED])}{f' and {len(left) - _NAMED} more' if len(left) > _NAMED else ''}"
        of = f"{len(left)} of {len(farm.tasks)} tasks are not done: {said}"
        message = "; ".join((*faults, of)) + f"; do them: {farm.command_for(left)}"
        if not some or not finished:
            raise TasksLeftError(message, len(finished))
        log.warning("%s", message)
    return finished


def _is_there(farm: TaskFarm, bake: FarmBake, place: BakeFolder) -> bool:
    """Whether a bake's files, and its preview, were joined before, as when only some bakes were done."""
    sidecar, files = place.files.sidecar, farm.done(bake.last).files
    targets = {sidecar.with_name(name): known for name, known in files.items()}
    is_whole = all(path.is_file() and digest(path) == known for path, known in targets.items())
    preview = place.files.preview
    return is_whole and (preview is None or preview.is_file())


def _write(farm: TaskFarm, bake: FarmBake, place: BakeFolder, replaces: Overwrite) -> BakeOutput:
    """Copy a bake's files, and move them to their names together."""
    done = farm.done(bake.last)
    source, sidecar = farm.results(bake.key), place.files.sidecar
    made = BakeOutput.of(done.result, place.files)
    with place.open(replaces) as checkpoint:
        for name in done.files:
            target = checkpoint.place(sidecar.with_name(name))
            try:
                shutil.copyfile(source / name, target)
            except OSError as error:
                raise BakeError(refusal(target, error)) from error
        place.publish(checkpoint, made)
        checkpoint.remove()
    return made


def _save_preview(farm: TaskFarm, bake: FarmBake, made: BakeOutput) -> Generator[AnyStep, None, None]:
    assert farm.preview is not None  # see above
    scene = open_scene(farm)
    task = farm.task(bake.last)
    store: PieceStore = pieces_of(farm, task, farm.results(bake.key), ignored=("device",))
    spec = replace(bake.spec, device="cpu")  # nothing is rendered, and this machine may have no other
    with at_frame(scene, bake.spec.frame), new_data_removed():
        baked = yield from bake_unchecked(
            scene, bake.name, spec, made.files, None, Stopwatch(), store,
            baker=finished_baker(made), warns=False, blend=Path(farm.blend), fingerprint=bake.fingerprint,
        )  # fmt: skip
        yield FarmStep(FarmTask.CHECK, 1, 1)
        save_preview_of(scene, bake.spec, made.files, baked.prepared, farm.preview, None)


def _seconds(farm: TaskFarm, bake: FarmBake) -> dict[Stage, float]:
    """What the tasks of a bake took, by stage."""
    found: dict[Stage, float] = {}
    for task in farm.tasks:
        if task.bake == bake.key and farm.is_done(task.name):
            stage = _STAGES.get(task.part, Stage.CAPTURE)
            with suppress(FormatError):  # all files are there
                found[stage] = found.get(stage, 0.0) + farm.done(task.name).seconds
    return found
