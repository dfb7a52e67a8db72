# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether the files of finished jobs are still those that the jobs made, looked up outside of drawing."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    from ...worker.job import Job

_NOTED = frozenset({"bake", "export", "preparation", "assembly"})  # work whose files stay
_FOLDERS = frozenset({"export", "preparation"})  # work that makes folders

_Mark: TypeAlias = tuple[int, ...] | None  # tells a file from one that was put in its place; None: not there


class Fate(StrEnum):
    """What has become of a job's files."""

    THERE = "there"
    GONE = "gone"
    REPLACED = "replaced"


@dataclass
class _Known:
    """By job numbers: marks and sizes in bytes that its files had at its end, and their fate since."""

    marks: dict[int, dict[Path, _Mark]] = field(default_factory=dict)
    sizes: dict[int, tuple[int, ...]] = field(default_factory=dict)
    fates: dict[int, Fate] = field(default_factory=dict)


_known = _Known()


def note(job: Job) -> None:
    """Remember the files of a bake, an export or a farm that has just been done."""
    if job.state != "done" or job.work not in _NOTED:
        return
    _known.marks[job.number] = {path: _mark(path) for path in job.files if _is_own(job, path)}
    _known.sizes[job.number] = tuple(path.stat().st_size for path in job.files if path.is_file())
    _known.fates[job.number] = Fate.THERE


def look(jobs: Iterable[Job]) -> bool:
    """Look for the files of all jobs that are on the list; returns whether the fate of any is another now."""
    numbers = {job.number for job in jobs}
    for number in _known.marks.keys() - numbers:
        for kept in (_known.marks, _known.sizes, _known.fates):
            kept.pop(number)
    before = dict(_known.fates)
    _known.fates |= {number: _fate(marks) for number, marks in _known.marks.items()}
    return _known.fates != before


def fate(number: int) -> Fate:
    """What had become of a job's files when they were looked for last."""
    return _known.fates.get(number, Fate.THERE)


def fate_now(number: int) -> Fate:
    """What has become of them by now, before a button of the job does something with them."""
    if number in _known.marks:
        _known.fates[number] = _fate(_known.marks[number])
    return fate(number)


def sizes(number: int) -> tuple[int, ...]:
    """Bytes of each of the job's files, as it made them."""
    return _known.sizes.get(number, ())


def unregister() -> None:
    """Forget all jobs."""
    for kept in (_known.marks, _known.sizes, _known.fates):
        kept.clear()


def _is_own(job: Job, path: Path) -> bool:
    """Whether the file is what the job is about: of a bake its preview, which its owner may edit, is not."""
    return job.work in _FOLDERS or not (path.is_dir() or path.name.endswith(".preview.blend"))


def _fate(marks: dict[Path, _Mark]) -> Fate:
    now = {path: _mark(path) for path in marks}
    if now == marks:
        return Fate.THERE
    there = any(mark is not None and mark != marks[path] for path, mark in now.items())
    return Fate.REPLACED if there else Fate.GONE


def _mark(path: Path) -> _Mark:
    """A folder is told by its number alone, for its owner may put files into it."""
    try:
        found = path.stat()
    except OSError:
        return None
    return (found.st_ino,) if path.is_dir() else (found.st_ino, found.st_mtime_ns, found.st_size)
