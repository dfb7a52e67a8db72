# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A run of `bake.py export`."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from pathlib import Path

from ..bake.spec import Kind
from ..export.run import export_steps
from ..export.spec import ExportSpec, Target
from ..formats.memory import readable_size
from ..report.finished import find_bake, object_of
from .export_arguments import ExportRequest
from .interruption import Interruption
from .reporting import Report


def run_export(request: ExportRequest, report: Report, interruption: Interruption) -> None:
    """Make the folder and say what is in it. Raises RadTexError."""
    if request.parent_pipe:
        interruption.ask_when_input_ends()
    sidecar = find_bake(request.bake, request.object, "exported", tuple(Kind))
    name = object_of(sidecar)
    steps = export_steps(sidecar, request.spec, request.out, overwrite=request.overwrite)
    made = interruption.between(steps, partial(report.progress, name))
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


def export_baked(
    sidecar: Path, targets: Iterable[Target], overwrite: bool, interruption: Interruption
) -> list[Path]:
    """Make a folder for each target of a bake just made, in silence; returns them. Raises RadTexError."""
    folders = []
    for target in targets:
        steps = export_steps(sidecar, ExportSpec(target), overwrite=overwrite)
        folders.append(interruption.between(steps, lambda _: None).folder)
    return folders
