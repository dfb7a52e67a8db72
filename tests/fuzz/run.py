# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Give every reader damaged files, in processes of their own, and say what came of it.

    python -m tests.fuzz.run --executions 1000000 [--guided] [--reader atlas] [--seed 0] [--jobs 2]

The executions are shared out among the readers by their weights, or are the chosen ones'. A reader returns,
or raises the error that it documents, in one line that names the file. Anything else (another error, a crash,
more than ten seconds or a gibibyte, a word on standard output) is a finding: its input is kept in
tests/fuzz/failures/READER, where test_readers.py finds it, and the reader goes on with other seeds. The exit
code is 1 if there were findings. `--guided` has atheris (dependency group `fuzz`, Linux) keep damaged files
that reach new lines and damage them further.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path
from time import perf_counter

from .readers import READERS, fingerprint

ROOT = Path(__file__).resolve().parents[2]
FAILURES = Path(__file__).with_name("failures")
_AS_WRITTEN = argparse.RawDescriptionHelpFormatter
_PART = 25_000  # executions of a process
_MOST_FINDINGS = 5  # of a reader, after which it is given up


@dataclass
class Outcome:
    """What came of a reader's executions, and what its findings said."""

    reader: str
    executions: int = 0
    read: int = 0
    refused: int = 0
    taken: int = 0
    seconds: float = 0
    findings: list[str] = field(default_factory=list)

    def __str__(self) -> str:
        kept = f"{self.executions:>9,} {self.read:>9,} {self.refused:>9,} {self.taken / 2**20:>8.0f}"
        return f"{self.reader:<18} {kept} {self.seconds:>8.1f} {len(self.findings):>5}"


HEADINGS = f"{'reader':<18} {'runs':>9} {'read':>9} {'refused':>9} {'MiB':>8} {'seconds':>8} {'found':>5}"


def main() -> int:
    """Run and print a table; 1 if there were findings."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=_AS_WRITTEN)
    parser.add_argument("--executions", type=int, default=1_000_000)
    parser.add_argument("--reader", choices=READERS, action="append", help="only this one; repeatable")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--guided", action="store_true")
    options = parser.parse_args()
    shares = list(shared_out(options.executions, options.reader or READERS))
    print(HEADINGS, flush=True)
    whole = Outcome("all")
    with ThreadPoolExecutor(options.jobs) as pool:
        for outcome in pool.map(lambda share: fuzz(*share, seed=options.seed, guided=options.guided), shares):
            print(outcome, *outcome.findings, sep="\n", flush=True)
            add(whole, outcome)
    print(whole)
    return 1 if whole.findings else 0


def shared_out(executions: int, names: Iterable[str]) -> Iterator[tuple[str, int]]:
    """How many executions each reader gets; together at least as many."""
    weights = {name: READERS[name].weight for name in names}
    for name, weight in weights.items():
        yield name, -(-executions * weight // sum(weights.values()))


def fuzz(reader: str, executions: int, *, seed: int, guided: bool, failures: Path = FAILURES) -> Outcome:
    """Give a reader that many damaged files; those of findings are kept below `failures`."""
    outcome = Outcome(reader)
    begin = perf_counter()
    seeds = (seed * 1_000_000 + number for number in count())
    while outcome.executions < executions and len(outcome.findings) < _MOST_FINDINGS:
        part = min(_PART, executions - outcome.executions)
        with tempfile.TemporaryDirectory(prefix="radtex-fuzz-") as folder:
            found = _run(reader, part, next(seeds), guided, Path(folder))
            if found.findings:
                _keep(Path(folder, reader, READERS[reader].target), failures / reader)
        add(outcome, found)
    outcome.seconds = perf_counter() - begin
    return outcome


def add(whole: Outcome, part: Outcome) -> None:
    """Count `part` among the `whole`."""
    whole.executions += part.executions
    whole.read += part.read
    whole.refused += part.refused
    whole.taken = max(whole.taken, part.taken)
    whole.seconds += part.seconds
    whole.findings += part.findings


def _run(reader: str, executions: int, seed: int, guided: bool, folder: Path) -> Outcome:
    """One process. What it says last is its result; without that it was ended by a finding."""
    command = [sys.executable, "-m", "tests.fuzz.worker", reader, f"--executions={executions}"]
    command += [f"--seed={seed}", f"--folder={folder}", *(["--guided"] if guided else [])]
    ended = subprocess.run(command, cwd=ROOT, capture_output=True, check=False)
    last = (ended.stdout.decode(errors="replace").splitlines() or [""])[-1].split()
    if ended.returncode == 0 and last[:1] == ["done"]:
        read, refused, taken = map(int, last[2:])
        return Outcome(reader, executions, read, refused, taken)
    said = b"\n".join((ended.stdout, ended.stderr)).decode(errors="replace").strip()[-2000:]
    return Outcome(reader, 1, findings=[f"seed {seed}, exit code {ended.returncode}:\n{said}"])


def _keep(file: Path, failures: Path) -> None:
    """Keep what was read last as a regression input."""
    if file.is_file():
        data = file.read_bytes()
        failures.mkdir(parents=True, exist_ok=True)
        (failures / f"{fingerprint(data)}{file.suffix}").write_bytes(data)


if __name__ == "__main__":
    sys.exit(main())
