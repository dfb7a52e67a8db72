# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The list of a session's jobs on disk, so that the next Blender shows it, however this one ended.

A worker ends with its Blender. Its list stays, and the folders with the copies of the scene, if a bake was
not finished or failed. Each session locks its own list: one that nobody locks is of a Blender that has ended.
"""

from __future__ import annotations

import logging
import shutil
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from time import time
from typing import Any, NamedTuple
from uuid import uuid4

from ..core.errors import FormatError, RadTexError
from ..core.messages import Message
from ..formats.disk.atomic import write_text
from ..formats.disk.lock import HeldError, Lock, take_lock
from ..formats.json_reader import Facts, json_text
from ..formats.sidecar_file import read_text
from .job import Job, JobState
from .order import Order, Work

log = logging.getLogger(__name__)

_PREFIX = "radtex-list-"
_KEPT = frozenset(
    {Work.BAKE, Work.EXPORT, Work.PREPARATION, Work.ASSEMBLY}
)  # the results of others are for the session that asked
_WORTH = frozenset({JobState.WAITING, JobState.RUNNING, JobState.LEFT, JobState.FAILED})
_OLD = 30 * 24 * 3600.0  # seconds after which a list that nobody took over is deleted, with its folders


class FollowUp(NamedTuple):
    """What is to follow the jobs with these numbers once they have ended, in JSON's types."""

    numbers: tuple[int, ...]
    facts: dict[str, Any]


class LeftList(NamedTuple):
    """A list that an ended session left: its file, held by `lock`, its jobs, and what is to follow them."""

    path: Path
    lock: Lock
    jobs: tuple[Job, ...]
    follow_ups: tuple[FollowUp, ...] = ()

    def remove(self) -> None:
        """Delete the file, once its jobs are on another list."""
        self.path.unlink(missing_ok=True)
        self.lock.release()


class KeptJobs:
    """A session's list in `folder`; `made_by` are the versions that can go on with it."""

    def __init__(self, folder: Path, made_by: str) -> None:
        self._path = folder / f"{_PREFIX}{uuid4().hex}.json"
        self._made_by = made_by
        self._lock: Lock | None = None
        self._written: list[tuple[int, JobState]] = []

    def write(
        self, jobs: Iterable[Job], follow_ups: Iterable[FollowUp] = (), *, always: bool = False
    ) -> None:
        """Write the list if a job's state is another, or `always`; without one that is worth it, delete it.

        What follows jobs is written with them, and changes only when one of their states does. Where the
        system refuses, a warning is logged.
        """
        kept = [job for job in jobs if job.work in _KEPT]
        if not any(job.state in _WORTH for job in kept):
            kept = []
        states = [(job.number, job.state) for job in kept]
        if states == self._written and not always:
            return
        self._written = states
        try:
            if not kept:
                self._path.unlink(missing_ok=True)
                return
            self._path.parent.mkdir(parents=True, exist_ok=True)
            self._lock = self._lock or take_lock(_lock_of(self._path))
            facts = {
                "made_by": self._made_by,
                "jobs": [_facts_of(job) for job in kept],
                "follow_ups": _follow_up_facts(kept, follow_ups),
            }
            write_text(self._path, json_text(facts))
        except (OSError, RadTexError, HeldError) as error:
            log.warning("the list of bakes cannot be kept for the next start: %s", error)

    def close(self) -> None:
        """Leave the list to the next session."""
        if self._lock is not None:
            self._lock.release()
            self._lock = None


def left_lists(folder: Path, made_by: str) -> Iterator[LeftList]:
    """The lists of sessions that have ended. Their jobs have ended, too, or are LEFT.

    What other versions began, or whose copy of the scene is gone, is FAILED and says what to do. Lists that
    cannot be read are deleted.
    """
    for path in sorted(folder.glob(f"{_PREFIX}*.json")):
        try:
            lock = take_lock(_lock_of(path))
        except (HeldError, OSError):
            continue
        if not lock.is_sure:  # nobody knows whether its Blender lives
            lock.release()
            continue
        found = LeftList(path, lock, ())
        try:
            facts = Facts.parse(read_text(path), str(path), "list of jobs")
            can_go_on = facts.text("made_by") == made_by
            jobs = tuple(_left(job, can_go_on) for job in _jobs_in(facts))
            follow_ups = _follow_ups_in(facts)
        except FormatError as error:
            log.warning("%s", error)
            found.remove()
            continue
        yield found._replace(jobs=jobs, follow_ups=follow_ups)


