# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Do one task of a farm: open its scene, make the pieces or the files that it is for, mark it as done."""

from __future__ import annotations

import logging
import platform
import secrets
import shutil
import sys
from collections.abc import Callable, Collection, Generator, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from time import perf_counter, sleep

import bpy

from ..bake.piece_store import ShareDoneError
from ..bake.plan import CapturePlan
from ..bake.progress import Progress, Stopwatch
from ..core.errors import BakeError, FormatError, InputError
from ..formats.disk.atomic import refusal
from ..formats.disk.regular import digest
from ..forms import form_for
from ..forms.bake_job import BakeJob
from ..forms.form import Form
from ..forms.layered.bake import arrays_kept
from ..forms.layered.capture.capturing import capture_part, show_parts
from ..forms.layered.capture.panoramas import StoredViews, pictures_shared
from ..forms.layered.capture.parts import Part, part_of
from ..forms.outcome import Outcome
from ..job.baking import Baked, Baker, bake_unchecked
from ..scene.scratch import at_frame, new_data_removed
from ..store.output_files import OutputFiles
from ..store.shared_pieces import SharedPieces, piece_file
from .claims import Claim, claimed
from .part_frames import RenderedPart
from .tasks import WHOLE, Done, FarmBake, Task, TaskFarm, publish_results

try:
    import resource
except ImportError:  # Windows has none
    resource = None  # type: ignore[assignment]

log = logging.getLogger(__name__)

_WAIT = 2.0  # seconds between looks for a picture that another machine makes
_MADE_LAST = (Part.AROUND, Part.EXITS, Part.MISLED)  # what the last task makes if no other was to


def task_steps(farm: TaskFarm, name: str) -> Generator[Progress, None, bool]:
    """Do the task of that name; returns False if it was done, and all that it made is there.

    Yields progress; **the farm's scene is open afterwards**. Nothing that is there is lost, however often,
    and on however many machines at once a task is done. Raises InputError for a task that this machine cannot
    do, or not yet, BakeError for what fails.
    """
    task = farm.task(name)
    _check_machine(farm)
    farm.check_same()
    if not (faults := _faults(farm, task)):
        return False
    if farm.is_done(name):
        log.warning("task %s is done again: %s", name, faults)
        farm.set_undone(name)
    _check_needs(farm, task)
    rendered = _rendered(farm, task)
    begun = perf_counter()
    scene = open_scene(farm)
    bake = farm.bake_of(task)
    with _results(farm, task) as place, shared_views(farm) as views, pictures_shared(views):
        store = pieces_of(farm, task, place)
        files, result = {}, {}
        try:
            made = yield from _baked(scene, farm, task, bake, store, place, rendered)
        except ShareDoneError:
            pass
        else:
            result = made.made.told()
            files = {path.name: digest(path) for path in place.iterdir() if path.is_file()}
            farm.check_same()
            if farm.is_done(name) and not farm.result_faults(name):  # another machine was quicker
                return True
            farm.set_undone(name)
            _publish(farm, bake, place)
    farm.check_same()
    farm.set_done(
        name,
        Done(
            pieces=tuple(store.used),
            files=files,
            seconds=round(perf_counter() - begun, 2),
            memory=_most_memory(),
            host=platform.node(),
            result=result,
        ),
    )
    return True


def open_scene(farm: TaskFarm) -> bpy.types.Scene:
    """Open the farm's .blend. Raises FormatError if it is not there, or lacks the scene."""
    file = farm.scene_file
    try:
        bpy.ops.wm.open_mainfile(filepath=str(file.absolute()), load_ui=False, use_scripts=False)
        return bpy.data.scenes[farm.scene]
    except (RuntimeError, KeyError) as error:
        reason = " ".join(str(error).removeprefix("Error:").split())
        raise FormatError(
            f"{file} does not open: {reason}; copy it anew, or prepare the farm anew"
        ) from error


def pieces_of(farm: TaskFarm, task: Task, results: Path, ignored: Collection[str] = ()) -> SharedPieces:
    """The bake's pieces, of which those of the task are made; `ignored` facts are taken as they are there."""
    promised = {each.part for each in farm.tasks if each.bake == task.bake}

    def makes(piece: str) -> bool:
        part = part_of(piece)
        if task.part != WHOLE:
            return part == task.part
        return part not in promised or (part in _MADE_LAST and _is_unforeseen(piece, promised))

    def whose(piece: str, fault: str) -> BakeError:
        tasks = _makers(farm, task.bake, piece)
        for each in tasks:
            farm.set_undone(each)
        return BakeError(
            f"{piece_file(farm.pieces(task.bake), piece)}, which task {task.name} needs, {fault}: "
            f"do it first: {farm.command_for(tasks)}"
        )

    store = SharedPieces(farm.pieces(task.bake), results, makes, whose, task.share, ignored)
    store.set_facts({"farm": farm.job})
    return store


def _makers(farm: TaskFarm, bake: str, piece: str) -> list[str]:
    """The task that has made a piece, or if none says so all that may."""
    may = [each.name for each in farm.tasks if each.bake == bake and each.part == part_of(piece)]
    return [name for name in may if farm.is_done(name) and piece in farm.done(name).pieces] or may


def _is_unforeseen(piece: str, promised: set[str]) -> bool:
    """Whether a piece is of an object that lets light through, which nobody foresaw."""
    return piece.endswith("-through") and Part.EXITS not in promised


def _rendered(farm: TaskFarm, task: Task) -> RenderedPart | None:
    """The frames that the task takes in place of renders. Raises InputError if they cannot be used."""
    frames = farm.frames_of(task)
    if frames is None:
        return None
    rendered = RenderedPart(farm.folder, farm.job, farm.blender, frames, task.share)
    rendered.check()
    return rendered


