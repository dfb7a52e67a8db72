# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A run of the batch, from arguments to exit code."""

from __future__ import annotations

import logging
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from functools import partial
from pathlib import Path

import bpy

from ..bake.checkpoint import is_unfinished
from ..bake.spec import Layout
from ..bake.thumbnail import Thumbnail
from ..core.errors import BakeError, Cancelled, InputError, RadTexError
from ..formats.atomic import check_writable
from ..formats.memory import readable_size
from ..job import BakeResult, OutputFiles, bake_steps, check_request
from ..preview.picture import render_picture
from ..scene.demo import OBJECT
from ..worker.images import load_unsaved
from .arguments import Request, parse
from .export import export_baked, run_export
from .export_arguments import ExportRequest, parse_export
from .interruption import INTERRUPTED, Interruption, interruptible
from .opening import open_scene
from .options import EXPORT, REPORT
from .report import run_report
from .report_arguments import ReportRequest, parse_report
from .reporting import Report, reporting


def main(arguments: list[str], inside_blender: bool) -> int:
    """Run the batch with `arguments`; returns the exit code. An error is one line on standard error."""
    request: Request | ReportRequest | ExportRequest
    try:
        if arguments[:1] == [REPORT]:
            request = parse_report(arguments[1:], inside_blender)
        elif arguments[:1] == [EXPORT]:
            request = parse_export(arguments[1:], inside_blender)
        else:
            request = parse(arguments, inside_blender)
    except RadTexError as error:
        return _complain(error)
    with reporting(request.progress, request.verbose) as report:
        try:
            with _warnings_to(report), interruptible() as interruption:
                if isinstance(request, ReportRequest):
                    run_report(request, report, interruption)
                elif isinstance(request, ExportRequest):
                    run_export(request, report, interruption)
                else:
                    _run(request, report, interruption)
        except (Exception, KeyboardInterrupt) as raised:  # noqa: BLE001  # or Blender went on, and left with 0
            failure = _as_ours(raised)
            report.event("error", message=str(failure), exit_code=failure.exit_code)
            report.close()
            return _complain(failure)
    return 0


def _complain(error: RadTexError) -> int:
    print(f"radtex: {error}", file=sys.stderr, flush=True)
    return error.exit_code


def _as_ours(raised: BaseException) -> RadTexError:
    """What to tell the user; a mistake of our own shows its traceback too."""
    if isinstance(raised, RadTexError):
        return raised
    if isinstance(raised, KeyboardInterrupt):
        return Cancelled(INTERRUPTED)
    if isinstance(raised, MemoryError):
        return BakeError("out of memory: use fewer texels or cells, or a smaller --memory")
    if isinstance(raised, OSError):
        return BakeError(f"the system refuses: {raised}; make room, or choose another folder")
    traceback.print_exception(raised)
    return BakeError(f"a mistake in RadTex ({type(raised).__name__}): please report it, with the lines above")


@contextmanager
def _warnings_to(report: Report) -> Iterator[None]:
    """Hand the library's warnings to the report, each once."""
    library = logging.getLogger(__name__.rpartition(".cli.")[0])
    handler = _Warnings(report)
    library.addHandler(handler)
    try:
        yield
    finally:
        library.removeHandler(handler)


class _Warnings(logging.Handler):
    def __init__(self, report: Report) -> None:
        super().__init__(logging.WARNING)
        self._report = report
        self._said: set[str] = set()

    def emit(self, record: logging.LogRecord) -> None:
        message = record.getMessage()
        if message not in self._said:
            self._said.add(message)
            self._report.event("warning", message=message)


def _run(request: Request, report: Report, interruption: Interruption) -> None:
    if request.parent_pipe:
        interruption.ask_when_input_ends()
    scene = open_scene(request.scene, request.demo, request.in_scene)
    if request.unsaved_images is not None:
        load_unsaved(request.unsaved_images)
    objects = request.objects or (OBJECT,)
    for name in objects:  # all of them, before the first bake
        check_request(
            scene,
            name,
            request.spec,
            request.out,
            request.preview is not None,
            request.overwrite,
            resume=request.resume,
        )
    _check_thumbnail(request.thumbnail)
    for name in objects:
        result = _bake(scene, name, request, report, interruption)
        others = _pictures(request, result)
        others += export_baked(result.files.sidecar, request.exports, request.overwrite, interruption)
        facts = _facts(request, result, others)
        report.event("done", object=name, summary=_summary(name, request, result), **facts)


