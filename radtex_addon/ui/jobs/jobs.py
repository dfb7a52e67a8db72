# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The session's background jobs: a queue of worker processes, polled by a timer while any job is active."""

from __future__ import annotations

import atexit
import logging
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from itertools import zip_longest
from tempfile import TemporaryDirectory
from time import monotonic
from typing import TYPE_CHECKING

import bpy

from ..panel import job_ends, panel_state
from ..panel.redraw import redraw
from . import bake_times, job_files, pictures
from .bake_times import BakedScene
from .repeated_exports import RepeatedExports

if TYPE_CHECKING:
    from pathlib import Path

    from ...job.bake_plan import BakePlan
    from ...job.variants import Bake
    from ...worker.job import Job
    from ...worker.kept_jobs import FollowUp, KeptJobs
    from ...worker.order import Order
    from ...worker.queue import Queue
    from ...worker.together import Together
    from ..settings.bake_settings import BakeSettings

_log = logging.getLogger(__name__)
_START = 1.0  # seconds after Blender's start, or RadTex's, until earlier sessions' jobs are looked for
_PULSE = 0.5  # seconds between two polls of the workers, and so at least between two redraws for them


@dataclass(frozen=True)
class Completion:
    """Callback after a job: `arrived` is called when it is done.

    The folder `results`, if any, is deleted when the job is removed from the list.
    """

    arrived: Callable[[Job], None]
    results: TemporaryDirectory[str] | None = None

    def clean_up(self) -> None:
        """Delete the results."""
        if self.results is not None:
            self.results.cleanup()


@dataclass
class _Session:
    """State of the jobs of this Blender session.

    `queue` is None before the first job, so that enabling RadTex does not import the worker modules. `shown`
    is the last snapshot of the jobs; `completions` maps job numbers to completions, `begun` to the time when
    each began, on the monotonic clock, `scenes` those of bakes to what is remembered of their scene,
    `repeats` those of bakes that have not ended, or are left, to the exports that follow them, and `folded`
    those that were folded or unfolded by hand to which of both; `warned` are the numbers of ended jobs whose
    warnings are unfolded. `untold` are the numbers of jobs that have ended while others were left to do.
    `kept` is the list for the next session, None without a window.
    """

    queue: Queue | None = None
    begun: dict[int, float] = field(default_factory=dict)
    scenes: dict[int, BakedScene] = field(default_factory=dict)
    shown: tuple[Job, ...] = field(default=())
    completions: dict[int, Completion] = field(default_factory=dict)
    repeats: dict[int, RepeatedExports] = field(default_factory=dict)
    folded: dict[int, bool] = field(default_factory=dict)
    warned: set[int] = field(default_factory=set)
    untold: set[int] = field(default_factory=set)
    kept: KeptJobs | None = None


_session = _Session()


def register() -> None:
    """With a window: look soon for jobs of sessions that have ended, and keep the list of this one."""
    if not bpy.app.background:
        bpy.app.timers.register(_take_over, first_interval=_START)


def take_over(folder: Path) -> None:
    """Show the jobs that ended sessions left in `folder`, and keep this session's there from now on."""
    from ...version import VERSION
    from ...worker.kept_jobs import KeptJobs, left_lists

    made_by = f"RadTex {VERSION}, Blender {bpy.app.version[0]}.{bpy.app.version[1]}"
    _session.kept = KeptJobs(folder, made_by)
    queue = _queue()
    atexit.register(_end_session)  # before the queue's own end, which would cancel all
    lists = list(left_lists(folder, made_by))
    for one in lists:
        numbers = queue.adopt(one.jobs)
        left_over = {
            place: number
            for place, (number, job) in enumerate(zip(numbers, one.jobs, strict=True), 1)
            if job.state == "left"
        }
        for each in one.follow_ups:
            repeats = RepeatedExports.of_facts(each.facts)
            places = (place for place in each.numbers if place in left_over)
            _session.repeats |= {left_over[place]: repeats for place in places}
    advance()
    for one in lists:
        one.remove()
    for job in _session.shown:
        if job.state == "done":
            job_files.note(job)
    if lists:
        look_at_files()
        redraw()
    _keep()


def _take_over() -> None:
    from ...worker.handover import jobs_folder

    take_over(jobs_folder())


def left(number: int | None = None) -> tuple[Job, ...]:
    """Jobs that an ended session left and that can be gone on with: all, or the one with that number.

    Not those whose bake a later job has made, or goes on with.
    """
    return tuple(
        job
        for job in _session.shown
        if job.state == "left" and number in (None, job.number) and not is_superseded(job)
    )


