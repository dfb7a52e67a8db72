# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Run xatlas in a process of its own, which can be killed at any time.

In Blender's process xatlas could freeze or crash Blender, and could not be cancelled: see `xatlas_worker.py`.
"""

from __future__ import annotations

import pickle
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from queue import Empty, SimpleQueue
from threading import Thread
from typing import Any, TypeAlias

import bpy

from ...bake.progress import Progress, Stage, Steps
from ...core.arrays import Floats, Ints
from ...core.child_process import pipes_of
from ...core.errors import BakeError, InputError
from ...core.messages import Setting, do

_WORKER = Path(__file__).with_name("xatlas_worker.py")
_PULSE = 0.1  # seconds between two reports of progress
_LAST_WORDS = 1.0  # seconds that a process without a valid answer gets to end by itself
_OWN_LAYER = do("bake on a UV layer of your own", Setting.UV)

Options: TypeAlias = Mapping[str, float]  # attributes of xatlas's ChartOptions or PackOptions


@dataclass(frozen=True, eq=False)
class XatlasCharts:
    """A flattened mesh: `uv` (V, 2) in 0..1 of the atlas, `index` (F, 3) into it, `owner` (V,) its island.

    An `owner` of `count` or more means no island.
    """

    width: int
    height: int
    texels_per_unit: float
    count: int
    index: Ints
    uv: Floats
    owner: Ints


def check_xatlas() -> None:
    """Raise InputError if there is no xatlas, or no Python to run it."""
    if find_spec("xatlas") is None:
        raise InputError(
            "the Python module 'xatlas' is missing",
            do("install the RadTex extension in Blender, or with Python run it as: uv run bake.py"),
            _OWN_LAYER,
        )
    if not sys.executable or sys.executable == bpy.app.binary_path:
        raise InputError("this Blender names no Python that could run xatlas", _OWN_LAYER)


class XatlasProcess:
    """A context manager for the xatlas process, which is killed at exit, also after an exception.

    Each request is a generator that yields progress about ten times a second while xatlas works, and returns
    the answer; it raises BakeError if the process dies. Only one request may run at a time.
    """

    def __init__(self) -> None:
        """Start the process. Raises InputError if that fails."""
        check_xatlas()
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115  # closed at exit
        # Isolated: or the worker's own folder would come first on sys.path, and could hide standard modules.
        command = [sys.executable, "-I", str(_WORKER)]
        try:
            self._process = subprocess.Popen(
                command,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=self._errors,
                creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
            )
        except OSError as error:
            self._errors.close()
            raise InputError(
                f"xatlas needs a Python to run in, but {sys.executable} does not start ({error.strerror})",
                _OWN_LAYER,
            ) from error
        self._thread: Thread | None = None

    def __enter__(self) -> XatlasProcess:
        with suppress(OSError):  # the first request will report that the process has died
            self._send(sys.path)
        return self

    def __exit__(self, *_: object) -> None:
        self._process.kill()
        self._process.wait()
        if self._thread is not None:
            self._thread.join()  # it ends, since the process's pipes are closed
        for pipe in pipes_of(self._process):
            with suppress(OSError):  # half a request may be left in it
                pipe.close()
        self._errors.close()

    def flatten(
        self, points: Floats, faces: Ints, normals: Floats, chart: Options, pack: Options
    ) -> Steps[XatlasCharts]:
        """Flatten a mesh: points and normals (V, 3) float32, faces (F, 3) uint32."""
        return XatlasCharts(*(yield from self._ask("flatten", points, faces, normals, chart, pack)))

    def _ask(self, name: str, *arguments: object) -> Steps[tuple[Any, ...]]:
        """Send a request from a thread: Windows cannot wait for a pipe with a timeout."""
        answers: SimpleQueue[tuple[Any, ...] | None] = SimpleQueue()
        self._thread = Thread(target=self._exchange, args=((name, arguments), answers), daemon=True)
        self._thread.start()
        while True:
            try:
                answer = answers.get(timeout=_PULSE)
            except Empty:
                yield Progress(Stage.UNWRAP, 0, 1)
                continue
            if answer is None:
                raise BakeError(
                    f"the unwrap failed, xatlas ended early ({self._last_words()})",
                    do("let Blender unwrap", Setting.UNWRAP, value="blender"),
                    _OWN_LAYER,
                )
            return answer

    def _exchange(self, request: object, answers: SimpleQueue[tuple[Any, ...] | None]) -> None:
        answer = None
        try:
            self._send(request)
            answer = pickle.load(pipes_of(self._process)[1])
        except (OSError, EOFError, pickle.UnpicklingError):
            with suppress(subprocess.TimeoutExpired):  # it has died or is no Python: stderr says why
                self._process.wait(_LAST_WORDS)
            self._process.kill()
        finally:
            answers.put(answer)

    def _send(self, message: object) -> None:
        stdin = pipes_of(self._process)[0]
        stdin.write(pickle.dumps(message, pickle.HIGHEST_PROTOCOL))
        stdin.flush()

    def _last_words(self) -> str:
        """The last line of the process's standard error, or else its exit code."""
        code = self._process.wait()
        self._errors.seek(0)
        lines = self._errors.read().decode(errors="replace").split("\n")
        return next((line.strip() for line in reversed(lines) if line.strip()), f"exit code {code}")
