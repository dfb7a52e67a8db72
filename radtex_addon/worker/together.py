# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How far several bakes that were asked for together have come as a whole, for one bar over all."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ..settings.time_left import Course, Left, time_left
from .job import Job, JobState
from .order import Work


@dataclass(frozen=True)
class Together:
    """Of `count` bakes so many are `done`, a `fraction` of the work, 0 to 1.

    `left` is the time left of all of them.
    """

    done: int
    count: int
    fraction: float
    left: Left | None


def together_of(jobs: Sequence[Job], spent: Mapping[int, float]) -> Together | None:
    """The bakes that were asked for together with the one that runs; None if that is the only one.

    Those are asked for together that have one folder. `spent` are the seconds since each running job began,
    by its number. Bakes that failed or were cancelled count as done work.
    """
    running = next((job for job in jobs if job.state is JobState.RUNNING and job.work is Work.BAKE), None)
    if running is None:
        return None
    others = [
        job
        for job in jobs
        if job.work is Work.BAKE
        and job.order.folder == running.order.folder
        and job.state is not JobState.LEFT
    ]
    if len(others) < 2:
        return None
    whole = sum(job.order.seconds for job in others)
    reached = sum(job.order.seconds * (1.0 if job.ended else job.fraction) for job in others)
    done = sum(job.ended for job in others)
    left = _left(others, running, spent.get(running.number, 0.0))
    return Together(done, len(others), reached / whole if whole else done / len(others), left)


def courses_before(running: Job, jobs: Sequence[Job]) -> list[Course]:
    """The courses of bakes that are done, of those asked for together with `running`, the latest last.

    Those that were done when it was asked for are in what it is expected to take.
    """
    return [
        job.course
        for job in jobs
        if (job.work, job.order.folder) == (running.work, running.order.folder)
        and job.state is JobState.DONE
        and job.course is not None
    ]


def _left(jobs: Sequence[Job], running: Job, now: float) -> Left | None:
    """The time left of the running job, and of those that wait for it."""
    if running.course is None:
        return None
    waiting = [job.order.course.expected for job in jobs if job.state is JobState.WAITING]
    return time_left(running.course, now, courses_before(running, jobs), waiting)