def is_superseded(job: Job) -> bool:
    """Whether a later job is about the same, into the same folder."""
    return any(other.number > job.number and _subject(other) == _subject(job) for other in _session.shown)


def _subject(job: Job) -> tuple[object, ...]:
    """What is baked, and into which folder."""
    order = job.order
    same = order.work, order.object, order.shared, order.about, order.part, order.variant, order.out
    return *same, order.called


def go_on(number: int | None = None) -> None:
    """Queue the jobs that are `left` again."""
    for job in left(number):
        _queue().go_on(job.number)
    _look()
    panel_state.mark_stale()  # their objects are being baked now


def _keep(*, always: bool = False) -> None:
    """Write the list for the next session, if it has changed."""
    if _session.kept is not None:
        _session.kept.write(_session.shown, _follow_ups(), always=always)


def _follow_ups() -> list[FollowUp]:
    """The exports that follow bakes which wait, run or are left, with the numbers of these."""
    from ...worker.kept_jobs import FollowUp

    numbers: dict[RepeatedExports, list[int]] = {}
    for number, repeats in _session.repeats.items():
        numbers.setdefault(repeats, []).append(number)
    return [FollowUp(tuple(those), repeats.facts()) for repeats, those in numbers.items()]


def submit(scene: bpy.types.Scene, plans: Sequence[BakePlan], names: Sequence[str] = ()) -> float:
    """Save a copy of the scene in its current state and queue the bakes of all plans.

    They are queued in the order of their objects among `names`, else plan by plan.

    Returns how long the window was blocked by that, in seconds. Raises InputError if one of the bakes is
    already queued or running, or has no preview for the export that follows it, BakeError if the scene
    cannot be saved.
    """
    from ...job.bake_plan import in_order
    from ...worker.handover import hand_over
    from ...worker.orders import order_bake
    from ..settings.preferences import preferred
    from . import estimates

    free = {id(plan): _free(plan) for plan in plans}
    bakes = [(plan, bake) for plan, bake in in_order(plans, names) if bake in free[id(plan)]]
    shown = [bake_times.shown_triangles(scene, spec.objects or (name,)) for _, (name, spec) in bakes]
    repeats = RepeatedExports.of(scene, plans)
    handover = hand_over(scene, preferred().cache)
    add(
        (
            order_bake(
                handover,
                name,
                spec,
                plan.request.folder,
                plan.request.preview,
                overwrite=bool(plan.course_of((name, spec)).overwrite),
                overwrite_any=plan.course_of((name, spec)).overwrite.any,
                resume=plan.course_of((name, spec)).resume,
                exports=plan.request.exports,
                picture=handover.folder / f"picture-{number}.png",
                expected=estimates.expected_of(
                    scene, name, spec, plan.request.preview is not None, len(plan.request.exports)
                ),
            )
            for number, (plan, (name, spec)) in enumerate(bakes)
        ),
        scenes=[BakedScene(bake_times.scene_key(scene.name), count) for count in shown],
        repeats=repeats,
    )
    return handover.stalled


def is_being_baked(name: str, settings: BakeSettings) -> bool:
    """Whether a bake of the object, of the kind, part and name that the settings ask for, waits or runs."""
    from ...settings.bake_names import OBJECT
    from ...settings.kinds import is_default_kind
    from ...worker.order import Work

    about = "" if is_default_kind(settings.kind) else settings.kind
    part = settings.part if settings.split != "none" else ""
    found = [
        job
        for job in _session.shown
        if not job.ended
        and job.work is Work.BAKE
        and name in (job.order.shared or (job.object,))
        and job.order.about == about
        and (not part or job.order.part == part)
    ]
    return bool(found) and _pattern_of(settings) in [
        job.order.facts["spec"].get("bake_name", OBJECT) for job in found
    ]


def _pattern_of(settings: BakeSettings) -> str:
    """What bakes by the settings are called, with all tokens filled in but the object's."""
    from ...core.errors import InputError
    from ...job.bake_request import with_quality
    from ...job.variants import named_in
    from ...settings.bake_names import OBJECT
    from ..settings.request import open_layout_of, spec_of, values_of

    if settings.bake_name == OBJECT:
        return OBJECT
    owner, values = settings.id_data, values_of(settings)
    scene = owner if isinstance(owner, bpy.types.Scene) else bpy.context.scene
    assert scene is not None  # None only while Blender starts
    try:
        return named_in(scene, with_quality(spec_of(values), open_layout_of(values))).bake_name
    except InputError:  # which the request's own checks report
        return str(settings.bake_name)