def _check_thumbnail(path: Path | None) -> None:
    if path is None:
        return
    if path.suffix.lower() != ".png":
        raise InputError(f"--thumbnail {path}: give the name of a PNG, such as {path.with_suffix('.png')}")
    if path.is_dir():
        raise InputError(f"--thumbnail {path} is a folder: name a file")
    check_writable(path.parent)


def _bake(
    scene: bpy.types.Scene, name: str, request: Request, report: Report, interruption: Interruption
) -> BakeResult:
    def written(path: Path) -> None:
        report.event("picture", object=name, path=str(path))

    steps = bake_steps(
        scene,
        name,
        request.spec,
        request.out,
        preview=request.preview,
        overwrite=request.overwrite,
        resume=request.resume,
        thumbnail=Thumbnail(request.thumbnail, written) if request.thumbnail else None,
    )
    try:
        return interruption.between(steps, partial(report.progress, name))
    except InputError:
        raise
    except (Exception, KeyboardInterrupt) as raised:  # of all that can end a bake
        raise _with_the_way_on(_as_ours(raised), name, request) from raised


def _with_the_way_on(failure: RadTexError, name: str, request: Request) -> RadTexError:
    """The same, which also says that a bake can be gone on with, if it can."""
    files = OutputFiles.of(name, request.spec, request.out, preview=False)
    if not is_unfinished(files.unfinished):
        return failure
    what = "interrupted" if str(failure) == INTERRUPTED else str(failure)
    return type(failure)(f"{what}: what is finished of '{name}' is kept, go on with --resume")


def _pictures(request: Request, result: BakeResult) -> list[Path]:
    """The demo shows itself: a picture of the saved preview."""
    if not request.demo or result.files.preview is None:
        return []
    picture = result.files.preview.with_suffix(".png")
    render_picture(result.files.preview, picture)
    return [picture]


def _summary(name: str, request: Request, result: BakeResult) -> str:
    layout = result.layout
    seconds = sum(result.seconds.values())
    size = readable_size(sum(path.stat().st_size for path in result.files.images))
    shared = ", shared," if request.spec.layout is Layout.SHARED else ""
    lost = f", {result.fireflies:.1%} of the light cut off as fireflies" if result.fireflies > 5e-4 else ""
    clamped = f", {result.clamped} values clamped to what the file holds" if result.clamped else ""
    return (
        f"{name}: {layout.width} x {layout.height} texels of {layout.bucket} x {layout.bucket} cells{shared} "
        f"at {request.spec.samples} spp, {result.covered_texels} texels covered, {result.paths:,} paths "
        f"on {result.device} in {seconds:.1f} s, {size}{_condensed(result)}{lost}{clamped}"
    )


def _condensed(result: BakeResult) -> str:
    chosen = result.condensed
    if chosen is None:
        return ""
    clusters = " and ".join(str(count) for count in chosen.clusters) or "no"
    return (
        f" ({chosen.bytes / 1e6:.2f} MB on a GPU) in {clusters} clusters, "
        f"{chosen.agreement:.1f} dB from what was fitted"
    )


def _facts(request: Request, result: BakeResult, others: list[Path]) -> dict[str, object]:
    return {
        "files": [str(path) for path in (*result.files.all, *others)],
        "layout": str(request.spec.layout),
        "texels": [result.layout.width, result.layout.height],
        "bucket": result.layout.bucket,
        "covered_texels": result.covered_texels,
        "islands": result.islands,
        "paths": result.paths,
        "device": result.device,
        "clamped": result.clamped,
        "fireflies": result.fireflies,
        "condensed": asdict(result.condensed) if result.condensed else None,
        "seconds": {str(stage): round(value, 3) for stage, value in result.seconds.items()},
    }
