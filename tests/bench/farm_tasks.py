# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A farm of tasks beside one process: its tasks, chain and overhead, by each engine, and killed workers.

`python -m tests.bench.farm_tasks room.blend --by work:2 openjd:4 slurm make:2 --kills 30 --out DIR -- --all`;
what follows the -- are options of a bake. `work:2` are two `bake.py work FOLDER`; `openjd:4` are four
workers, each of which lets OpenJD do a task whose step waits for no other; `slurm` are daemons of this
machine's own. Files are compared with those of one process (`--one DIR`: of one that was baked before, by the
same options), to the last bit. Kills hit a random worker at random moments; another takes its place.
"""

from __future__ import annotations

import argparse
import os
import random
import resource
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter, sleep

from radtex_addon.farm.tasks import TaskFarm, read_tasks
from tests.blender.killed import digests
from tests.real.nodes import OPENJD, ready_python
from tests.real.slurm import slurm_cluster
from tests.real.task_farm import done_in_steps

_ROOT = Path(__file__).resolve().parents[2]
_BAKE = [sys.executable, str(_ROOT / "bake.py")]
_QUIET = ["--progress", "none"]
_MADE = ("done", "pieces", "baked", "claims", "logs")
_HOURS = 3 * 3600.0  # until Slurm has done all


@dataclass(frozen=True)
class Cost:
    """Seconds by the clock, and of processors."""

    clock: float
    processors: float


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scene", type=Path)
    parser.add_argument("--by", nargs="+", default=["work:1", "work:2"])
    parser.add_argument("--one", type=Path)
    parser.add_argument("--kills", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, required=True)
    words = [*sys.argv[1:], "--"]
    asked, bake = parser.parse_args(words[: words.index("--")]), words[words.index("--") + 1 : -1]
    local, far = asked.one or asked.out / "one", asked.out / "farm"
    shutil.rmtree(asked.out, ignore_errors=True)
    if asked.one is None:
        alone = run([*_BAKE, str(asked.scene), *bake, "--out", str(local), *_QUIET])
        print(f"one process: {told(alone)}", flush=True)
    prepared = run([*_BAKE, "prepare", str(asked.scene), *bake, "--out", str(far), *_QUIET])
    (folder,) = far.glob("*.radtex-farm")
    print(f"prepared: {told(prepared)}, {len(read_tasks(folder).tasks)} tasks", flush=True)
    for engine in asked.by:
        forget(folder)
        name, _, count = engine.partition(":")
        begun = perf_counter(), processor_seconds()
        ENGINES[name](folder, int(count or 1))
        cost = Cost(perf_counter() - begun[0], processor_seconds() - begun[1])
        farm = read_tasks(folder)
        print(f"{engine}: {told(cost)}; {graph(farm)}", flush=True)
        print(f"  {assembled(farm, local, asked.out / 'assembled')}", flush=True)
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


def processor_seconds() -> float:
    """Seconds of processors that this process's ended children, and theirs, have taken."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


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


def by_workers(folder: Path, count: int) -> None:
    """Do all tasks by so many `bake.py work FOLDER`."""
    awaited([worker(folder) for _ in range(count)])


def by_openjd(folder: Path, count: int) -> None:
    """Do all tasks by OpenJD, so many at once."""
    program = str(ready_python(OPENJD) / "openjd")
    command = [program, "run", str(folder / "openjd.yaml"), "-p", f"Work={' '.join([*_BAKE, 'work'])}"]

    def do(step: str, task: str) -> None:
        run([*command, "--step", step, "--no-run-dependencies", "-tp", f"Task={task}"])

    done_in_steps(read_tasks(folder), count, do)


def by_make(folder: Path, count: int) -> None:
    run(["make", "-C", str(folder), f"-j{count}", f"WORK={' '.join([*_BAKE, 'work', *_QUIET])}"])


def by_slurm(folder: Path, _count: int) -> None:
    """Do all tasks by the script for Slurm; its seconds of processors are those of daemons, and not known."""
    with tempfile.TemporaryDirectory() as place, slurm_cluster(Path(place)) as cluster:
        variables = cluster.variables | {"WORK": " ".join([*_BAKE, "work", *_QUIET]), "ASSEMBLE": ""}
        subprocess.run(
            ["bash", str(folder / "slurm.sh")], env=variables, check=True, stdout=subprocess.DEVNULL
        )
        cluster.wait(_HOURS)


ENGINES: dict[str, Callable[[Path, int], None]] = {
    "work": by_workers,
    "openjd": by_openjd,
    "make": by_make,
    "slurm": by_slurm,
}


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
    run([*_BAKE, "assemble", str(farm.folder), "--out", str(out), "--overwrite", *_QUIET])
    same = digests(out) == digests(local)
    return f"{len(digests(local))} files, {'the same as' if same else 'OTHERS THAN'} one process's"


if __name__ == "__main__":
    main()
