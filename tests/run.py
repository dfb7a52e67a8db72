# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
#
# /// script
# requires-python = ">=3.11"
# dependencies = []
# ///
"""Run the tests on every supported Blender: `uv run tests/run.py [--blender 5.2] [pytest's arguments]`.

Each Blender has an environment of its own (.venv-4.5, .venv-5.2), made from uv.lock when needed.
They run side by side, each line behind its Blender's number. A run of everything gives the newest's tests
of real programs a process of their own, before which the others step back (`nice`), because it takes longest,
and half of its files that start bakes another. It leaves to the newest what is marked `one_blender`, because
Blender has no part in it. RADTEX_EVERY_BLENDER=1 runs all of it on all. Before it, the web page is built.
At the end stands what the tests cost: the sum by folder, beside its budget, the dearest tests, and how often
a bake was made or a program started (`--costs FILE` also writes each test's). Then what failed is named, with
the end of what pytest said of it, and the last line sums up, as pytest would; the exit code is 0 only if all
passed.
"""

from __future__ import annotations

import argparse
import json
import os
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, field
from pathlib import Path
from time import perf_counter
from xml.etree import ElementTree as ET

ROOT = Path(__file__).resolve().parent.parent
UV = os.environ.get("UV") or shutil.which("uv") or "uv"
PYTHON_OF = {"4.5": "3.11", "5.2": "3.13"}
NEWEST = "5.2"
TAIL = 12  # lines of a failure that are said again at the end
DEAREST = 30  # tests that are named with their cost
# Seconds of processor time that a folder's tests may take on all Blenders: two cores do them in 900 s.
BUDGETS = {
    "tests/blender": 800,
    "tests/real": 600,
    "tests/package": 100,
    "tests/layered": 30,
    "tests/formats": 30,
    "tests/fuzz": 40,
    "tests/core": 30,
    "tests/bake": 10,
    "tests/settings": 10,
    "tests/export": 10,
    "tests/report": 10,
    "tests/store": 5,
    "tests/bench": 40,
}
BAKES = "tests/blender"  # half of the processor time
ALSO = ("tests/package", "tests/formats")  # what one half of those does besides, so that both take as long
REAL = "tests/real"  # where other programs are started, in the newest Blender's run alone


