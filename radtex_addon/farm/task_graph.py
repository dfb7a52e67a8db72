# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The tasks of bakes: what can be done by itself, what it needs, and about how long it takes."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import count
from math import ceil

from ..bake.progress import Stage
from ..cycles.sampling import TILE_PIXELS
from ..forms.layered.capture.parts import Part
from ..settings.estimate import BakeWork, typical_seconds
from ..settings.layered_times import LayeredTimes
from ..settings.rays import LayeredRays
from ..settings.spec import BakeSpec
from .tasks import WHOLE, FarmBake, Task

SECONDS = 60.0  # of a task that is a share of a part
BEGIN = 5.0  # seconds of a task before its first render: starting, opening the scene, reading the mesh
_READ = 1e-6  # seconds of a path that is read from a frame
_UNNAMED = re.compile(r"[^A-Za-z0-9_]+")
_NAME = 60  # most letters of a bake's key


@dataclass(frozen=True)
class Subject:
    """What is known of a bake: `is_clear` if it may let light through, its surface's `triangles`."""

    name: str
    spec: BakeSpec
    is_clear: bool
    triangles: int


def keyed(subjects: Sequence[Subject]) -> list[FarmBake]:
    """The bakes with their keys, which differ, also where case does not count."""
    found: list[FarmBake] = []
    taken: set[str] = set()
    for one in subjects:
        frame = "" if one.spec.frame is None else f"-{one.spec.frame}"
        words = (one.name + frame, *one.spec.lights, one.spec.part or "")
        name = (
            "-".join(filter(None, (_UNNAMED.sub("_", word).strip("_") for word in words)))[:_NAME] or "bake"
        )
        key = next(key for key in _numbered(name) if key.lower() not in taken)
        taken.add(key.lower())
        found.append(FarmBake(key, one.name, one.spec))
    return found


def _numbered(name: str) -> Iterator[str]:
    yield name
    yield from (f"{name}_{number}" for number in count(2))


def tasks_of(
    bakes: Sequence[FarmBake], subjects: Sequence[Subject], memory: int, frames: bool = False
) -> list[Task]:
    """All tasks, each behind those that it needs; each takes `memory` bytes for the scene, and its own.

    With `frames` light and ends of layered bakes are rendered elsewhere: see `part_frames`.
    """
    found: list[Task] = []
    for bake, subject in zip(bakes, subjects, strict=True):
        if bake.spec.form.by_paths:
            found += _layered(bake, subject, memory, frames)
        else:
            found.append(_whole(bake, subject, memory))
    return found


def _work(bake: FarmBake, subject: Subject) -> BakeWork:
    return BakeWork.of(bake.spec, subject.triangles, device=bake.spec.device)


def _whole(bake: FarmBake, subject: Subject, memory: int) -> Task:
    """The task of a bake that cannot be parted."""
    seconds = sum(typical_seconds(_work(bake, subject)).values())
    return Task(bake.last, bake.key, WHOLE, (), round(seconds, 1), memory + bake.spec.atlas_bytes)


def _layered(bake: FarmBake, subject: Subject, memory: int, frames: bool) -> Iterator[Task]:
    """The tasks of a bake in the layered layout."""
    work = _work(bake, subject)
    stages, rays = typical_seconds(work), LayeredRays.of(bake.spec.samples)
    times = LayeredTimes(work.covered, rays)
    capture, around = times.capture, times.around_clear if subject.is_clear else times.around
    before = sum(stages[str(stage)] for stage in (Stage.EVALUATE, Stage.RASTER, Stage.PROBE))
    before += stages.get(str(Stage.UNWRAP), 0.0)
    begin = BEGIN + stages[str(Stage.EVALUATE)] + stages[str(Stage.RASTER)]
    last = stages[str(Stage.FIT)] + stages[str(Stage.WRITE)]
    samples = memory + bake.spec.atlas_bytes // 2

    def task(part: str, needs: tuple[str, ...], seconds: float, bytes_taken: int = memory) -> Task:
        return Task(f"{bake.key}.{part}", bake.key, str(part), needs, round(begin + seconds, 1), bytes_taken)

    def shared(part: Part, needs: tuple[str, ...], seconds: float, cells: int) -> tuple[Task, ...]:
        tiles = ceil(work.covered * cells / TILE_PIXELS)
        shares = max(1, min(tiles, round(seconds / SECONDS)))
        return tuple(
            Task(
                f"{bake.key}.{part}.{number + 1}" if shares > 1 else f"{bake.key}.{part}",
                bake.key, str(part), needs, round(begin + seconds / shares, 1), memory, (number, shares),
            )
            for number in range(shares)
        )  # fmt: skip

    maps = task(Part.MAPS, (), before + capture["maps"])
    ready = (maps.name,)
    read = work.covered * _READ if frames else 0.0
    ends = shared(Part.ENDS, ready, 2 * read * rays.ends**2 or capture["ends"], rays.ends**2)
    light = shared(Part.LIGHT, ready, read * rays.light**2 or capture["light"], rays.light**2)
    of_light, of_ends = _names(light), _names(ends)
    more = shared(Part.MORE_LIGHT, of_light, capture["more light"], rays.light**2)
    own = task(Part.OWN, ready, capture["own"])
    clear = (*of_ends, *of_light) if subject.is_clear else ()  # whether it lets light through, they tell
    pictures = task(Part.AROUND, (*ready, *clear), around["pictures"])
    misled = task(Part.MISLED, (own.name, pictures.name), around["misled"], samples)
    exits = (task(Part.EXITS, (*ready, *clear), around["exits"]),) if subject.is_clear else ()
    made = (maps, *ends, *light, *more, own, pictures, *exits, misled)
    needed = {need for each in made for need in each.needs}
    left = tuple(each.name for each in made if each.name not in needed)
    yield from made
    yield task(WHOLE, left, last, memory + bake.spec.atlas_bytes)


def _names(tasks: tuple[Task, ...]) -> tuple[str, ...]:
    return tuple(task.name for task in tasks)
