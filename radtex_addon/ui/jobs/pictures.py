# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Thumbnails of running bakes, and pictures of UV maps, as icons for the panel, loaded outside of drawing."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
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
    time (ns) of the loaded file. `maps` are the pictures of jobs' UV maps, by the jobs' numbers; of those
    that are `unfolded` the panel shows them.
    """

    collection: Any = None
    shown: dict[int, tuple[Path, int]] = field(default_factory=dict)
    maps: Any = None
    unfolded: set[int] = field(default_factory=set)


_album = _Album()


def update(jobs: Iterable[Job]) -> bool:
    """Reload the thumbnails of running jobs if any has changed, load new maps; returns whether any was."""
    jobs = tuple(jobs)
    mapped = _update_maps(jobs)
    running = {job.number: job.picture for job in jobs if not job.ended and job.picture is not None}
    found = {number: stamp for number, path in running.items() if (stamp := _stamp(path)) is not None}
    if found == _album.shown:
        return mapped
    if _album.collection is None:
        _album.collection = previews.new()
    _album.collection.clear()  # load() refuses a name that is in use
    for number, (path, _) in found.items():
        _load(_album.collection, number, path)
    _album.shown = found
    return True


def icon(job: Job) -> int:
    """The icon number of the job's thumbnail; 0 if it has none."""
    return int(_album.collection[str(job.number)].icon_id) if job.number in _album.shown else 0


def unfolded_map(job: Job) -> Any:
    """The picture of the job's UV map, one of Blender's previews; None if it has none, or is folded."""
    if _album.maps is None or not is_unfolded(job):
        return None
    return _album.maps.get(str(job.number))


def is_unfolded(job: Job) -> bool:
    """Whether the panel is to show the job's UV map."""
    return job.number in _album.unfolded


def toggle_map(number: int) -> None:
    """Show the UV map of the job with this number in the panel, or hide it."""
    _album.unfolded ^= {number}


def unregister() -> None:
    """Free the icons."""
    for collection in (_album.collection, _album.maps):
        if collection is not None:
            previews.remove(collection)
    _album.collection = _album.maps = None
    _album.shown.clear()
    _album.unfolded.clear()


def _update_maps(jobs: Sequence[Job]) -> bool:
    """Load the maps that are not loaded yet; returns whether there are any.

    A map that was loaded stays so when its job ends and its file is deleted. Once jobs are taken off the
    list, all are freed, and loaded anew for the others, which still have their files.
    """
    files = {str(job.number): job.map.picture for job in jobs if job.map is not None}
    _album.unfolded &= {job.number for job in jobs}
    if _album.maps is None:
        _album.maps = previews.new() if files else None
    if _album.maps is None:
        return False
    if not _album.maps.keys() <= files.keys():
        _album.maps.clear()
    new = {name: path for name, path in files.items() if name not in _album.maps and path.is_file()}
    for name, path in new.items():
        _load(_album.maps, int(name), path)
    return bool(new)


def _load(collection: Any, number: int, path: Path) -> None:
    picture = collection.load(str(number), str(path), "IMAGE")
    picture.image_size[:]  # load the file now, not when the panel is drawn


def _stamp(path: Path) -> tuple[Path, int] | None:
    try:
        return path, path.stat().st_mtime_ns
    except OSError:  # the worker has ended and its folder is deleted
        return None