def kept_folders(folder: Path) -> set[Path]:
    """The folders that lists in `folder` still need. Lists that are too old are deleted, and theirs."""
    kept: set[Path] = set()
    for path in folder.glob(f"{_PREFIX}*.json"):
        try:
            old = time() - path.stat().st_mtime > _OLD
            jobs = _jobs_in(Facts.parse(read_text(path), str(path), "list of jobs"))
        except (FormatError, OSError):
            continue
        needed = {job.order.folder for job in jobs if job.state is not JobState.DONE}
        if old and _is_free(path):
            path.unlink(missing_ok=True)
            for each in needed:
                shutil.rmtree(each, ignore_errors=True)
        else:
            kept |= needed
    return kept


def _is_free(path: Path) -> bool:
    with suppress(HeldError, OSError):
        lock = take_lock(_lock_of(path))
        lock.release()
        return lock.is_sure
    return False


def _lock_of(path: Path) -> Path:
    return path.with_suffix(".lock")


def _left(job: Job, can_go_on: bool) -> Job:
    """The job of a session that has ended, as the next one takes it over."""
    if job.state in (JobState.DONE, JobState.FAILED, JobState.CANCELLED):
        return job
    source = job.order.blend or job.order.folder
    why = ""
    if not can_go_on:
        why = "Blender ended, and another version of Blender or RadTex is open now"
    elif not source.exists():
        why = "Blender ended, and the copy of its scene is gone"
    if why:
        return replace(job, state=JobState.FAILED, message=Message(f"{why}: open its .blend and resume it"))
    return job.left_over()


def _facts_of(job: Job) -> dict[str, Any]:
    order = job.order
    return {
        "state": job.state,
        "begun": job.begun,
        "fraction": job.fraction,
        "message": job.message.facts(),
        "warnings": [warning.facts() for warning in job.warnings],
        "files": [str(path) for path in job.files],
        "result": dict(job.facts),
        "took": job.took,
        "log": job.log,
        "order": {
            "work": order.work,
            "object": order.object,
            "folder": str(order.folder),
            "out": str(order.out),
            "facts": dict(order.facts),
            "stages": dict(order.stages),
            "remedy": order.remedy,
            "about": order.about,
            "part": order.part,
            "variant": order.variant,
            "shared": list(order.shared),
            "called": order.called,
            "seconds": order.seconds,
            "blend": None if order.blend is None else str(order.blend),
        },
    }


def _follow_up_facts(jobs: Sequence[Job], follow_ups: Iterable[FollowUp]) -> list[dict[str, Any]]:
    """The same in JSON's types, the jobs numbered from 1 as they are on the list."""
    places = {job.number: place for place, job in enumerate(jobs, 1)}
    return [
        {"jobs": [places[number] for number in each.numbers if number in places], "facts": each.facts}
        for each in follow_ups
    ]


def _follow_ups_in(facts: Facts) -> tuple[FollowUp, ...]:
    """What follows the jobs of a list, these numbered from 1. Raises FormatError."""
    try:
        told = facts.values.get("follow_ups", [])
        return tuple(FollowUp(tuple(map(int, each["jobs"])), dict(each["facts"])) for each in told)
    except (KeyError, TypeError, ValueError) as error:
        raise FormatError(f"{facts.source} is no list of jobs that RadTex wrote ({error!r})") from error


def _jobs_in(facts: Facts) -> Sequence[Job]:
    """The jobs of a list, numbered from 1. Raises FormatError."""
    try:
        return [_job(number, told) for number, told in enumerate(facts.values["jobs"], 1)]
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise FormatError(f"{facts.source} is no list of jobs that RadTex wrote ({error!r})") from error


def _job(number: int, told: dict[str, Any]) -> Job:
    order = told["order"]
    read = Order(
        work=Work(order["work"]),
        object=str(order["object"]),
        folder=Path(order["folder"]),
        out=Path(order["out"]),
        facts=dict(order["facts"]),
        stages={str(stage): float(share) for stage, share in order["stages"].items()},
        remedy=str(order["remedy"]),
        about=str(order["about"]),
        part=str(order["part"]),
        variant=str(order["variant"]),
        shared=tuple(map(str, order["shared"])),
        called=str(order.get("called", "")),
        seconds=float(order["seconds"]),
        blend=None if order["blend"] is None else Path(order["blend"]),
    )
    return Job(
        number,
        read,
        state=JobState(told["state"]),
        begun=bool(told["begun"]),
        fraction=float(told["fraction"]),
        message=Message.of_facts(told["message"]),
        warnings=tuple(map(Message.of_facts, told["warnings"])),
        files=tuple(map(Path, told["files"])),
        facts=dict(told["result"]),
        took=None if told["took"] is None else float(told["took"]),
        log=str(told["log"]),
    )
