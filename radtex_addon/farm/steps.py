# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A farm's tasks in a few steps, for programs that run farms: these know dependencies of steps alone."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import count

from .tasks import Task

STEPS = 100  # most steps of a farm, where TASKS allows it: there is a call of sbatch for each
TASKS = 1000  # most tasks of a step: Slurm takes 1001 in an array by default, OpenJD 1024 of a parameter
_LABEL = 40  # most letters of a bake in a step's name; OpenJD's limit is 64 in all


@dataclass(frozen=True)
class Step:
    """Tasks that can be done at the same time, when all tasks of the steps that it `needs` are done."""

    name: str
    tasks: tuple[Task, ...]
    needs: tuple[str, ...]

    @property
    def memory(self) -> int:
        """Bytes that one of its tasks takes at most."""
        return max(task.memory for task in self.tasks)

    @property
    def seconds(self) -> float:
        """Seconds of a processor core that one of its tasks takes at most."""
        return max(task.seconds for task in self.tasks)

    @property
    def is_rendered(self) -> bool:
        """Whether its tasks are frames, which Blender renders."""
        return self.tasks[0].is_frame

    @property
    def is_last(self) -> bool:
        """Whether it makes the files of bakes."""
        return any(task.is_last for task in self.tasks)


def steps_of(tasks: Sequence[Task], most: int = STEPS) -> list[Step]:
    """The tasks in at most about so many steps, each behind those that it needs.

    A step holds one part of one bake; where these are too many, the same part of as few bakes as it takes.
    """
    bakes = {bake: number for number, bake in enumerate(dict.fromkeys(task.bake for task in tasks))}
    levels = _levels(tasks)
    size = 1  # bakes in a step
    while True:
        found = _steps(tasks, levels, {bake: number // size for bake, number in bakes.items()})
        if len(found) <= most or size >= len(bakes):
            return found
        size = min(len(bakes), max(size + size // 4 + 1, size * len(found) // most))


def _levels(tasks: Sequence[Task]) -> dict[str, int]:
    """How many tasks come before each one, one after another."""
    levels: dict[str, int] = {}
    for task in tasks:
        levels[task.name] = 1 + max((levels[need] for need in task.needs), default=-1)
    return levels


def _steps(tasks: Sequence[Task], levels: Mapping[str, int], batches: Mapping[str, int]) -> list[Step]:
    """A step for each level, batch of bakes, and part: what it needs is of lower levels."""
    groups: dict[tuple[int, int, str], list[Task]] = {}
    for task in tasks:
        groups.setdefault((levels[task.name], batches[task.bake], task.part), []).append(task)
    labels = _labels(batches)
    step_of: dict[str, str] = {}
    taken: set[str] = set()
    found: list[Step] = []
    for (_, batch, part), group in sorted(groups.items(), key=lambda item: item[0][:2]):
        for begin in range(0, len(group), TASKS):
            some = tuple(group[begin : begin + TASKS])
            name = next(name for name in _numbered(f"{labels[batch]}.{part}") if name not in taken)
            taken.add(name)
            needs = dict.fromkeys(step_of[need] for task in some for need in task.needs)
            step_of |= dict.fromkeys((task.name for task in some), name)
            found.append(Step(name, some, tuple(needs)))
    return found


def _labels(batches: Mapping[str, int]) -> dict[int, str]:
    """What each batch is called: a bake's key, or the numbers of its first and last bake."""
    members: dict[int, list[tuple[int, str]]] = {}
    for number, (bake, batch) in enumerate(batches.items(), start=1):
        members.setdefault(batch, []).append((number, bake))
    return {
        batch: some[0][1][:_LABEL] if len(some) == 1 else f"bakes_{some[0][0]}-{some[-1][0]}"
        for batch, some in members.items()
    }


def _numbered(name: str) -> Iterator[str]:
    yield name
    yield from (f"{name}_{number}" for number in count(2))
