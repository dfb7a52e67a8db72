# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""xatlas in its own process: it answers, it can be ended at any time, and its death is one clear error."""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from time import monotonic
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.bake.progress import Progress, Stage, Steps
from radtex_addon.core.arrays import Floats, Ints
from radtex_addon.core.errors import BakeError, InputError
from radtex_addon.scene.mesh.evaluated import EvaluatedMesh, evaluate
from radtex_addon.scene.scratch import scratch_scene
from radtex_addon.scene.uv import xatlas_worker
from radtex_addon.scene.uv.unwrap import unwrap_steps
from radtex_addon.scene.uv.xatlas_process import XatlasCharts, XatlasProcess, check_xatlas
from radtex_addon.settings.spec import Unwrap

pytestmark = pytest.mark.one_blender
context: Any = bpy.context  # to the stubs, every pointer may be None
POSIX = pytest.mark.skipif(os.name != "posix", reason="signals and shell scripts")

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], np.float32)
HALVES = np.array([[0, 1, 2], [0, 2, 3]], np.uint32)
UP = np.tile(np.array([0, 0, 1], np.float32), (4, 1))


def flatten_square(xatlas: XatlasProcess) -> Steps[XatlasCharts]:
    return xatlas.flatten(SQUARE, HALVES, UP, {}, {"resolution": 64})


def answer(steps: Steps[XatlasCharts], seconds: float = 60.0) -> XatlasCharts:
    """What a request returns, waited for no longer than `seconds`."""
    end = monotonic() + seconds
    while monotonic() < end:
        try:
            next(steps)
        except StopIteration as stop:
            charts: XatlasCharts = stop.value
            return charts
    pytest.fail(f"no answer within {seconds} s")


@pytest.fixture
def started(monkeypatch: pytest.MonkeyPatch) -> list[subprocess.Popen[bytes]]:
    """The processes that were started since."""
    processes: list[subprocess.Popen[bytes]] = []

    class Noted(subprocess.Popen[bytes]):
        def __init__(self, *arguments: Any, **options: Any) -> None:
            super().__init__(*arguments, **options)
            processes.append(self)

    monkeypatch.setattr(subprocess, "Popen", Noted)
    return processes


def test_a_square_is_flattened_to_scale() -> None:
    with XatlasProcess() as xatlas:
        charts = answer(flatten_square(xatlas))
        corners = charts.uv[charts.index] * [charts.width, charts.height] / charts.texels_per_unit
    sides = np.sqrt(np.sum(np.diff(corners, axis=1) ** 2, axis=-1))
    assert sides == pytest.approx(np.array([[1, 1], [2**0.5, 1]]), rel=0.15)


def test_the_process_is_gone_after_the_context_however_it_ends(
    started: list[subprocess.Popen[bytes]],
) -> None:
    with XatlasProcess():
        pass
    with pytest.raises(ZeroDivisionError), XatlasProcess():
        raise ZeroDivisionError
    assert [process.returncode is not None for process in started] == [True, True]


# cancelling


def bumpy(side: int) -> tuple[Floats, Ints]:
    """A sheet of side * side quads, each tilted another way, as points and triangles."""
    x, y = np.meshgrid(*[np.arange(side + 1)] * 2)
    z = np.random.default_rng(0).random(x.shape)
    number = np.arange(x.size).reshape(x.shape)
    a, b, c, d = (
        corner.ravel() for corner in (number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1])
    )
    points: Floats = np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1).astype(np.float64)
    return points, np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])


def large() -> EvaluatedMesh:
    """70,000 triangles: a minute's work for xatlas."""
    mesh = bpy.data.meshes.new("large")
    points, faces = bumpy(187)
    mesh.from_pydata(points.tolist(), [], faces.tolist())
    item = bpy.data.objects.new("large", mesh)
    context.scene.collection.objects.link(item)
    with scratch_scene(context.scene) as scratch:
        return evaluate(scratch, item)


def test_a_long_unwrap_shows_life_and_stops_at_once(started: list[subprocess.Popen[bytes]]) -> None:
    steps = unwrap_steps(large(), 512, Unwrap.XATLAS)
    assert next(steps) == Progress(Stage.UNWRAP, 0, 1)
    since = monotonic()
    for _ in range(10):
        next(steps)
    assert 0.9 < monotonic() - since < 5
    (process,) = started
    assert process.poll() is None
    since = monotonic()
    steps.close()
    assert monotonic() - since < 1  # 0.2 s on a calm machine
    assert process.returncode is not None


