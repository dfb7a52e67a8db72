# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Thumbnails of running bakes as icons for the panel, loaded outside of drawing."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bpy.utils import previews

if TYPE_CHECKING:
    from ...worker.job import Job


@dataclass
class _Album:
    """Loaded thumbnails.

    `collection` is Blender's preview collection; `shown` maps job numbers to the path and the modification
    time (ns) of the loaded file.
    """

    collection: Any = None
    shown: dict[int, tuple[Path, int]] = field(default_factory=dict)


_album = _Album()


def update(jobs: Iterable[Job]) -> bool:
    """Reload the thumbnails of running jobs if any has changed; returns whether one has."""
    running = {job.number: job.picture for job in jobs if not job.ended and job.picture is not None}
    found = {number: stamp for number, path in running.items() if (stamp := _stamp(path)) is not None}
    if found == _album.shown:
        return False
    if _album.collection is None:
        _album.collection = previews.new()
    _album.collection.clear()  # load() refuses a name that is in use
    for number, (path, _) in found.items():
        picture = _album.collection.load(str(number), str(path), "IMAGE")
        picture.image_size[:]  # load the file now, not when the panel is drawn
    _album.shown = found
    return True


def icon(job: Job) -> int:
    """The icon number of the job's thumbnail; 0 if it has none."""
    return int(_album.collection[str(job.number)].icon_id) if job.number in _album.shown else 0


def unregister() -> None:
    """Free the icons."""
    if _album.collection is not None:
        previews.remove(_album.collection)
    _album.collection = None
    _album.shown.clear()


def _stamp(path: Path) -> tuple[Path, int] | None:
    try:
        return path, path.stat().st_mtime_ns
    except OSError:  # the worker has ended and its folder is deleted
        return None
