# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of bakes that fill up: icons that the panel draws, loaded beside drawing."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bpy.utils import previews

if TYPE_CHECKING:
    from ..worker.job import Job


@dataclass
class _Album:
    """`collection` is Blender's; `shown` says of each job which picture, as it was when."""

    collection: Any = None
    shown: dict[int, tuple[Path, int]] = field(default_factory=dict)


_album = _Album()


def update(jobs: Iterable[Job]) -> bool:
    """Load the pictures of running jobs that are new, drop the others; returns whether any has changed."""
    running = {job.number: job.picture for job in jobs if not job.ended and job.picture is not None}
    found = {number: stamp for number, path in running.items() if (stamp := _stamp(path)) is not None}
    if found == _album.shown:
        return False
    if _album.collection is None:
        _album.collection = previews.new()
    _album.collection.clear()  # a file is loaded once under a name
    for number, (path, _) in found.items():
        picture = _album.collection.load(str(number), str(path), "IMAGE")
        picture.image_size[:]  # or it would be read when it is drawn
    _album.shown = found
    return True


def icon(job: Job) -> int:
    """The number of its picture's icon; 0 where it has none."""
    return int(_album.collection[str(job.number)].icon_id) if job.number in _album.shown else 0


def unregister() -> None:
    """Give the icons back."""
    if _album.collection is not None:
        previews.remove(_album.collection)
    _album.collection = None
    _album.shown.clear()


def _stamp(path: Path) -> tuple[Path, int] | None:
    try:
        return path, path.stat().st_mtime_ns
    except OSError:  # the worker has gone, and its folder too
        return None
