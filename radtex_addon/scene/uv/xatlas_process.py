# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""xatlas, asked from here and run in a process of its own, which can be ended at any time.

In Blender's own process it could hang or crash it, and nobody could cancel it: see `xatlas_worker.py`.
"""

from __future__ import annotations

import pickle
import subprocess
import sys
import tempfile
from collections.abc import Generator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from queue import Empty, SimpleQueue
from threading import Thread
from typing import IO, Any, TypeAlias, TypeVar

import bpy

from ...bake.progress import Progress, Stage
from ...core.arrays import Floats, Ints
from ...core.errors import BakeError, InputError

_WORKER = Path(__file__).with_name("xatlas_worker.py")
_PULSE = 0.1  # seconds between two signs of life
_LAST_WORDS = 1.0  # seconds that a process which answers nothing of use may take to end by itself
_REMEDY = "bake on a UV layer of your own, by --uv"

_Result = TypeVar("_Result")
Steps: TypeAlias = Generator[Progress, None, _Result]
Options: TypeAlias = Mapping[str, float]  # attributes of xatlas's ChartOptions or PackOptions


@dataclass(frozen=True, eq=False)
class Charts:
    """A flattened mesh: `uv` (V, 2) in 0..1 of the atlas, `index` (F, 3) into it, `owner` (V,) its island.

    An owner that is not below `count` is none.
    """

    width: int
    height: int
    texels_per_unit: float
    count: int
    index: Ints
    uv: Floats
    owner: Ints


@dataclass(frozen=True, eq=False)
class Placed:
    """Packed islands: `uv` (V, 2) in 0..1 of the atlas, `index` (F, 3) into it."""

    width: int
    height: int
    index: Ints
    uv: Floats


def check_xatlas() -> None:
    """Raise InputError where there is no xatlas, or no Python to run it."""
    if find_spec("xatlas") is None:
        raise InputError(
            "the Python module 'xatlas' is missing: install the RadTex extension in Blender, or with Python "
            f"run it as: uv run bake.py; or {_REMEDY}"
        )
    if not sys.executable or sys.executable == bpy.app.binary_path:
        raise InputError(f"this Blender names no Python that could run xatlas: {_REMEDY}")


class XatlasProcess:
    """A context in which xatlas answers; at its exit, however that comes, the process is killed.

    A request is a generator that yields progress about ten times a second while xatlas works, and returns the
    answer; one at a time. It raises BakeError where the process dies.
    """

    def __init__(self) -> None:
        """Start the process. Raises InputError where that cannot be."""
        check_xatlas()
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115  # closed at exit
        # Isolated: or the worker's own folder came first on its path, and hid the standard library's `copy`.
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
                f"xatlas needs a Python to run in, but {sys.executable} does not start ({error.strerror}): "
                f"{_REMEDY}"
            ) from error
        self._thread: Thread | None = None

    def __enter__(self) -> XatlasProcess:
        with suppress(OSError):  # the first request will say that it has died
            self._send(sys.path)
        return self

    def __exit__(self, *_: object) -> None:
        self._process.kill()
        self._process.wait()
        if self._thread is not None:
            self._thread.join()  # its pipes have ended
        for pipe in self._pipes:
            with suppress(OSError):  # half a request may be left in it
                pipe.close()
        self._errors.close()

    def flatten(
        self, points: Floats, faces: Ints, normals: Floats, chart: Options, pack: Options
    ) -> Steps[Charts]:
        """Flatten a mesh: points and normals (V, 3) float32, faces (F, 3) uint32."""
        return Charts(*(yield from self._ask("flatten", points, faces, normals, chart, pack)))

    def pack(self, points: Floats, faces: Ints, owner: Ints, options: Options) -> Steps[Placed]:
        """Place flat islands: points (V, 2) float32, faces (F, 3) and their islands `owner` (F, 1) uint32."""
        return Placed(*(yield from self._ask("pack", points, faces, owner, options)))

    def _ask(self, name: str, *arguments: object) -> Steps[tuple[Any, ...]]:
        """Ask in a thread, for Windows cannot wait for a pipe and a clock at once."""
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
                    f"the unwrap failed, xatlas ended early ({self._last_words()}): try --unwrap blender, or "
                    f"{_REMEDY}"
                )
            return answer

    def _exchange(self, request: object, answers: SimpleQueue[tuple[Any, ...] | None]) -> None:
        answer = None
        try:
            self._send(request)
            answer = pickle.load(self._pipes[1])
        except (OSError, EOFError, pickle.UnpicklingError):
            with suppress(subprocess.TimeoutExpired):  # it has died, or is no Python at all, and says why
                self._process.wait(_LAST_WORDS)
            self._process.kill()
        finally:
            answers.put(answer)

    def _send(self, message: object) -> None:
        stdin = self._pipes[0]
        stdin.write(pickle.dumps(message, pickle.HIGHEST_PROTOCOL))
        stdin.flush()

    @property
    def _pipes(self) -> tuple[IO[bytes], IO[bytes]]:
        stdin, stdout = self._process.stdin, self._process.stdout
        assert stdin is not None  # both are pipes, as asked for
        assert stdout is not None
        return stdin, stdout

    def _last_words(self) -> str:
        """The last line of the process's standard error, or else its exit code."""
        code = self._process.wait()
        self._errors.seek(0)
        lines = self._errors.read().decode(errors="replace").split("\n")
        return next((line.strip() for line in reversed(lines) if line.strip()), f"exit code {code}")