@POSIX
def test_ctrl_c_in_the_terminal_is_left_to_the_parent(started: list[subprocess.Popen[bytes]]) -> None:
    with XatlasProcess() as xatlas:
        answer(flatten_square(xatlas))
        started[0].send_signal(signal.SIGINT)
        assert answer(flatten_square(xatlas)).width > 8


PARENT = """
import pickle, subprocess, sys
worker = subprocess.Popen([sys.executable, "-I", sys.argv[1]], stdin=-1, stdout=-1)
pickle.dump(sys.path, worker.stdin)
worker.stdin.write(sys.stdin.buffer.read())
worker.stdin.flush()
print("asked", flush=True)
worker.stdout.read()
"""


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere it ends with the request")
def test_the_process_dies_with_its_parent_in_the_midst_of_work() -> None:
    points, faces = bumpy(187)
    mesh = points.astype(np.float32), faces.astype(np.uint32), np.ones_like(points, dtype=np.float32)
    command = [sys.executable, "-c", PARENT, str(xatlas_worker.__file__)]
    with subprocess.Popen(command, stdin=-1, stdout=-1, stderr=-1) as parent:
        assert parent.stdin is not None
        assert parent.stdout is not None
        parent.stdin.write(pickle.dumps(("flatten", (*mesh, {}, {}))))
        parent.stdin.close()
        assert parent.stdout.readline() == b"asked\n"
        parent.stdin = None
        parent.kill()
        _, errors = parent.communicate(timeout=10)  # standard error ends when the worker has let go of it
    assert errors == b""


# failing


def with_xatlas(folder: Path, source: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the process find another xatlas."""
    (folder / "xatlas.py").write_text(source)
    monkeypatch.syspath_prepend(folder)


def test_what_libraries_print_disturbs_no_answer(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    real = next(path for path in map(Path, sys.path) if list(path.glob("xatlas.*.*")))
    noisy = (
        "import os, sys\nprint('noise')\nos.write(1, b'noise')\ndel sys.modules['xatlas']\n"
        f"sys.path.insert(0, {str(real)!r})\nimport xatlas\n"
    )
    with_xatlas(tmp_path, noisy, monkeypatch)
    with XatlasProcess() as xatlas:
        assert answer(flatten_square(xatlas)).width > 8


@pytest.mark.parametrize(
    ("source", "said"),
    [
        ("raise MemoryError('too many triangles')", r"MemoryError: too many triangles"),
        ("import os; os.abort()", r"exit code \S+"),
        ("import sys; sys.exit('no licence')", r"SystemExit: no licence"),
    ],
)
def test_the_death_of_the_process_is_one_line_with_a_remedy(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, source: str, said: str
) -> None:
    with_xatlas(tmp_path, source, monkeypatch)
    expected = rf"^the unwrap failed, xatlas ended early \({said}\): let Blender unwrap, or .* of your own$"
    with XatlasProcess() as xatlas, pytest.raises(BakeError, match=expected):
        answer(flatten_square(xatlas))


def refuse_by_empty_name(folder: Path) -> str:
    return ""


def refuse_by_missing_file(folder: Path) -> str:
    return str(folder / "python")


@pytest.mark.parametrize("executable", [refuse_by_empty_name, refuse_by_missing_file])
def test_without_a_python_there_is_a_remedy(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, executable: Callable[[Path], str]
) -> None:
    monkeypatch.setattr(sys, "executable", executable(tmp_path))
    with pytest.raises(InputError, match=r"Python .*: bake on a UV layer of your own$"):
        XatlasProcess()


@POSIX
def test_what_is_no_python_is_a_failed_unwrap(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    program = tmp_path / "python"
    program.write_text("#!/bin/sh\necho rubbish\necho I am no Python >&2\nexit 3\n")
    program.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(program))
    with XatlasProcess() as xatlas, pytest.raises(BakeError, match=r"\(I am no Python\)"):
        answer(flatten_square(xatlas))


def test_a_missing_xatlas_is_known_beforehand(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "xatlas", None)
    with pytest.raises(InputError, match=r"'xatlas' is missing: install the RadTex extension"):
        check_xatlas()
