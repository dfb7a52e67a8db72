# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A farm of tasks beside one process: its tasks, chain and overhead, by several workers, and killed ones.

`python -m tests.bench.farm_tasks room.blend --workers 1 2 --kills 30 --out DIR -- --all --samples 4`; what
follows the -- are options of a bake. Each worker is a `bake.py work FOLDER` of its own. Files are compared
with those of one process, to the last bit. Kills hit a random worker at random moments; another takes its
place.
"""

from __future__ import annotations

import argparse
import os
import random
import shutil
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter, sleep

from radtex_addon.farm.tasks import TaskFarm, read_tasks
from tests.blender.killed import digests

_ROOT = Path(__file__).resolve().parents[2]
_BAKE = [sys.executable, str(_ROOT / "bake.py")]
_QUIET = ["--progress", "none"]
_MADE = ("done", "pieces", "baked", "claims")


@dataclass(frozen=True)
class Cost:
    """Seconds by the clock, and of processors."""

    clock: float
    processors: float


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scene", type=Path)
    parser.add_argument("--workers", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--kills", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, required=True)
    words = [*sys.argv[1:], "--"]
    asked, bake = parser.parse_args(words[: words.index("--")]), words[words.index("--") + 1 : -1]
    local, far = asked.out / "one", asked.out / "farm"
    shutil.rmtree(asked.out, ignore_errors=True)
    alone = run([*_BAKE, str(asked.scene), *bake, "--out", str(local), *_QUIET])
    print(f"one process: {told(alone)}", flush=True)
    prepared = run([*_BAKE, "prepare", str(asked.scene), *bake, "--out", str(far), *_QUIET])
    (folder,) = far.glob("*.radtex-farm")
    print(f"prepared: {told(prepared)}, {len(read_tasks(folder).tasks)} tasks", flush=True)
    for count in asked.workers:
        forget(folder)
        cost = work(folder, count)
        farm = read_tasks(folder)
        print(f"{count} workers: {told(cost)}; {graph(farm)}", flush=True)
        print(f"  {assembled(farm, local, asked.out / f'by-{count}')}", flush=True)
    if asked.kills:
        forget(folder)
        killed_work(folder, asked.kills, asked.seed)
        print(f"  {assembled(read_tasks(folder), local, asked.out / 'killed')}", flush=True)


def told(cost: Cost) -> str:
    return f"{cost.clock:.0f} s, {cost.processors:.0f} s of processors"


def run(command: Sequence[str]) -> Cost:
    """Run a command to its end. Raises SystemExit if it fails."""
    return awaited([subprocess.Popen(command, cwd=_ROOT, stdout=subprocess.DEVNULL)])


def awaited(processes: list[subprocess.Popen[bytes]]) -> Cost:
    begun, processors = perf_counter(), 0.0
    for process in processes:
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        processors += usage.ru_utime + usage.ru_stime
        if process.returncode:
            raise SystemExit(f"{process.args!r} ended with {process.returncode}")
    return Cost(perf_counter() - begun, processors)


def forget(folder: Path) -> None:
    """Remove all that tasks have made."""
    for name in _MADE:
        shutil.rmtree(folder / name, ignore_errors=True)


def worker(folder: Path) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [*_BAKE, "work", str(folder), *_QUIET],
        cwd=_ROOT,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )


def work(folder: Path, count: int) -> Cost:
    """Do all tasks by so many workers."""
    return awaited([worker(folder) for _ in range(count)])


def killed_work(folder: Path, kills: int, seed: int) -> None:
    """Do all tasks by two workers, one of which is killed so many times; begin anew whenever all are done."""
    draw, done, finished = random.Random(seed), 0, 0
    workers = [worker(folder), worker(folder)]
    while done < kills:
        sleep(draw.uniform(0.2, 12.0))
        if not read_tasks(folder).left():
            awaited(workers)
            finished += 1
            forget(folder)
            workers = [worker(folder), worker(folder)]
            continue
        hit = draw.randrange(2)
        workers[hit].kill()
        workers[hit].wait()
        done += 1
        workers[hit] = worker(folder)
    awaited(workers)
    print(f"{done} kills, {finished + 1} jobs finished", flush=True)


def graph(farm: TaskFarm) -> str:
    """What the tasks took, the longest chain of them, and the most memory."""
    took = {task.name: farm.done(task.name) for task in farm.tasks}
    ends: dict[str, float] = {}
    for task in farm.tasks:
        ends[task.name] = took[task.name].seconds + max((ends[need] for need in task.needs), default=0.0)
    total = sum(each.seconds for each in took.values())
    most = max(each.memory for each in took.values())
    return (
        f"{len(took)} tasks of {min(t.seconds for t in took.values()):.0f} to "
        f"{max(t.seconds for t in took.values()):.0f} s, {total:.0f} s in all, "
        f"the longest chain {max(ends.values()):.0f} s, at most {most / 2**20:.0f} MiB"
    )


def assembled(farm: TaskFarm, local: Path, out: Path) -> str:
    """Assemble, and compare with what one process made."""
    run([*_BAKE, "assemble", str(farm.folder), "--out", str(out), *_QUIET])
    same = digests(out) == digests(local)
    return f"{len(digests(local))} files, {'the same as' if same else 'OTHERS THAN'} one process's"


if __name__ == "__main__":
    main()
