# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Report a run's progress and results: a bar on a terminal, or JSON lines for programs."""

from __future__ import annotations

import json
import os
import shutil
import sys
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from enum import StrEnum
from pathlib import Path
from typing import Any, Protocol

from ..bake.progress import Stage
from ..core.quoting import printable, printable_json
from ..farm.farm_progress import FarmTask
from ..report.report_progress import ReportTask
from ..settings.time_left import Left, told_left
from ..textures.export_spec import ExportTask
from .options import ProgressStyle
from .terminal import Output, draw, tell
from .whole_progress import Reached, StepClock, Whole

_WIDTH = 12  # width of the bar, in characters
_SAYS: dict[StrEnum, str] = {
    Stage.EVALUATE: "reading the mesh",
    Stage.UNWRAP: "unwrapping",
    Stage.RASTER: "laying out the texture",
    Stage.PROBE: "finding hidden parts",
    Stage.CAPTURE: "rendering the light",
    Stage.SURROUNDINGS: "rendering what is around it",
    Stage.DENOISE: "denoising",
    Stage.FILL: "filling gaps",
    Stage.FIT: "making the textures",
    Stage.WRITE: "writing",
    Stage.PREVIEW: "saving the preview",
    ReportTask.FIND_MESH: "finding its UV layer",
    ReportTask.FIND_VIEWS: "looking for views",
    ReportTask.REFERENCE: "rendering the original",
    ReportTask.COMPARE: "comparing",
    ReportTask.PAGE: "writing the page",
    ExportTask.TEXTURES: "storing textures",
    ExportTask.FLAT: "averaging its light",
    ExportTask.MESH: "writing the mesh",
    ExportTask.PACK: "packing",
    FarmTask.HOLD: "holding it still",
    FarmTask.CHECK: "checking frames",
}


class Report(Protocol):
    """Receives the progress and the events of a run."""

    def progress(self, name: str, step: Reached, whole: Whole | None = None) -> None:
        """Object `name` has reached `step`; of several bakes, all together have come as far as `whole`."""
        ...

    def event(self, kind: str, **facts: object) -> None:
        """Report an event of a `kind`: `done`, `warning`, `note`, `error`, `picture`, `map`.

        `done` has a `summary`, a string or a tuple of lines, and a list of `files`.
        """
        ...

    def check(self) -> None:
        """Raise BakeError if any output was lost."""
        ...

    def close(self) -> None:
        """Clear the progress bar."""
        ...


@contextmanager
def reporting(style: ProgressStyle, verbose: bool) -> Iterator[Report]:
    """A report on this process's standard output, without Blender's own messages.

    Those are discarded, or sent to standard error if `verbose`.
    """
    sys.stdout.flush()
    descriptor = os.dup(sys.stdout.fileno())
    # Escape file names that are not valid Unicode (Linux allows them); the escapes are valid JSON.
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
    """Redirect all other output on stdout, of Blender's C code and Python's `print`, to stderr or nowhere."""
    before = os.dup(1)
    with Path(os.devnull).open("w") as nowhere, redirect_stdout(sys.stderr if to_stderr else nowhere):
        os.dup2(2 if to_stderr else nowhere.fileno(), 1)
        try:
            yield
        finally:
            os.dup2(before, 1)
            os.close(before)


class _Lines:
    """Report that prints one JSON object per line on standard output."""

    def __init__(self, output: Output) -> None:
        self._output, self._clock = output, StepClock()
        self._said: tuple[str, Reached] | None = None

    def progress(self, name: str, step: Reached, whole: Whole | None = None) -> None:
        left = self._clock.left(name, step)
        if self._said == (name, step):  # repeated step, from a stage that cannot count its progress
            return
        self._said = (name, step)
        facts: dict[str, object] = {}
        if whole is not None:
            facts = {
                "whole": round(whole.share, 4),
                "whole_seconds_left": _seconds(whole.left),
                "whole_seconds_range": [round(whole.left.least, 1), round(whole.left.most, 1)],
            }
        self.event(
            "progress",
            object=name,
            stage=str(step.stage),
            done=step.done,
            total=step.total,
            seconds_left=_seconds(left),
            **facts,
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
    """Report with a bar on stderr, or one line per stage if that is no terminal; results on stdout."""

    def __init__(self, output: Output, shown: bool) -> None:
        self._output, self._shown, self._clock = output, shown, StepClock()
        self._terminal = sys.stderr is not None and sys.stderr.isatty()
        self._drawn, self._said = 0, ""

    def progress(self, name: str, step: Reached, whole: Whole | None = None) -> None:
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
        if whole is not None:
            share, left = whole.share, whole.left
        wait = "" if share == 1 else f"  {told_left(left)}"
        if whole is None and left.is_known and wait:
            wait += " of this step"
        bar = "#" * int(share * _WIDTH)
        self._draw(f"{name}  {_SAYS[step.stage]:<27} [{bar:<{_WIDTH}}] {share:4.0%}{wait}")

    def event(self, kind: str, **facts: object) -> None:
        if kind in ("picture", "map"):  # not shown beside the bar
            return
        self.close()
        if kind == "done":
            files: Any = facts["files"]
            lines = [*_summary(facts), *(f"  {path}" for path in files if path)]
            self._output.say(map(printable, lines))
        elif kind != "error":  # main() prints the error
            tell(f"radtex: {kind}: {facts.get('message')}")

    def check(self) -> None:
        self._output.check()

    def close(self) -> None:
        if self._drawn:
            self._draw("")
            draw("\r")
            self._drawn = 0

    def _draw(self, text: str) -> None:
        text = printable(text)[: shutil.get_terminal_size().columns - 1]  # wrapped lines cannot be redrawn
        draw(f"\r{text:<{self._drawn}}")
        self._drawn = len(text)


def _seconds(left: Left) -> float | None:
    """The most likely time, for programs; None while it is not known."""
    return round(left.seconds, 1) if left.is_known else None


def _summary(facts: dict[str, object]) -> tuple[str, ...]:
    """The lines of a summary."""
    summary = facts["summary"]
    return tuple(map(str, summary)) if isinstance(summary, tuple) else (str(summary),)
