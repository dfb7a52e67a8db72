# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Run `bake.py export`."""

from __future__ import annotations

from collections.abc import Generator, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from time import monotonic

from ..core.errors import Cancelled, InputError, RadTexError
from ..export.exporting import Exported, ExportSource, check_folders_differ, export_steps
from ..export.exporting_scene import export_again_steps, export_scene_steps
from ..formats.disk.memory import readable_size
from ..formats.sidecar_file import SidecarFile
from ..report.finished_bake import find_bakes, find_bakes_of_all, object_of
from ..settings.spec import Kind
from ..textures.export_spec import ExportSpec, ExportStep, Target
from ..textures.kept_exports import KeptExport, real
from ..worker.orders import EXPORTING, exported_part
from .export_arguments import ExportRequest
from .interruption import Interruption
from .options import ProgressStyle
from .reporting import Report
from .wording import told

_DONE = "exported"


@dataclass(frozen=True)
class OrderedExports:
    """Exports that the panel has ordered: of each bake the sidecar, and the folder to make.

    `scene` is the name if all are one scene, whose folder each of them names.
    """

    bakes: tuple[tuple[Path, Path], ...]
    spec: ExportSpec
    overwrite: bool
    progress: ProgressStyle
    verbose: bool
    scene: str | None = None


def run_export(request: ExportRequest, report: Report, interruption: Interruption) -> None:
    """Export the bakes and report the folders. Raises RadTexError."""
    if request.parent_pipe:
        interruption.ask_when_input_ends()
    sidecars = _sidecars(request)
    if request.scene is not None:
        scene = export_scene_steps(
            sidecars, request.spec, request.scene, request.out, overwrite=request.overwrite
        )
        _export(request.scene, scene, report, interruption)
        return
    if len(sidecars) > 1 and request.out is not None:
        names = ", ".join(sidecar.path.name for sidecar in sidecars)
        raise InputError(
            f"{names} do not fit in one folder: name one of them, leave --out out, or export them as one "
            "scene (--scene)"
        )
    if len(sidecars) > 1:
        check_folders_differ([ExportSource.of(each).folder(request.spec.target) for each in sidecars])
    for sidecar in sidecars:
        steps = export_steps(sidecar, request.spec, request.out, overwrite=request.overwrite)
        _export(object_of(sidecar), steps, report, interruption)


def run_exports(request: OrderedExports, report: Report, interruption: Interruption) -> None:
    """Export the bakes that were ordered. Of several, those that fail are warned of, and the others made.

    Raises RadTexError if none is made.
    """
    interruption.ask_when_input_ends()
    if request.scene is not None:
        (out,) = {out for _, out in request.bakes}
        sidecars = [path for path, _ in request.bakes]
        scene = export_scene_steps(sidecars, request.spec, request.scene, out, overwrite=request.overwrite)
        _export(request.scene, scene, report, interruption)
    elif len(request.bakes) == 1:
        ((path, out),) = request.bakes
        (sidecar,) = find_bakes(path, None, _DONE, tuple(Kind))
        steps = export_steps(sidecar, request.spec, out, overwrite=request.overwrite)
        _export(object_of(sidecar), steps, report, interruption)
    else:
        _export_each(request, report, interruption)


def _export_each(request: OrderedExports, report: Report, interruption: Interruption) -> None:
    """Export several bakes, each into a folder of its own. Raises RadTexError if none is made."""
    made, errors, size, since = list[Path](), list[RadTexError](), 0, monotonic()
    total = len(request.bakes)

    def tell(number: int, name: str, step: ExportStep) -> None:
        done = number + exported_part(step)
        left = (monotonic() - since) / done * (total - done) if number else None
        report.event("progress", object=name, stage=EXPORTING, done=done, total=total, seconds_left=left)

    for number, (path, out) in enumerate(request.bakes):
        try:
            steps = export_steps(path, request.spec, out, overwrite=request.overwrite)
            exported = interruption.between(steps, partial(tell, number, path.stem))
        except Cancelled:
            raise
        except RadTexError as error:
            errors.append(error)
            report.event("warning", **told(error.message))
            continue
        made.append(exported.folder)
        size += exported.bytes
    if not made:
        raise errors[0]
    summary = f"{len(made)} bakes for {request.spec.target}: {readable_size(size)}"
    folders = [str(folder) for folder in made]
    report.event("done", object="", summary=summary, files=folders, target=request.spec.target, bytes=size)


def _sidecars(request: ExportRequest) -> list[SidecarFile]:
    """The bakes that are meant; for a scene those of all objects in a folder, unless one is named."""
    if request.scene is not None and request.object is None:
        return [file for bake in request.bakes for file in find_bakes_of_all(bake, _DONE, tuple(Kind))]
    return [
        file
        for bake in request.bakes
        for file in find_bakes(bake, request.object, _DONE, tuple(Kind), or_called=True)
    ]


def _export(
    name: str, steps: Generator[ExportStep, None, Exported], report: Report, interruption: Interruption
) -> None:
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


def export_again(
    kept: Sequence[KeptExport], sidecars: Iterable[Path], report: Report, interruption: Interruption
) -> None:
    """Make those of the `kept` exports again that are of new bakes, by these sidecars, and report each.

    Of several, those that fail are warned of, and the others made. Raises RadTexError if any has failed.
    """
    made = set(map(real, sidecars))
    due = [each for each in kept if each.is_of(made)]
    if not due:
        report.event("note", message="the .blend keeps no export of these bakes: none is made again")
    errors: list[RadTexError] = []
    for each in due:
        try:
            _export(each.name, export_again_steps(each), report, interruption)
        except Cancelled:
            raise
        except RadTexError as error:
            errors.append(error)
    for other in errors[1:]:
        report.event("warning", **told(other.message))
    if errors:
        raise errors[0]


def export_baked(
    sidecar: Path, targets: Iterable[Target], overwrite: bool, interruption: Interruption
) -> list[Path]:
    """Export a new bake for each target, without progress; returns the folders. Raises RadTexError."""
    folders = []
    for target in targets:
        steps = export_steps(sidecar, ExportSpec(target), overwrite=overwrite)
        folders.append(interruption.between(steps, lambda _: None).folder)
    return folders