def _free(plan: BakePlan) -> tuple[Bake, ...]:
    """The bakes that are not already queued or running.

    Raises InputError if all are, or if any is and the request does not resume.
    """
    from ...core.errors import InputError
    from ...job.variants import variant_of
    from ...settings.bake_names import own_name
    from ...worker.order import Work
    from ...worker.orders import kind_of

    request = plan.request
    busy = {
        (job.object, job.order.about, job.order.part, job.order.variant, job.order.called)
        for job in _session.shown
        if not job.ended and job.work is Work.BAKE and job.out == request.folder
    }
    taken = [
        (name, spec)
        for name, spec in plan.wanted
        if (name, kind_of(spec), spec.part or "", variant_of(spec), own_name(spec.bake_name, name)) in busy
    ]
    free = tuple(bake for bake in plan.wanted if bake not in taken)
    if taken and not (request.resume and free):
        raise InputError(f"object '{taken[0][0]}' is being baked there already: wait for it, or cancel it")
    return free


def add(
    orders: Iterable[Order],
    completion: Completion | None = None,
    scenes: Sequence[BakedScene] = (),
    repeats: RepeatedExports | None = None,
) -> None:
    """Queue jobs, all with the same completion; the times of bakes, whose `scenes` are given, are kept.

    Once all of them have ended, the exports of `repeats` that are due are queued.
    """
    job_ends.forget()
    for order, scene in zip_longest(orders, scenes):
        number = _queue().add(order)
        if scene is not None:
            _session.scenes[number] = scene
        if completion is not None:
            _session.completions[number] = completion
        if repeats is not None:
            _session.repeats[number] = repeats
    _look()
    panel_state.mark_stale()  # their objects are being baked now


def snapshot() -> tuple[Job, ...]:
    """The state of all jobs at the last poll, including ended ones."""
    return _session.shown


def is_folded(job: Job) -> bool:
    """Whether the panel is to show a job in one line.

    Unless that was chosen by hand: jobs that wait, and those that ended before another did, but for failures.
    """
    if job.number in _session.folded:
        return _session.folded[job.number]
    if job.state in ("running", "failed"):
        return False
    return job.state in ("waiting", "left") or any(
        other.ended and other.number > job.number for other in _session.shown
    )


def fold(number: int) -> None:
    """Show the job with this number in one line, or with all that is known of it if it is."""
    for job in _session.shown:
        if job.number == number:
            _session.folded[number] = not is_folded(job)


def hides_warnings(job: Job) -> bool:
    """Whether the panel is to count the job's warnings in one line: several of one that has ended."""
    return job.ended and len(job.warnings) > 1 and job.number not in _session.warned


def fold_warnings(number: int) -> None:
    """Show the warnings of the ended job with this number, or their count alone."""
    _session.warned ^= {number}


def together() -> Together | None:
    """The bakes that were asked for together with the one that runs; None if there is no other."""
    from ...worker.together import together_of

    now = monotonic()
    spent = {number: now - begun for number, begun in _session.begun.items()}
    return together_of(_session.shown, spent)


def busy() -> bool:
    """Whether any job is running or waiting."""
    return any(not job.ended for job in _session.shown)


def cancel(number: int | None = None) -> None:
    """Ask one job to stop, or all of them."""
    if _session.queue is None:
        return
    if number is None:
        _session.queue.cancel_all()
    else:
        _session.queue.cancel(number)
    _look()


def forget_ended(number: int | None = None) -> None:
    """Remove one ended job, or all, from the panel's list, and delete their `results`."""
    if _session.queue is not None:
        _session.queue.forget_ended(number)
        _look()
        there = {job.number for job in _session.shown}
        for gone in _session.folded.keys() - there:
            del _session.folded[gone]
        for gone in _session.repeats.keys() - there:
            del _session.repeats[gone]
        _session.warned &= there
        for gone in _session.completions.keys() - there:
            _session.completions.pop(gone).clean_up()
        job_ends.forget(frozenset(there))


