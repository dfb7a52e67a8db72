# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How far several bakes that were asked for together have come as a whole, for one bar over all."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from .job import Job, JobState
from .order import Work

_LEAST = 0.02  # of a running job, before its pace is told


@dataclass(frozen=True)
class Together:
    """Of `count` bakes so many are `done`, a `fraction` of the work, 0 to 1.

    `seconds_left` is None while it is not known.
    """

    done: int
    count: int
    fraction: float
    seconds_left: float | None


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
    return Together(
        done, len(others), reached / whole if whole else done / len(others), _left(others, running, spent)
    )


def _left(jobs: Sequence[Job], running: Job, spent: Mapping[int, float]) -> float | None:
    """Seconds left by the pace of what is done, beside what the running job says of itself."""
    finished = [job for job in jobs if job.state is JobState.DONE and job.took is not None]
    took = sum(job.took or 0.0 for job in finished)
    work = sum(job.order.seconds for job in finished)
    if running.fraction >= _LEAST:
        took += spent.get(running.number, 0.0)
        work += running.fraction * running.order.seconds
    if not (took and work):
        return None
    pace = took / work
    own = running.seconds_left
    if own is None:
        own = pace * running.order.seconds * (1.0 - running.fraction)
    return own + pace * sum(job.order.seconds for job in jobs if job.state is JobState.WAITING)
