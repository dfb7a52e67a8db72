# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A queue of orders: one worker at a time, each in its order's folder."""

from __future__ import annotations

import atexit
import os
import shutil
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from time import monotonic, time

from ..core.errors import RadTexError
from ..core.messages import Message
from ..formats.disk.atomic import remove_unfinished
from ..settings.time_left import time_left
from .job import Job, JobState
from .order import Order, Program, command_line, write_order
from .process import Worker
from .together import courses_before

_SIGN_OF_LIFE = 600.0  # seconds


@dataclass(eq=False)
class _Entry:
    job: Job
    started: float | None = None  # of `monotonic`


def _is_asked(job: Job, number: int | None) -> bool:
    return job.number == number if number is not None else job.state is not JobState.LEFT


class Queue:
    """Jobs, one after another. Call `advance` regularly, from one thread; only `close` waits.

    After a failed job the next one starts. An order's folder is deleted with the last of its jobs. When
    Python ends, the queue is closed.
    """

    def __init__(self, program: Program) -> None:
        self._program = program
        self._entries: list[_Entry] = []
        self._numbers = 0
        self._running: tuple[_Entry, Worker] | None = None
        self._last_sign = time()
        self._leaves = False
        atexit.register(self.close)

    def add(self, order: Order) -> int:
        """Add a job at the end; returns its number."""
        self._numbers += 1
        self._entries.append(_Entry(Job(self._numbers, order)))
        return self._numbers

    def adopt(self, jobs: Iterable[Job]) -> list[int]:
        """Add an ended session's jobs, which have ended or are LEFT; returns the numbers that they get."""
        adopted = [replace(job, number=number) for number, job in enumerate(jobs, self._numbers + 1)]
        self._entries += map(_Entry, adopted)
        self._numbers += len(adopted)
        return [job.number for job in adopted]

    def go_on(self, number: int) -> None:
        """Let a job that is LEFT wait for its turn."""
        for entry in self._entries:
            if entry.job.number == number and entry.job.state is JobState.LEFT:
                entry.job = entry.job.goes_on()

    def advance(self) -> bool:
        """Read the worker's events, and start the next job if it has ended; returns whether any is left."""
        if self._running is not None:
            self._hear(*self._running)
        if self._running is None:
            waiting = next((entry for entry in self._entries if entry.job.state is JobState.WAITING), None)
            if waiting is not None:
                self._start(waiting)
        self._show_life()
        return self.busy

    @property
    def busy(self) -> bool:
        """Whether a job runs or waits."""
        return any(not entry.job.ended for entry in self._entries)

    def snapshot(self) -> tuple[Job, ...]:
        """All jobs in order, ended ones too."""
        return tuple(entry.job for entry in self._entries)

    def cancel(self, number: int) -> None:
        """Cancel a job that runs, waits or is left; a running one is marked, and ends within two seconds."""
        for entry in self._entries:
            if entry.job.number == number and (not entry.job.ended or entry.job.state is JobState.LEFT):
                self._cancel(entry)

    def cancel_all(self) -> None:
        """Cancel every job that runs or waits."""
        for job in self.snapshot():
            self.cancel(job.number)

    def forget_ended(self, number: int | None = None) -> None:
        """Remove ended jobs from the list, but for those that are LEFT, or only the one with that number."""
        gone = [entry for entry in self._entries if entry.job.ended and _is_asked(entry.job, number)]
        self._entries = [entry for entry in self._entries if entry not in gone]
        for entry in gone:
            self._clear(entry.job.order.folder)

    def close(self, *, leave: bool = False) -> None:
        """Cancel all jobs and wait for their end, at most about two seconds.

        With `leave` those that wait or run are LEFT, and so are their folders, for another session.
        """
        atexit.unregister(self.close)
        self._leaves = leave
        for entry in self._entries:
            if leave and entry.job.state is JobState.WAITING:
                entry.job = entry.job.left_over()
        if not leave:
            self.cancel_all()
        if self._running is not None:
            entry, worker = self._running
            worker.close()
            self._hear(entry, worker)

    def _start(self, entry: _Entry) -> None:
        order = entry.job.order
        try:
            command = command_line(self._program, order, write_order(order))
            worker = Worker(command, order.folder, order.ended_early)
        except RadTexError as error:
            self._end(entry, JobState.FAILED, error.message)
            return
        except OSError as error:
            self._end(entry, JobState.FAILED, Message(str(error)))
            return
        self._running = entry, worker
        entry.started = monotonic()
        entry.job = entry.job.begins()

    def _hear(self, entry: _Entry, worker: Worker) -> None:
        now = 0.0 if entry.started is None else monotonic() - entry.started
        for event in worker.events():
            entry.job = entry.job.hears(event, now)
        if entry.job.course is not None:
            left = time_left(entry.job.course, now, courses_before(entry.job, self.snapshot()))
            entry.job = replace(entry.job, left=left)
        if worker.ended is None:
            return
        self._running = None
        worker.close()
        if worker.ended.state is not JobState.DONE:
            remove_unfinished(entry.job.out, worker.pid)
        entry.job = replace(entry.job, log=worker.ended.log)
        self._end(entry, worker.ended.state, worker.ended.message)

    def _cancel(self, entry: _Entry) -> None:
        if self._running is not None and entry is self._running[0]:
            entry.job = replace(entry.job, cancelling=True)
            self._running[1].cancel()
        else:
            self._end(entry, JobState.CANCELLED, Message("cancelled"))

    def _end(self, entry: _Entry, state: JobState, message: Message) -> None:
        took = None if entry.started is None else monotonic() - entry.started
        if self._leaves and state is JobState.CANCELLED and not entry.job.cancelling:
            entry.job = entry.job.left_over()
            return
        entry.job = entry.job.ends(state, message, took)
        self._clear(entry.job.order.folder)

    def _clear(self, folder: Path) -> None:
        """Delete a folder that no job needs any more."""
        if folder not in self._folders():
            shutil.rmtree(folder, ignore_errors=True)

    def _folders(self) -> set[Path]:
        """Folders that jobs still need."""
        jobs = self.snapshot()
        return {job.order.folder for job in jobs if not job.ended or job.state is JobState.LEFT}

    def _show_life(self) -> None:
        """Update the folders' times: other Blenders delete folders that look abandoned (`handover`)."""
        if (
            abs(time() - self._last_sign) > _SIGN_OF_LIFE
        ):  # the wall's clock, which goes on in sleep, and jumps
            self._last_sign = time()
            for folder in self._folders():
                with suppress(OSError):
                    os.utime(folder)