def advance() -> bool:
    """Read the workers' messages and start waiting jobs; returns whether any job is still active."""
    if _session.queue is None:
        return False
    more = _session.queue.advance()
    now = monotonic()
    before = {job.number for job in _session.shown if job.ended}
    _session.shown = _session.queue.snapshot()
    ended = [job for job in _session.shown if job.ended and job.number not in before]
    for job in _session.shown:
        if job.state == "running":
            _session.begun.setdefault(job.number, now)
    if ended:
        panel_state.mark_stale()  # there are new files
    for job in ended:
        job_files.note(job)
    look_at_files()
    more = _export_again(ended) or more
    _keep()
    for job in ended:
        _remember(job, now)
        if job.state == "done" and job.number in _session.completions:
            _session.completions[job.number].arrived(job)
    _session.untold |= {job.number for job in ended}
    if not more and _session.untold:
        untold = [job for job in _session.shown if job.number in _session.untold]
        _session.untold.clear()
        job_ends.tell(untold)
    return more


def _export_again(ended: Iterable[Job]) -> bool:
    """Queue the exports that follow bakes, once all that were asked for together have ended or are left.

    If the last of them was cancelled, so are the exports. Returns whether there are any.
    """
    from ...core.errors import RadTexError
    from ..settings.preferences import preferred

    assert _session.queue is not None  # its jobs have ended
    last: dict[RepeatedExports, Job] = {}
    for job in ended:
        repeats = None if job.state == "left" else _session.repeats.pop(job.number, None)
        if repeats is not None:
            last[repeats] = job
            if job.state == "done":
                repeats.note(job.object, job.files)
    active = {job.number for job in _session.shown if not job.ended}
    orders: list[Order] = []
    for repeats, job in last.items():
        waits = any(each is repeats for number, each in _session.repeats.items() if number in active)
        if waits or job.state == "cancelled":
            continue
        try:
            orders += repeats.orders(preferred().cache)
        except RadTexError as error:
            _log.warning("%s", error)
        repeats.made.clear()  # what is left of these bakes exports its own
    for order in orders:
        _session.queue.add(order)
    if orders:
        _session.shown = _session.queue.snapshot()
    return bool(orders)


def look_at_files() -> None:
    """Look whether the files of the jobs on the list are still those that the jobs made."""
    if job_files.look(_session.shown):
        redraw()


def _remember(job: Job, now: float) -> None:
    """Keep a finished bake's time, for estimates."""
    scene, begun = _session.scenes.pop(job.number, None), _session.begun.pop(job.number, None)
    if job.state == "done" and scene is not None and begun is not None:
        bake_times.remember_job(scene, job, now - begun)


def unregister() -> None:
    """End all workers, leave what they had to do to the next session, and clear the state."""
    for timer in (_pulse, _take_over):
        if bpy.app.timers.is_registered(timer):
            bpy.app.timers.unregister(timer)
    _end_session()
    atexit.unregister(_end_session)
    for completion in _session.completions.values():
        completion.clean_up()
    _session.queue, _session.shown = None, ()
    _session.completions.clear()
    _session.begun.clear()
    _session.scenes.clear()
    _session.repeats.clear()
    _session.folded.clear()
    _session.warned.clear()
    _session.untold.clear()
    job_files.unregister()
    pictures.unregister()


def _end_session() -> None:
    """End the worker, and leave the list to the next session if it is kept; also when Python ends."""
    if _session.queue is not None:
        _session.queue.close(leave=_session.kept is not None)
        _session.shown = _session.queue.snapshot()
        _keep(always=True)
    if _session.kept is not None:
        _session.kept.close()
    _session.kept = None


def _queue() -> Queue:
    from ...worker.handover import this_program
    from ...worker.queue import Queue

    if _session.queue is None:
        _session.queue = Queue(this_program())
    return _session.queue


def _look() -> None:
    """Poll now, and keep polling while jobs are active."""
    _pulse()
    if busy() and not bpy.app.timers.is_registered(_pulse):
        bpy.app.timers.register(_pulse, first_interval=_PULSE, persistent=True)


def _pulse() -> float | None:
    before = _as_drawn(_session.shown)
    more = advance()
    if pictures.update(_session.shown) or _as_drawn(_session.shown) != before:
        redraw()
    return _PULSE if more else None


def _as_drawn(shown: Iterable[Job]) -> list[tuple[Job, str]]:
    """The jobs with whole percents, and the time left in words, as exactly as the panel shows them."""
    from ...settings.time_left import told_left

    return [
        (
            replace(job, fraction=round(job.fraction, 2), left=None, course=None),
            told_left(job.left),
        )
        for job in shown
    ]
