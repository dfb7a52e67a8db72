# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Run `bake.py export`."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from pathlib import Path

from ..bake.spec import Kind
from ..core.errors import InputError
from ..export.exporting import export_steps
from ..formats.disk.memory import readable_size
from ..formats.sidecar_file import SidecarFile
from ..report.finished_bake import find_bakes, object_of
from ..textures.export_spec import ExportSpec, Target
from .export_arguments import ExportRequest
from .interruption import Interruption
from .reporting import Report


def run_export(request: ExportRequest, report: Report, interruption: Interruption) -> None:
    """Export the bakes and report the folders. Raises RadTexError."""
    if request.parent_pipe:
        interruption.ask_when_input_ends()
    sidecars = find_bakes(request.bake, request.object, "exported", tuple(Kind))
    if len(sidecars) > 1 and request.out is not None:
        names = ", ".join(sidecar.path.name for sidecar in sidecars)
        raise InputError(f"{names} do not fit in one folder: name one of them, or leave --out out")
    for sidecar in sidecars:
        _export(sidecar, request, report, interruption)


def _export(sidecar: SidecarFile, request: ExportRequest, report: Report, interruption: Interruption) -> None:
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
    """Export a new bake for each target, without progress; returns the folders. Raises RadTexError."""
    folders = []
    for target in targets:
        steps = export_steps(sidecar, ExportSpec(target), overwrite=overwrite)
        folders.append(interruption.between(steps, lambda _: None).folder)
    return folders
