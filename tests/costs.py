# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What each test costs: a pytest plugin, whose figures tests/run.py reads from the JUnit report.

A test's properties are `cpu`, the seconds of processor time of its process and of all that this started,
also of what goes on and serves other tests (on Linux), fixtures included, `bakes`, how many sidecars were
written in its process, and `starts`, the programs that it started, each as often as it was.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path, PurePath
from typing import Any

import pytest

BAKE = "bake.py"
# Behind wrappers such as xvfb-run and enter.sh, what is started is the first of these that the command names.
_PROGRAMS = {
    "blender",
    "chromium",
    "csc",
    "dotnet",
    "dxc",
    "git",
    "glslangValidator",
    "godot",
    "mcs",
    "mono",
    "node",
}
_PROGRAMS |= {"npm", "pip", "spirv-cross", "spirv-dis", "spirv-val", "uv", "xatlas_worker.py"}
_TICKS = os.sysconf("SC_CLK_TCK") if hasattr(os, "sysconf") else 100  # a second, in /proc
_sidecars: list[str] = []  # that this test wrote in this process
_starts: list[str] = []  # the programs that it started


def _watch(event: str, details: tuple[Any, ...]) -> None:
    if event == "subprocess.Popen":
        words = [details[1]] if isinstance(details[1], str | bytes) else details[1]
        _starts.append(_program([os.fsdecode(word) for word in words]))
    elif event == "os.rename" and _is_sidecar(os.fsdecode(details[1])):
        _sidecars.append(os.fsdecode(details[1]))


def _program(words: list[str]) -> str:
    names = [PurePath(word).name for word in words]
    if BAKE in names:
        return BAKE
    named = next((name for name in names if name in _PROGRAMS), names[0])
    return "Python" if named.startswith("python") else named


def _is_sidecar(path: str) -> bool:
    return path.endswith(".json") and PurePath(path).name.count(".") >= 2 and "unfinished" not in path


def _seconds() -> float:
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system + _of_living_children()


def _of_living_children() -> float:
    """Their processor time and that of theirs; what has ended is its parent's already."""
    found, waiting = 0.0, [str(os.getpid())]
    while waiting:
        for file in Path("/proc", waiting.pop(), "task").glob("*/children"):
            with suppress(OSError):  # it has ended
                for child in file.read_text().split():
                    waiting.append(child)
                    facts = Path("/proc", child, "stat").read_text().rpartition(")")[2].split()
                    found += sum(map(int, facts[11:15])) / _TICKS
    return found


sys.addaudithook(_watch)


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    """Note what the test and its fixtures cost, before its report is made at the end of its teardown."""
    _sidecars.clear()
    _starts.clear()
    item.stash[_BEGAN] = _seconds()
    return (yield)


_BEGAN = pytest.StashKey[float]()


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_teardown(item: pytest.Item) -> Iterator[None]:
    """Note it while there is still a report to come, which takes the properties along."""
    try:
        return (yield)
    finally:
        item.user_properties.append(("cpu", f"{_seconds() - item.stash[_BEGAN]:.3f}"))
        item.user_properties.append(("bakes", str(len(_sidecars))))
        item.user_properties.append(("starts", " ".join(_starts)))
