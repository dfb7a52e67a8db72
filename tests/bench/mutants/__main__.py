# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the tests would notice: plant one small fault after another in the package, and run the tests on each.

    RADTEX_LINES=lines python -m pytest -p tests.bench.mutants.record     once: which tests run which lines
    python -m tests.bench.mutants lines mutants.json --seed 1 --count 200

Run it in a clone of its own: the files of `radtex_addon` change while it runs, and are put back. A fault is
one of an operator, a comparison, `and` for `or`, a condition, a number, or two arguments swapped, drawn
evenly from all that can be planted outside of docstrings, messages and annotations. Only tests that ran its
line are run, those first that run the fewest other lines and cost the least, until one fails or they have
taken `--seconds` of processor time in the recording. `--again FILE` plants the same faults as an earlier
run, which are found by their text, also where lines have moved.
"""

from __future__ import annotations

import argparse
import ast
import copy
import json
import os
import random
import resource
import subprocess
import sys
import time
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[3]
PACKAGE = ROOT / "radtex_addon"
# Tests under a fault may take so many times the processor time that they took, and a minute, until they count
# as failed, and so many times of the clock, and ten minutes: other work may be going on beside.
LONGEST, LONGEST_WALL = 4, 20

_SWAPS: dict[type[ast.AST], Any] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.FloorDiv: ast.Mult,
    ast.Mod: ast.FloorDiv,
    ast.Pow: ast.Mult,
    ast.BitAnd: ast.BitOr,
    ast.BitOr: ast.BitAnd,
    ast.LShift: ast.RShift,
    ast.RShift: ast.LShift,
    ast.Lt: ast.LtE,
    ast.LtE: ast.Lt,
    ast.Gt: ast.GtE,
    ast.GtE: ast.Gt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot,
    ast.IsNot: ast.Is,
    ast.In: ast.NotIn,
    ast.NotIn: ast.In,
    ast.And: ast.Or,
    ast.Or: ast.And,
}


@dataclass(frozen=True)
class Mutant:
    """A fault: where, of what kind, and what stood and stands there (one expression's text)."""

    file: str
    line: int
    function: str
    kind: str
    before: str
    after: str
    nth: int  # of the places in the function with that text and that change


@dataclass
class Verdict:
    """What the tests said to a fault."""

    mutant: Mutant
    end: str  # killed, survived, not run (no test runs its line), gone (its text is no longer there)
    by: str = ""  # the test that failed
    tests: int = 0  # that were run at most
    seconds: float = 0.0


def main() -> None:
    """Plant the faults and write what became of them."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("lines", type=Path, help="the folder of the recording")
    parser.add_argument("out", type=Path, help="JSON; what it has already is not run again")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--again", type=Path, help="an earlier run's JSON, whose faults are planted")
    options = parser.parse_args()
    mutants = earlier(options.again) if options.again else drawn(options.seed, options.count)
    covering = Recording(options.lines)
    verdicts = [Verdict(**{**row, "mutant": Mutant(**row["mutant"])}) for row in read(options.out)]
    done = {verdict.mutant for verdict in verdicts}
    for mutant in mutants:
        if mutant not in done:
            verdict = judged(mutant, covering, options.seconds)
            verdicts.append(verdict)
            options.out.write_text(json.dumps([asdict(one) for one in verdicts], indent=1), encoding="utf-8")
            print(
                f"{verdict.end:9} {verdict.seconds:6.1f} s  {mutant.file}:{mutant.line} {mutant.kind}", end=""
            )
            print(f"  {mutant.before}  ->  {mutant.after}  {verdict.by}", flush=True)
    ends = [verdict.end for verdict in verdicts]
    print(", ".join(f"{ends.count(end)} {end}" for end in sorted(set(ends))))


def read(path: Path) -> list[dict[str, Any]]:
    """The rows of an earlier run, none if there was none."""
    return json.loads(path.read_text(encoding="utf-8")) if path.is_file() else []


def earlier(path: Path) -> list[Mutant]:
    """The faults of an earlier run."""
    return [Mutant(**row["mutant"]) for row in read(path)]


def drawn(seed: int, count: int) -> list[Mutant]:
    """So many of all faults that can be planted, the same for the same seed and code."""
    found = [mutant for path in sorted(PACKAGE.rglob("*.py")) for mutant, _ in faults(path)]
    return random.Random(seed).sample(found, count)


def faults(path: Path) -> Iterator[tuple[Mutant, str]]:
    """Each fault that can be planted in a file, and the file's text with it."""
    text = path.read_text(encoding="utf-8")
    counts: dict[tuple[str, str, str], int] = defaultdict(int)
    name = path.relative_to(ROOT).as_posix()
    for function in functions(ast.parse(text)):
        for node in expressions(function):
            for kind, changed in changes(node):
                before, after = ast.unparse(node), ast.unparse(changed)
                key = (function.name, before, after)
                mutant = Mutant(name, node.lineno, function.name, kind, before, after, counts[key])
                counts[key] += 1
                yield mutant, replaced(text, node, after)


Function = ast.FunctionDef | ast.AsyncFunctionDef


def functions(tree: ast.AST) -> Iterator[Function]:
    """The functions of a file that lie in no other function."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, Function):
            yield node
        else:
            yield from functions(node)


def expressions(function: Function) -> Iterator[ast.expr]:
    """What a function computes: no annotations, decorators, nor what it raises, logs or formats."""
    waiting: list[ast.AST] = list(reversed(function.body))
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.Raise | ast.JoinedStr) or _says(node):
            continue
        if isinstance(node, ast.expr):
            yield node
        if isinstance(node, ast.AnnAssign):
            waiting += [node.value] if node.value else []
        elif isinstance(node, Function):
            waiting += reversed(node.body)
        else:
            waiting += reversed(list(ast.iter_child_nodes(node)))


def _says(node: ast.AST) -> bool:
    called = ast.unparse(node.func) if isinstance(node, ast.Call) else ""
    return called.startswith("log.") or called.rpartition(".")[2].endswith(("Error", "Warning"))


def changes(node: ast.expr) -> Iterator[tuple[str, ast.expr]]:
    """Each small fault that a node can have."""
    made = copy.deepcopy(node)
    if isinstance(made, ast.BinOp | ast.BoolOp) and type(made.op) in _SWAPS and not _joins_text(made):
        made.op = _SWAPS[type(made.op)]()
        yield "operator", made
    elif isinstance(made, ast.Compare) and type(made.ops[0]) in _SWAPS:
        made.ops[0] = _SWAPS[type(made.ops[0])]()
        yield "comparison", made
    elif isinstance(made, ast.IfExp):
        made.body, made.orelse = made.orelse, made.body
        yield "condition", made
    elif isinstance(made, ast.UnaryOp) and isinstance(made.op, ast.Not | ast.USub):
        yield "operator", made.operand
    elif isinstance(made, ast.Constant) and isinstance(made.value, bool | int | float):
        value = made.value
        yield "constant", ast.Constant(not value if isinstance(value, bool) else value + 1)
    elif isinstance(made, ast.Call) and _can_swap(made.args):
        made.args[:2] = made.args[1::-1]
        yield "arguments", made


def _can_swap(arguments: list[ast.expr]) -> bool:
    first = [ast.unparse(argument) for argument in arguments[:2]]
    return len(set(first)) == 2 and not any(one.startswith("*") for one in first)


def _joins_text(node: ast.BinOp | ast.BoolOp) -> bool:
    ends = [node.left, node.right] if isinstance(node, ast.BinOp) else node.values
    return any(isinstance(end, ast.JoinedStr) or _is_text(end) for end in ends)


def _is_text(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and isinstance(node.value, str)


def replaced(text: str, node: ast.expr, after: str) -> str:
    """A file's text with a node's own text replaced."""
    rows = text.splitlines(keepends=True)
    assert node.end_lineno is not None
    assert node.end_col_offset is not None
    first, last = rows[node.lineno - 1].encode(), rows[node.end_lineno - 1].encode()
    middle = first[: node.col_offset] + f"({after})".encode() + last[node.end_col_offset :]
    return "".join(rows[: node.lineno - 1]) + middle.decode() + "".join(rows[node.end_lineno :])


class Recording:
    """Which tests ran which lines, and what they cost."""

    def __init__(self, folder: Path) -> None:
        self.cpu: dict[str, float] = {}
        self.size: dict[str, int] = {}
        self._ran: dict[str, list[str]] = defaultdict(list)
        for path in sorted(folder.glob("tests-*.jsonl")):
            with path.open(encoding="utf-8") as rows:
                lines = json.loads(next(rows))
                for row in map(json.loads, rows):
                    self._add(lines, row)

    def _add(self, lines: Sequence[str], row: dict[str, Any]) -> None:
        if row.get("outcome") != "passed":
            return
        name, numbers = str(row["name"]), [row.get(part, ()) for part in ("own", "children", "shared")]
        own = {lines[number] for part in numbers[:2] for number in part}
        shared = {lines[number] for number in numbers[2]}
        self.cpu[name], self.size[name] = float(str(row["cpu"])), len(own | shared)
        for line in own:
            self._ran[line].append(name)
        # What a fixture ran may be told by any test of the file that uses it.
        for line in shared - own:
            self._ran[line].append(name.partition("::")[0])

    def tests_of(self, file: str, line: int, seconds: float) -> list[str]:
        """The tests that ran a line, the nearest first, as many as cost at most `seconds`."""
        names = set(self._ran.get(f"{file}:{line}", ()))
        files = {name for name in names if "::" not in name}
        names |= {name for name in self.cpu if name.partition("::")[0] in files}
        chosen, spent = [], 0.0
        for name in sorted(names - files, key=lambda one: (self.size[one] * (self.cpu[one] + 0.1), one)):
            if spent and spent + self.cpu[name] > seconds:
                break
            chosen.append(name)
            spent += self.cpu[name]
        return chosen


def judged(mutant: Mutant, covering: Recording, seconds: float) -> Verdict:
    """Plant a fault, run the tests, and put the file back."""
    path = ROOT / mutant.file
    texts = dict(faults(path)) if path.is_file() else {}
    place = next((found for found in texts if _is_same(found, mutant)), None)
    if place is None:
        return Verdict(mutant, "gone")
    tests = covering.tests_of(place.file, place.line, seconds)
    if not tests:
        return Verdict(mutant, "not run")
    whole = path.read_text(encoding="utf-8")
    began = time.monotonic()
    try:
        path.write_text(texts[place], encoding="utf-8")
        failed, by = first_failure(tests, sum(covering.cpu[test] for test in tests))
    finally:
        path.write_text(whole, encoding="utf-8")
    taken = round(time.monotonic() - began, 1)
    return Verdict(mutant, "killed" if failed else "survived", by, len(tests), taken)


def _is_same(one: Mutant, other: Mutant) -> bool:
    keys = ("file", "function", "kind", "before", "after", "nth")
    return all(getattr(one, key) == getattr(other, key) for key in keys)


def first_failure(tests: Sequence[str], cpu: float) -> tuple[bool, str]:
    """Whether a test failed, and which; one that takes too long, or ends the process, has failed.

    Unharmed they take `cpu` seconds of processor time.
    """
    limit = int(60 + LONGEST * cpu)
    command = [sys.executable, "-B", "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", "--no-header"]
    environment = os.environ | {"PYTHONDONTWRITEBYTECODE": "1"}
    environment.pop("PYTHONPYCACHEPREFIX", None)
    environment.pop("RADTEX_LINES", None)
    files = Path(os.environ.get("TMPDIR", "/tmp"), f"radtex-mutant-tests-{os.getpid()}.txt")
    files.write_text("\n".join(tests), encoding="utf-8")
    try:
        run = subprocess.run(
            [*command, f"@{files}"],
            cwd=ROOT,
            env=environment,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=600 + LONGEST_WALL * cpu,
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (limit, limit)),
            check=False,
        )
    except subprocess.TimeoutExpired:
        return True, "took too long"
    finally:
        files.unlink()
    named = [line for line in run.stdout.splitlines() if line.startswith(("FAILED ", "ERROR "))]
    return run.returncode != 0, (named or [run.stdout[-200:]])[0][:200] if run.returncode else ""


if __name__ == "__main__":
    main()
