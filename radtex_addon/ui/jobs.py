# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The window's jobs: a queue of workers, and a timer that hears them while there is anything to hear."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

import bpy

from . import panel_state, pictures
from .redraw import redraw

if TYPE_CHECKING:
    from ..bake.spec import BakeSpec
    from ..worker.job import Job
    from ..worker.order import Order
    from ..worker.queue import Queue
    from .request import BakeRequest

_PULSE = 0.25  # seconds between two looks at the workers


@dataclass(frozen=True)
class Sequel:
    """What comes after a job: `arrived` is called when it is done; `results` goes when it is forgotten."""

    arrived: Callable[[Job], None]
    results: TemporaryDirectory[str]


@dataclass
class _Session:
    """There is no queue before the first job, so that enabling RadTex loads nothing.

    `sequels` are those of jobs by number.
    """

    queue: Queue | None = None
    shown: tuple[Job, ...] = field(default=())
    sequels: dict[int, Sequel] = field(default_factory=dict)


_session = _Session()


def submit(scene: bpy.types.Scene, names: Iterable[str], request: BakeRequest) -> float:
    """Hand the scene over as it is now, and let a bake of each object wait its turn.

    Returns how long the session stood still for it, in seconds. Raises InputError where one of them waits or
    runs already, BakeError where the scene cannot be saved.
    """
    from ..core.sampler import Filter
    from ..worker.handover import hand_over
    from ..worker.orders import order_bake
    from .preferences import preferred

    bakes = _free(request.bakes(scene, tuple(names)), request)
    handover = hand_over(scene, preferred().cache)
    add(
        order_bake(
            handover,
            name,
            spec,
            request.folder,
            Filter.QUADRILINEAR if request.preview else None,
            overwrite=request.overwrite,
            extra=(
                f"--thumbnail={handover.folder / f'picture-{place}.png'}",
                *(("--resume",) if request.resume else ()),
                *(f"--export={target}" for target in request.targets),
            ),
        )
        for place, (name, spec) in enumerate(bakes)
    )
    return handover.stalled


def _free(bakes: tuple[tuple[str, BakeSpec], ...], request: BakeRequest) -> tuple[tuple[str, BakeSpec], ...]:
    """Those that are not being baked already; where it goes on with several, others of them may be.

    Raises InputError where one may not, or all are.
    """
    from ..core.errors import InputError
    from ..job.variants import variant_of
    from ..worker.order import Work
    from ..worker.orders import kind_of

    busy = {
        (job.object, job.order.about, job.order.part, job.order.variant)
        for job in _session.shown
        if not job.ended and job.work is Work.BAKE and job.out == request.folder
    }
    taken = [
        bake for bake in bakes if (bake[0], kind_of(bake[1]), bake[1].part or "", variant_of(bake[1])) in busy
    ]
    free = tuple(bake for bake in bakes if bake not in taken)
    if taken and not (request.resume and free):
        raise InputError(f"object '{taken[0][0]}' is being baked there already: wait for it, or cancel it")
    return free


def add(orders: Iterable[Order], sequel: Sequel | None = None) -> None:
    """Let jobs wait their turn, each with that sequel."""
    for order in orders:
        number = _queue().add(order)
        if sequel is not None:
            _session.sequels[number] = sequel
    _look()


def snapshot() -> tuple[Job, ...]:
    """All jobs as they were at the last pulse, those that have ended too."""
    return _session.shown


def busy() -> bool:
    """Whether a job runs or waits."""
    return any(not job.ended for job in _session.shown)


def cancel(number: int | None = None) -> None:
    """End one job politely, or all."""
    if _session.queue is None:
        return
    if number is None:
        _session.queue.cancel_all()
    else:
        _session.queue.cancel(number)
    _look()


def forget_ended() -> None:
    """Leave jobs that have ended out of the panel."""
    if _session.queue is not None:
        _session.queue.forget_ended()
        _look()
        for number in _session.sequels.keys() - {job.number for job in _session.shown}:
            _session.sequels.pop(number).results.cleanup()


def advance() -> bool:
    """Hear the workers, and start what waits; returns whether there is more to come."""
    if _session.queue is None:
        return False
    more = _session.queue.advance()
    before = {job.number for job in _session.shown if job.ended}
    _session.shown = _session.queue.snapshot()
    ended = [job for job in _session.shown if job.ended and job.number not in before]
    if ended:
        panel_state.mark_stale()  # there are new files
    for job in ended:
        if job.state == "done" and job.number in _session.sequels:
            _session.sequels[job.number].arrived(job)
    return more


def unregister() -> None:
    """End all workers, and forget them."""
    if bpy.app.timers.is_registered(_pulse):
        bpy.app.timers.unregister(_pulse)
    if _session.queue is not None:
        _session.queue.close()
    for sequel in _session.sequels.values():
        sequel.results.cleanup()
    _session.queue, _session.shown = None, ()
    _session.sequels.clear()
    pictures.unregister()


def _queue() -> Queue:
    from ..worker.handover import this_program
    from ..worker.queue import Queue

    if _session.queue is None:
        _session.queue = Queue(this_program())
    return _session.queue


def _look() -> None:
    """See at once what has changed, and go on looking."""
    _pulse()
    if busy() and not bpy.app.timers.is_registered(_pulse):
        bpy.app.timers.register(_pulse, first_interval=_PULSE, persistent=True)


def _pulse() -> float | None:
    before = _session.shown
    more = advance()
    if pictures.update(_session.shown) or _session.shown != before:
        redraw()
    return _PULSE if more else None