def show_parts_of(
    farm: TaskFarm, bake: FarmBake, save: Callable[[Part, bpy.types.Scene, CapturePlan], None]
) -> Generator[Progress, None, None]:
    """Call `save` with scenes for frames, as `show_parts`, of a layered bake whose maps are made.

    Yields progress; **the farm's scene is open afterwards**.
    """
    scene = open_scene(farm)
    task = next(task for task in farm.tasks if (task.bake, task.part) == (bake.key, Part.LIGHT))

    def make(job: BakeJob) -> Generator[Progress, None, Outcome]:
        job = replace(job, arrays=job.folder)
        with arrays_kept(job):
            yield from show_parts(job.scratch, job.prepared, job.spec, job.folder, store, save)
        raise ShareDoneError

    with _results(farm, task) as place:
        store = pieces_of(farm, task, place)
        with suppress(ShareDoneError):
            yield from _bake_by(make, scene, farm, bake, store, place, warns=False)


def _baked(
    scene: bpy.types.Scene,
    farm: TaskFarm,
    task: Task,
    bake: FarmBake,
    store: SharedPieces,
    place: Path,
    rendered: RenderedPart | None,
) -> Generator[Progress, None, Baked]:
    """Make the task's pieces, and raise ShareDoneError, or if it is the last one the bake's files."""
    form: Form = form_for(bake.spec)
    sheets = None if rendered is None else rendered.sheet
    clear = any(each.bake == task.bake and each.part == Part.EXITS for each in farm.tasks)

    def make(job: BakeJob) -> Generator[Progress, None, Outcome]:
        job = replace(job, arrays=job.folder)  # not on the disk that all machines share
        if task.part == WHOLE:
            return (yield from form.bake(job))
        with arrays_kept(job):
            yield from capture_part(
                job.scratch, job.prepared, job.spec, job.folder, store, Part(task.part), clear, sheets
            )
        raise ShareDoneError

    warns = task.part in (Part.MAPS, WHOLE)
    return (yield from _bake_by(make, scene, farm, bake, store, place, warns))


def _bake_by(
    make: Baker,
    scene: bpy.types.Scene,
    farm: TaskFarm,
    bake: FarmBake,
    store: SharedPieces,
    place: Path,
    warns: bool,
) -> Generator[Progress, None, Baked]:
    """Prepare the bake's objects in the farm's `scene`, and call `make`."""
    files = OutputFiles.of(bake.name, bake.spec, place)
    with at_frame(scene, bake.spec.frame), new_data_removed():
        return (
            yield from bake_unchecked(
                scene, bake.name, bake.spec, files, None, Stopwatch(), store,
                baker=make, warns=warns, blend=Path(farm.blend), fingerprint=bake.fingerprint,
            )
        )  # fmt: skip


@contextmanager
def shared_views(farm: TaskFarm) -> Iterator[StoredViews]:
    """The pictures of rooms that tasks share; while one machine makes one, others wait for it."""
    seen: dict[str, Claim] = {}
    with ExitStack() as claims:

        def make(key: str) -> bool:
            """Whether this machine is to make a picture; False after a while, in which another may have."""
            if claims.enter_context(claimed(farm, key, seen)):
                return True
            sleep(_WAIT)
            return False

        yield StoredViews(_view_store(farm), make)


def _view_store(farm: TaskFarm) -> SharedPieces:
    def whose(piece: str, fault: str) -> BakeError:
        return BakeError(f"{farm.views / piece} {fault}")

    store = SharedPieces(farm.views, farm.views, lambda _: True, whose)
    store.set_facts({"farm": farm.job})
    return store


@contextmanager
def _results(farm: TaskFarm, task: Task) -> Iterator[Path]:
    """A folder of this process's own for the bake's files; it is removed if it has not got their name."""
    place = farm.results(task.bake).with_name(f".radtex-{task.bake}-{secrets.token_hex(8)}")
    try:
        yield place
    finally:
        shutil.rmtree(place, ignore_errors=True)


def _publish(farm: TaskFarm, bake: FarmBake, place: Path) -> None:
    target = farm.results(bake.key)
    try:
        publish_results(place, target)
    except OSError as error:
        raise BakeError(refusal(target, error)) from error


def _check_machine(farm: TaskFarm) -> None:
    """Raises InputError for another version of Blender: its noise is another."""
    own = bpy.app.version_string
    if own != farm.blender:
        raise InputError(
            f"{farm.folder} was prepared in Blender {farm.blender}, and this is {own}: the noise of its "
            "renders would be another; use the same version, or prepare the farm anew in this one"
        )


def _check_needs(farm: TaskFarm, task: Task) -> None:
    """Raises InputError for a task whose turn has not come, with those that come first."""
    if left := farm.undone(task.needs):
        raise InputError(
            f"task {task.name} needs what is not done: {', '.join(left[:8])}{' …' if len(left) > 8 else ''}; "
            f"do that first: {farm.command_for(left)}"
        )


def _faults(farm: TaskFarm, task: Task) -> str:
    """Why a task is to be done; "" if it is done, and all that it made is there, undamaged."""
    if not farm.is_done(task.name):
        return "it is not done"
    try:
        done = farm.done(task.name)
        if task.is_last:
            return farm.result_faults(task.name)
    except FormatError as error:
        return str(error)
    folder = farm.pieces(task.bake)
    missing = [piece for piece in done.pieces if not piece_file(folder, piece).is_file()]
    return f"{piece_file(folder, missing[0])} is not there" if missing else ""


def _most_memory() -> int:
    """The most memory that this process has taken, in bytes; 0 where the system does not tell."""
    if resource is None:
        return 0
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return int(most if sys.platform == "darwin" else most * 1024)
