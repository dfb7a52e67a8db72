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
from typing import Protocol, TextIO

from ..bake.progress import Stage
from ..core.errors import Cancelled
from ..export.progress import Task as ExportTask
from ..farm.progress import Task as FarmTask
from ..report.progress import Task
from .options import ProgressStyle

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
        """Something that happened once: `done`, `warning`, `note`, `error`, `picture`."""
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
        report: Report = (
            _Lines(ours) if style is ProgressStyle.JSON else _Bar(ours, style is ProgressStyle.BAR)
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


def _send_nowhere(descriptor: int) -> None:
    with Path(os.devnull).open("w") as nowhere:
        os.dup2(nowhere.fileno(), descriptor)


def _say(stream: TextIO, text: str) -> None:
    """Print to our standard output; a reader that has gone (`| head`) ends the run."""
    try:
        print(text, file=stream, flush=True)
    except BrokenPipeError:
        _send_nowhere(stream.fileno())  # what the stream still holds must go somewhere
        raise Cancelled("nobody reads the standard output any more: the bake was given up") from None


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

    def __init__(self, stream: TextIO) -> None:
        self._stream, self._clock = stream, _Clock()
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
        _say(self._stream, json.dumps({"event": kind, **facts}, ensure_ascii=False))

    def close(self) -> None:
        pass


class _Bar:
    """A bar on standard error, or a line a stage if that is no terminal; results on standard output."""

    def __init__(self, stream: TextIO, shown: bool) -> None:
        self._stream, self._shown, self._clock = stream, shown, _Clock()
        self._terminal = sys.stderr.isatty()
        self._drawn, self._said = 0, ""

    def progress(self, name: str, step: Reached) -> None:
        left = self._clock.left(name, step)
        if not self._shown:
            return
        if not self._terminal:
            line = f"{name}: {_SAYS[step.stage]}"
            if line != self._said:
                print(line, file=sys.stderr, flush=True)
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
            _say(self._stream, _summary(facts))
        elif kind != "error":  # an error's line is the batch's own
            print(f"radtex: {kind}: {facts.get('message')}", file=sys.stderr, flush=True)

    def close(self) -> None:
        if self._drawn:
            self._draw("")
            print("\r", end="", file=sys.stderr, flush=True)
            self._drawn = 0

    def _draw(self, text: str) -> None:
        text = text[: shutil.get_terminal_size().columns - 1]  # a line that wraps cannot be drawn over
        print(f"\r{text:<{self._drawn}}", end="", file=sys.stderr, flush=True)
        self._drawn = len(text)


def _clock_face(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes}:{rest:02d}"


def _summary(facts: dict[str, object]) -> str:
    lines = [str(facts["summary"]), *(f"  {path}" for path in facts["files"] if path)]  # type: ignore[attr-defined]  # a list of paths
    return "\n".join(lines)
