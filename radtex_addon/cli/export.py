# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A run of `bake.py export`."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import closing

from ..export.progress import Step
from ..export.run import Exported, export_steps
from ..formats.memory import readable_size
from ..report.finished import find_bake, object_of
from .export_arguments import ExportRequest
from .interruption import Interruption
from .reporting import Report


def run_export(request: ExportRequest, report: Report, interruption: Interruption) -> None:
    """Make the folder and say what is in it. Raises RadTexError."""
    sidecar = find_bake(request.bake, request.object, "exported")
    name = object_of(sidecar)
    steps = export_steps(sidecar, request.spec, request.out, overwrite=request.overwrite)
    made = _finish(steps, name, report, interruption)
    summary = f"{name} for {made.target}: {len(made.files)} files, {readable_size(made.bytes)}"
    report.event(
        "done",
        object=name,
        summary=summary,
        files=[str(made.folder)],
        contents=list(made.files),
        target=str(made.target),
        bytes=made.bytes,
    )


def _finish(
    steps: Generator[Step, None, Exported], name: str, report: Report, interruption: Interruption
) -> Exported:
    with closing(steps):
        while True:
            interruption.check()
            try:
                report.progress(name, next(steps))
            except StopIteration as stop:
                made: Exported = stop.value
                return made
