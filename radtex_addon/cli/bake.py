# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Run a bake from the command line."""

from __future__ import annotations

import os
from dataclasses import asdict
from functools import partial
from pathlib import Path

import bpy

from ..bake.key import is_unfinished
from ..bake.spec import BakeSpec
from ..bake.thumbnail import Thumbnail
from ..core.errors import InputError, RadTexError
from ..formats.disk.atomic import check_writable
from ..formats.disk.memory import readable_size
from ..formats.disk.path_checks import check_unicode
from ..job import BakeResult, OutputFiles, bake_steps, check_request, choose_layouts, part_specs
from ..job.output_collisions import check_files_apart
from ..job.variants import announce_all, left_to_do, passed_over, tidy
from ..prepare.unwrapping import Unwraps
from ..preview.picture import render_picture
from ..worker.images import load_unsaved
from .arguments import Request
from .failure import as_ours
from .interruption import INTERRUPTED, Interruption
from .opening import open_scene
from .reporting import Report
from .variants import titled, variants

_NAME = 255  # most bytes in a file name


def run_bake(request: Request, report: Report, interruption: Interruption) -> None:
    """Bake each object and report the results. Raises RadTexError."""
    if request.parent_pipe:
        interruption.ask_when_input_ends()
    scene = open_scene(request.scene, request.demo, request.in_scene)
    if request.unsaved_images is not None:
        load_unsaved(request.unsaved_images)
    specs = variants(request.specs, request.lights, scene)
    preview = request.preview is not None
    asked = [
        (name, part) for spec in specs for name in request.names for part in part_specs(scene, name, spec)
    ]
    choices = choose_layouts(
        scene, asked, request.open_layout, request.out, resume=request.resume, overwrite=request.overwrite
    )
    asked = list(choices)
    several = max(len(specs), len(request.names)) > 1 or request.spec.split is not None
    wanted = asked
    if request.resume and not request.overwrite and several:
        tidy(asked, request.out)
        wanted = list(left_to_do(asked, request.out, preview, request.exports))
        if not wanted:
            report.event("note", message=f"all {len(asked)} bakes are finished: nothing is left to do")
    if remark := passed_over(asked, wanted):
        report.event("warning", message=remark)
    for name, spec in wanted:  # check all before the first bake starts
        check_request(
            scene,
            name,
            spec,
            request.out,
            preview,
            request.overwrite,
            resume=request.resume,
            exports=request.exports,
        )
    check_files_apart(wanted, request.out, preview)
    _check_thumbnail(request.thumbnail)
    for line in dict.fromkeys(choices[bake].told(bake[0]) for bake in wanted):
        if line:
            report.event("note", message=line)
    announce_all(wanted, request.out, preview, request.exports, request.overwrite)
    unwraps: Unwraps = {}
    for number, (name, spec) in enumerate(wanted):
        title = titled(name, spec, number, len(wanted))
        result = _bake(scene, name, title, spec, request, unwraps, report, interruption)
        others = [*_pictures(request, result), *result.exported]
        facts = facts_of(spec, result, others)
        report.event("done", object=name, summary=summary_of(title, spec, result), **facts)


def _check_thumbnail(path: Path | None) -> None:
    if path is None:
        return
    check_unicode(path)
    if len(os.fsencode(path.name)) > _NAME:
        raise InputError(f"--thumbnail {path}: this name is longer than {_NAME} bytes: give a shorter one")
    if path.suffix.lower() != ".png":
        raise InputError(f"--thumbnail {path}: give the name of a PNG, such as {path.with_suffix('.png')}")
    if path.is_dir():
        raise InputError(f"--thumbnail {path} is a folder: name a file")
    check_writable(path.parent)


def _bake(
    scene: bpy.types.Scene,
    name: str,
    title: str,
    spec: BakeSpec,
    request: Request,
    unwraps: Unwraps,
    report: Report,
    interruption: Interruption,
) -> BakeResult:
    def written(path: Path) -> None:
        report.event("picture", object=name, path=str(path))

    steps = bake_steps(
        scene,
        name,
        spec,
        request.out,
        preview=request.preview,
        overwrite=request.overwrite,
        resume=request.resume,
        thumbnail=Thumbnail(request.thumbnail, written) if request.thumbnail else None,
        unwraps=unwraps,
        exports=request.exports,
    )
    try:
        return interruption.between(steps, partial(report.progress, title))
    except InputError:
        raise
    except (Exception, KeyboardInterrupt) as raised:  # whatever ends the bake, mention --resume
        raise _with_the_way_on(as_ours(raised), name, spec, request) from raised


def _with_the_way_on(failure: RadTexError, name: str, spec: BakeSpec, request: Request) -> RadTexError:
    """The same error; mentions --resume if an unfinished bake was kept."""
    files = OutputFiles.of(name, spec, request.out, preview=False)
    if not is_unfinished(files.unfinished):
        return failure
    what = "interrupted" if str(failure) == INTERRUPTED else str(failure)
    return type(failure)(f"{what}: what is finished of '{name}' is kept, go on with --resume")


def _pictures(request: Request, result: BakeResult) -> list[Path]:
    """For the demo, render a picture of the saved preview; returns its path, or nothing."""
    if not request.demo or result.files.preview is None:
        return []
    picture = result.files.preview.with_suffix(".png")
    render_picture(result.files.preview, picture)
    return [picture]


def summary_of(title: str, spec: BakeSpec, result: BakeResult) -> str:
    """One line on a finished bake, for people."""
    if result.was_there:
        return f"{title}: was baked already, and now has all that is made of it"
    layout = result.layout
    seconds = sum(result.seconds.values())
    size = readable_size(sum(path.stat().st_size for path in result.files.images))
    shared = ", shared," if spec.form.by_paths else ""
    lost = f", {result.fireflies:.1%} of the light lost as fireflies" if result.fireflies > 5e-4 else ""
    clamped = f", {result.clamped} values clamped to what the file holds" if result.clamped else ""
    return (
        f"{title}: {layout.width} x {layout.height} texels of {layout.bucket} x {layout.bucket} cells"
        f"{shared} at {spec.samples} spp, {result.covered_texels} texels covered, {result.paths:,} paths "
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


def facts_of(spec: BakeSpec, result: BakeResult, others: list[Path]) -> dict[str, object]:
    """The facts of a finished bake, for programs; `others` are files in addition to the bake's own."""
    return {
        "files": [str(path) for path in (*result.files.all, *others)],
        "layout": str(spec.layout),
        "objects": list(spec.objects),
        "part": spec.part,
        "frame": spec.frame,
        "lights": list(spec.lights),
        "texels": [result.layout.width, result.layout.height],
        "bucket": result.layout.bucket,
        "covered_texels": None if result.was_there else result.covered_texels,
        "islands": result.islands,
        "paths": None if result.was_there else result.paths,
        "device": result.device,
        "clamped": result.clamped,
        "fireflies": result.fireflies,
        "condensed": asdict(result.condensed) if result.condensed else None,
        "seconds": {str(stage): round(value, 3) for stage, value in result.seconds.items()},
    }
