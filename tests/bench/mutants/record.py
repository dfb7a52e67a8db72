# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A pytest plugin: which lines of the package each test runs, and what the test costs.

`RADTEX_LINES=FOLDER python -m pytest -p tests.bench.mutants.record …` writes FOLDER/tests-PID.jsonl: a list
of the lines, then of each test its name, its outcome, its seconds of processor time, and the numbers of the
lines that it ran. `shared` are those of its fixtures, `children` those of processes that it started: these
are recorded unless they ignore PYTHONPATH.
"""

from __future__ import annotations

import json
import os
from array import array
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.bench.mutants import lines

_FOLDER = Path(os.environ["RADTEX_LINES"])
_numbers: dict[lines.Line, int] = {}
_tests: list[dict[str, Any]] = []


def _numbered(taken: set[lines.Line]) -> array[int]:
    return array("I", sorted(_numbers.setdefault(line, len(_numbers)) for line in taken))


def pytest_configure(config: pytest.Config) -> None:
    _FOLDER.mkdir(parents=True, exist_ok=True)
    inside = str(Path(__file__).with_name("inside"))
    os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, [inside, os.environ.get("PYTHONPATH")]))
    lines.begin()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_setup(item: pytest.Item) -> Iterator[None]:
    lines.take()
    os.environ["RADTEX_LINES_TEST"] = f"{os.getpid()}-{len(_tests)}"
    try:
        return (yield)
    finally:
        _tests.append({"name": item.nodeid, "shared": _numbered(lines.take())})


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Iterator[None]:
    try:
        return (yield)
    finally:
        _tests[-1]["own"] = _numbered(lines.take())


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    if report.when == "call":
        _tests[-1]["outcome"] = report.outcome
    elif report.when == "teardown":
        _tests[-1]["cpu"] = float(dict(report.user_properties).get("cpu", 0))  # type: ignore[arg-type]


def pytest_sessionfinish(session: pytest.Session) -> None:
    for told in _FOLDER.glob(f"{os.getpid()}-*-*.txt"):
        said = [line.split("\t") for line in told.read_text(encoding="utf-8").splitlines()]
        test = _tests[int(told.name.split("-")[1])]
        test.setdefault("children", array("I")).extend(_numbered({(file, int(line)) for file, line in said}))
        told.unlink()
    with _FOLDER.joinpath(f"tests-{os.getpid()}.jsonl").open("w", encoding="utf-8") as report:
        for row in ([f"{file}:{line}" for file, line in _numbers], *_tests):
            report.write(json.dumps(row, default=list) + "\n")