def main() -> int:
    """Run the suite on the chosen Blenders and return the exit code of the worst."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False
    )
    parser.add_argument("--blender", choices=PYTHON_OF, action="append", help="only this one; repeatable")
    parser.add_argument("--costs", type=Path, help="write what each test cost into this file, as JSON")
    options, pytest_arguments = parser.parse_known_args()
    started = perf_counter()
    runs = dict.fromkeys(options.blender or PYTHON_OF, pytest_arguments)
    if not pytest_arguments and NEWEST in runs:
        everywhere = [f"--ignore={REAL}", "-m", "not one_blender"]
        runs = dict.fromkeys(runs, [] if os.environ.get("RADTEX_EVERY_BLENDER") else everywhere)
        runs |= {f"{NEWEST} real": [REAL], **in_two(NEWEST)}
        build_page()
    with tempfile.TemporaryDirectory() as shared, ThreadPoolExecutor(len(runs)) as pool:
        ended = [
            pool.submit(run_pytest, name, arguments, Path(shared), len(runs) > 1)
            for name, arguments in runs.items()
        ]
    outcomes = [run.result() for run in ended]
    costs = [cost for _, outcome in outcomes for cost in outcome.costs]
    if options.costs is not None:
        options.costs.parent.mkdir(parents=True, exist_ok=True)
        options.costs.write_text(json.dumps([asdict(cost) for cost in costs], indent=1), encoding="utf-8")
    if not pytest_arguments:
        print("\n".join(["", *cost_table(costs)]))
    for name, (_, outcome) in zip(runs, outcomes, strict=True):
        for failure in outcome.failures:
            print(f"\n{name} | {failure}")
    counts = sum((outcome.counts for _, outcome in outcomes), Counter[str]())
    print(summary(counts, perf_counter() - started), flush=True)
    return max((code for code, _ in outcomes), key=abs)


def build_page() -> None:
    """Have the web page built, which exports bring; if that fails, it says why, and tests of it fail."""
    environment = os.environ | {"UV_PROJECT_ENVIRONMENT": str(ROOT / f".venv-{NEWEST}")}
    run([UV, "run", "--frozen", "--python", PYTHON_OF[NEWEST], ".ci/build_web.py"], environment)


def in_two(blender: str) -> dict[str, list[str]]:
    """Two runs of all but real programs, of about the same length, so that no core waits at the end."""
    files = sorted(path.relative_to(ROOT).as_posix() for path in (ROOT / BAKES).glob("test_*.py"))
    half = [*files[::2], *ALSO]
    others = [f"--ignore={file}" for file in half]
    return {blender: [f"--ignore={REAL}", *others], f"{blender} bakes": half}


@dataclass(frozen=True)
class Cost:
    """What a test took: of the clock, of the processors, and what it made and started (tests/costs.py)."""

    run: str
    test: str
    seconds: float
    cpu: float
    bakes: int
    starts: list[str]

    @property
    def folder(self) -> str:
        """Where the test lies, such as tests/core."""
        return "/".join(self.test.split(".")[:2])


@dataclass(frozen=True)
class Outcome:
    """How many tests ended how, their costs, and what failed: its name and the end of what pytest said."""

    counts: Counter[str]
    failures: list[str] = field(default_factory=list)
    costs: list[Cost] = field(default_factory=list)


def run_pytest(name: str, arguments: list[str], shared: Path, beside: bool) -> tuple[int, Outcome]:
    """Run pytest in the environment of the Blender that `name` begins with.

    Return its exit code and how its tests ended. Beside others, each line says whose it is. In the folder
    `shared` are the bakes that many tests read (tests/finished_bakes.py), and what the hundreds of Pythons
    that tests start compile, which saves each a second.
    """
    blender = name.split(maxsplit=1)[0]
    command = [UV, "run", "--frozen", "--python", PYTHON_OF[blender]]
    if beside and arguments[:1] != [REAL] and (nice := shutil.which("nice")):
        command = [nice, *command]
    command += ["--no-default-groups", f"--group=blender-{blender.replace('.', '')}", "--group=test"]
    command += ["python", "-m", "pytest"]
    environment = os.environ | {"UV_PROJECT_ENVIRONMENT": str(ROOT / f".venv-{blender}")}
    bakes = Path(os.environ.get("RADTEX_TEST_BAKES") or shared / "bakes")
    bakes.mkdir(parents=True, exist_ok=True)
    environment |= {"PYTHONPYCACHEPREFIX": str(shared / "bytecode"), "RADTEX_TEST_BAKES": str(bakes)}
    for name_of_other in ("VIRTUAL_ENV", "PYTHONDONTWRITEBYTECODE"):
        environment.pop(name_of_other, None)
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder, "report.xml")
        print(f"Blender {blender}: {shlex.join([*command, *arguments])}", flush=True)
        command += [f"--junit-xml={report}", *arguments]
        code = run_marked(f"{name} | ", command, environment) if beside else run(command, environment)
        outcome = read_report(name, report) if report.exists() else Outcome(Counter({"error": 1}))
    return code, outcome


def run(command: list[str], environment: dict[str, str]) -> int:
    """Run a command and return its exit code."""
    return subprocess.run(command, cwd=ROOT, env=environment, check=False).returncode


def run_marked(mark: str, command: list[str], environment: dict[str, str]) -> int:
    """Run a command, with `mark` before each line that it says, and return its exit code."""
    with subprocess.Popen(
        command,
        cwd=ROOT,
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        encoding="utf-8",
        errors="replace",
    ) as process:
        for line in process.stdout or ():
            print(mark + shown(line.rstrip("\n")), flush=True)
    return process.returncode


def shown(line: str) -> str:
    """A line that drives no terminal: tests quote odd names."""
    kept = (one if one.isprintable() or one == "\t" else ascii(one)[1:-1] for one in line)
    return line if line.isprintable() else "".join(kept)


def read_report(run: str, path: Path) -> Outcome:
    """Read the outcomes and costs of a run from its JUnit report."""
    words = {"failure": "failed", "error": "error", "skipped": "skipped"}
    counts, failures, costs = Counter[str](), [], []
    for case in ET.parse(path).iter("testcase"):
        ends = [element for element in case if element.tag in words]
        counts[words[ends[0].tag] if ends else "passed"] += 1
        name = f"{case.get('classname')}.{case.get('name')}"
        for end in ends:
            if end.tag != "skipped":
                said = "\n".join(map(shown, (end.text or "").splitlines()[-TAIL:]))
                failures.append(f"{words[end.tag]}: {name}\n{said}")
        told = {one.get("name"): one.get("value") or "" for one in case.iter("property")}
        cpu, bakes, starts = (told.get(key) or "0" for key in ("cpu", "bakes", "starts"))
        started = [] if starts == "0" else starts.split()
        costs.append(Cost(run, name, float(case.get("time") or 0), float(cpu), int(bakes), started))
    return Outcome(counts, failures, costs)


def cost_table(costs: list[Cost]) -> list[str]:
    """The lines that say what the tests cost, by folder, by test, and by what they start."""
    lines = [f"{'seconds':>9} {'processor':>9} {'budget':>7} {'tests':>6} {'bakes':>6}  folder"]
    for folder in sorted({cost.folder for cost in costs}, key=lambda one: -cpu_of(costs, one)):
        inside = [cost for cost in costs if cost.folder == folder]
        spent, budget = cpu_of(costs, folder), BUDGETS.get(folder, 0)
        over = f", {spent - budget:.0f} s above its budget" if spent > budget else ""
        wall, bakes = sum(cost.seconds for cost in inside), sum(cost.bakes for cost in inside)
        lines.append(f"{wall:9.0f} {spent:9.0f} {budget:7} {len(inside):6} {bakes:6}  {folder}{over}")
    lines += ["", f"{'seconds':>9} {'processor':>9}  the {DEAREST} dearest tests"]
    for cost in sorted(costs, key=lambda one: -one.cpu)[:DEAREST]:
        lines.append(f"{cost.seconds:9.1f} {cost.cpu:9.1f}  {cost.run}: {shown(cost.test)}")
    starts = Counter(program for cost in costs for program in cost.starts)
    lines += ["", f"{'starts':>9}  of programs"]
    return lines + [f"{count:9}  {program}" for program, count in starts.most_common(DEAREST)]


def cpu_of(costs: list[Cost], folder: str) -> float:
    """The seconds of processor time of a folder's tests."""
    return sum(cost.cpu for cost in costs if cost.folder == folder)


def summary(counts: Counter[str], seconds: float) -> str:
    """One line for all runs together, worded as pytest's last."""
    words = {"failed": "failed", "passed": "passed", "skipped": "skipped"}
    words["error"] = "error" if counts["error"] == 1 else "errors"
    parts = [f"{counts[key]} {word}" for key, word in words.items() if counts[key]]
    return f" {', '.join(parts) or 'no tests ran'} in {seconds:.2f}s ".center(80, "=")


if __name__ == "__main__":
    sys.exit(main())
