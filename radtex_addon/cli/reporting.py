# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a run is: a bar on a terminal, or JSON lines for a pipeline."""

from __future__ import annotations

import json
import os
import shutil
import sys
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from enum import StrEnum
from pathlib import Path
from time import monotonic
from typing import Any, Protocol

from ..bake.progress import Stage
from ..core.printable import printable, printable_json
from ..export.progress import Task as ExportTask
from ..farm.progress import Task as FarmTask
from ..report.progress import Task
from .options import ProgressStyle
from .terminal import Output, draw, tell

_WIDTH = 28  # of the bar, in characters
_SAYS: dict[StrEnum, str] = {
    Stage.EVALUATE: "reading the mesh",
    Stage.UNWRAP: "unwrapping",
    Stage.RASTER: "placing texels",
    Stage.PROBE: "finding hidden cells",
    Stage.CAPTURE: "rendering",
    Stage.FILL: "filling gutters",
    Stage.FIT: "fitting",
    Stage.CONDENSE: "condensing",
    Stage.WRITE: "writing",
    Stage.PREVIEW: "saving the preview",
    Task.FIND_MESH: "finding its UV layer",
    Task.FIND_VIEWS: "looking for views",
    Task.REFERENCE: "path tracing",
    Task.COMPARE: "comparing",
    Task.PAGE: "writing the page",
    ExportTask.TEXTURES: "storing textures",
    ExportTask.FLAT: "averaging its light",
    ExportTask.MESH: "writing the mesh",
    ExportTask.PACK: "packing",
    FarmTask.HOLD: "holding it still",
    FarmTask.CHECK: "checking frames",
}


class Reached(Protocol):
    """Where a run is: `done` of `total` units of a stage."""

    @property
    def stage(self) -> StrEnum: ...

    @property
    def done(self) -> int: ...

    @property
    def total(self) -> int: ...


class Report(Protocol):
    """Hears of a run."""

    def progress(self, name: str, step: Reached) -> None:
        """Object `name` has come to `step`."""
        ...

    def event(self, kind: str, **facts: object) -> None:
        """Something that happened once: `done`, `warning`, `note`, `error`, `picture`.

        What is done has a `summary`, a line or several, and a list of `files`.
        """
        ...

    def check(self) -> None:
        """Raise BakeError if something could not be said."""
        ...

    def close(self) -> None:
        """Leave the terminal tidy."""
        ...


@contextmanager
def reporting(style: ProgressStyle, verbose: bool) -> Iterator[Report]:
    """A report on this process's standard output, kept free of Blender's chatter.

    That goes nowhere, or if `verbose` to standard error.
    """
    sys.stdout.flush()
    descriptor = os.dup(sys.stdout.fileno())
    # Names that are no Unicode (Linux allows them) become escapes, which JSON understands.
    with (
        os.fdopen(descriptor, "w", encoding="utf-8", errors="backslashreplace") as ours,
        _others_redirected(verbose),
    ):
        output = Output(ours)
        report: Report = (
            _Lines(output) if style is ProgressStyle.JSON else _Bar(output, style is ProgressStyle.BAR)
        )
        try:
            yield report
        finally:
            report.close()


@contextmanager
def _others_redirected(to_stderr: bool) -> Iterator[None]:
    """Send what others print to standard error, or nowhere: Blender's C code, and Python's `print`."""
    before = os.dup(1)
    with Path(os.devnull).open("w") as nowhere, redirect_stdout(sys.stderr if to_stderr else nowhere):
        os.dup2(2 if to_stderr else nowhere.fileno(), 1)
        try:
            yield
        finally:
            os.dup2(before, 1)
            os.close(before)


class _Clock:
    """Time left of a stage, from the pace since its first part: that one pays for setting up."""

    def __init__(self) -> None:
        self._key: tuple[str, StrEnum] | None = None
        self._first: tuple[int, float] | None = None

    def left(self, name: str, step: Reached) -> float | None:
        """Seconds until the stage is done; None while nothing is known."""
        if self._key != (name, step.stage):
            self._key, self._first = (name, step.stage), None
        if step.done == step.total:
            return 0.0
        if step.done == 0:
            return None
        if self._first is None:
            self._first = (step.done, monotonic())
        done, since = self._first
        if step.done == done:
            return None
        return (monotonic() - since) * (step.total - step.done) / (step.done - done)


class _Lines:
    """One JSON object a line, on standard output."""

    def __init__(self, output: Output) -> None:
        self._output, self._clock = output, _Clock()
        self._said: tuple[str, Reached] | None = None

    def progress(self, name: str, step: Reached) -> None:
        left = self._clock.left(name, step)
        if self._said == (name, step):  # a stage that knows no parts only says that it lives
            return
        self._said = (name, step)
        self.event(
            "progress",
            object=name,
            stage=str(step.stage),
            done=step.done,
            total=step.total,
            seconds_left=None if left is None else round(left, 1),
        )

    def event(self, kind: str, **facts: object) -> None:
        if isinstance(facts.get("summary"), tuple):
            facts["summary"] = "\n".join(_summary(facts))
        self._output.say([printable_json(json.dumps({"event": kind, **facts}, ensure_ascii=False))])

    def check(self) -> None:
        self._output.check()

    def close(self) -> None:
        pass


class _Bar:
    """A bar on standard error, or a line a stage if that is no terminal; results on standard output."""

    def __init__(self, output: Output, shown: bool) -> None:
        self._output, self._shown, self._clock = output, shown, _Clock()
        self._terminal = sys.stderr is not None and sys.stderr.isatty()
        self._drawn, self._said = 0, ""

    def progress(self, name: str, step: Reached) -> None:
        left = self._clock.left(name, step)
        if not self._shown:
            return
        if not self._terminal:
            line = f"{name}: {_SAYS[step.stage]}"
            if line != self._said:
                tell(line)
                self._said = line
            return
        share = step.done / step.total if step.total else 1.0
        bar = "#" * int(share * _WIDTH)
        wait = "" if left is None or step.done == step.total else f"  {_clock_face(left)} left"
        self._draw(f"{name}  {_SAYS[step.stage]:<20} [{bar:<{_WIDTH}}] {share:4.0%}{wait}")

    def event(self, kind: str, **facts: object) -> None:
        if kind == "picture":  # the bar shows enough
            return
        self.close()
        if kind == "done":
            files: Any = facts["files"]
            lines = [*_summary(facts), *(f"  {path}" for path in files if path)]
            self._output.say(map(printable, lines))
        elif kind != "error":  # an error's line is the batch's own
            tell(f"radtex: {kind}: {facts.get('message')}")

    def check(self) -> None:
        self._output.check()

    def close(self) -> None:
        if self._drawn:
            self._draw("")
            draw("\r")
            self._drawn = 0

    def _draw(self, text: str) -> None:
        text = printable(text)[: shutil.get_terminal_size().columns - 1]  # what wraps cannot be drawn over
        draw(f"\r{text:<{self._drawn}}")
        self._drawn = len(text)


def _clock_face(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes}:{rest:02d}"


def _summary(facts: dict[str, object]) -> tuple[str, ...]:
    """Its lines."""
    summary = facts["summary"]
    return tuple(map(str, summary)) if isinstance(summary, tuple) else (str(summary),)
