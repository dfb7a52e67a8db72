# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Run a bake from the command line."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path

import bpy

from ..bake.progress import Progress
from ..bake.thumbnail import Thumbnail
from ..core.errors import Cancelled, InputError, RadTexError
from ..core.messages import Message, Setting, do
from ..core.uv_map import UvMap
from ..formats.disk.atomic import check_writable
from ..formats.disk.memory import readable_size
from ..formats.disk.path_checks import check_unicode
from ..forms.layered.capture.panoramas import pictures_shared
from ..job import BakeResult
from ..job.bake_plan import BakePlan, check_plans, steps_of_bakes
from ..job.variants import title_of
from ..preview.save import render_picture
from ..settings.bake_names import filled
from ..settings.spec import BakeSpec
from ..settings.texel_density import told_density
from ..store.bake_folder import FolderState
from ..textures.export_spec import Target
from ..textures.kept_exports import kept_exports
from .arguments import Request
from .asset_plans import asset_lines, atlases_of, plans_of
from .collection_objects import with_collections
from .failure import as_ours, end_process
from .interruption import INTERRUPTED, Interruption
from .opening import open_asked
from .reporting import Report
from .run_export import export_again
from .serving import address, serving
from .whole_progress import WholeProgress, whole_progress
from .wording import told

_NAME = 255  # most bytes in a file name


def run_bake(request: Request, report: Report, interruption: Interruption) -> None:
    """Bake each object and report the results. Raises RadTexError."""
    scene = open_asked(request, interruption)
    request = with_collections(scene, request, report)
    with serving(request.bakes.folder, request.serve) as port:
        done = _bake(scene, request, report, interruption, "")
        pages = [page for each in done for page in each.exported if page.suffix == f".{Target.WEB}"]
        for page in pages if port is not None else ():
            report.event("note", message=f"{page.stem} is shown at {address(port or 0, page)}")
        for number in range(1, request.passes):
            again = replace(request.bakes, spec=replace(request.bakes.spec, accumulate=True), overwrite=True)
            if request.demo:  # its picture has opened another file
                scene = open_asked(request, interruption)
            _bake(scene, replace(request, bakes=again), report, interruption, f", pass {number + 1}")
        if port is not None:
            report.event("note", message="the page is served until Ctrl-C")
            interruption.wait()


def _bake(
    scene: bpy.types.Scene, request: Request, report: Report, interruption: Interruption, after: str
) -> list[BakeResult]:
    """Bake each object once and report the results, their titles ending in `after`."""
    done: list[BakeResult] = []
    kept = kept_exports(scene) if request.export_again else ()
    atlases = atlases_of(scene, request.bakes)
    plans = plans_of(scene, request.bakes, atlases)
    _tell_of_bakes_there(plans, report)
    check_plans(scene, plans)
    _check_thumbnail(request.thumbnail)
    for line in (line for plan in plans for line in plan.layout_lines):
        report.event("note", message=line)
    for found in () if after else asset_lines(scene, request.bakes, plans):
        report.event("note", **told(found))
    for atlas in () if after else atlases:
        report.event("note", message=atlas.told)
        if request.bakes.spec.density is not None and (capped := atlas.capped(request.bakes.spec.density)):
            report.event("warning", **told(capped))
    wanted = [bake for plan in plans for bake in plan.wanted]
    asked = request.bakes
    whole = whole_progress(wanted, asked.saves_preview, len(asked.exports), asked.resume)
    failures: list[InputError] = []
    with pictures_shared():
        for plan in plans:
            of_plan = replace(request, bakes=plan.request)
            try:
                done += _bake_plan(scene, plan, of_plan, report, interruption, after, whole)
            except InputError as error:
                if not request.bakes.as_scene:
                    raise
                failures.append(error)
    if request.export_again and done:
        export_again(kept, [each.files.sidecar for each in done], report, interruption)
    if failures:
        raise _without_some(failures, len(wanted))
    return done


def _without_some(failures: Sequence[InputError], count: int) -> InputError:
    """The error of a scene some of whose atlases cannot be baked; the others are."""
    lines = "; ".join(error.message.problem for error in failures)
    remedies = dict.fromkeys(remedy for error in failures for remedy in error.message.remedies)
    return InputError(f"{len(failures)} of {count} atlases were left out: {lines}", *remedies)


def _tell_of_bakes_there(plans: Sequence[BakePlan], report: Report) -> None:
    """Report what is known of bakes that are there: which have changed, and which are left out."""
    for line in (line for plan in plans for line in plan.change_lines):
        report.event("note", message=line)
    if not any(plan.wanted for plan in plans):
        state = "unchanged" if any(plan.found for plan in plans) else "finished"
        count = sum(len(plan.choices) for plan in plans)
        which = f"all {count} bakes are" if count > 1 else "the bake is"
        report.event("note", message=f"{which} {state}: nothing is left to do")
    for skipped in (plan.skipped for plan in plans if plan.skipped):
        report.event("warning", **told(Message(skipped)))


def _bake_plan(
    scene: bpy.types.Scene,
    plan: BakePlan,
    request: Request,
    report: Report,
    interruption: Interruption,
    after: str,
    whole: WholeProgress,
) -> list[BakeResult]:
    """Make the bakes of a plan, which was checked, and report each.

    `whole` counts the bakes of all plans.
    """
    done: list[BakeResult] = []
    thumbnail = partial(_thumbnail, request, report)
    for number, (name, spec, steps) in enumerate(steps_of_bakes(scene, plan, thumbnail)):
        title = _numbered_title(name, spec, number, len(plan.wanted)) + after
        leave = partial(_leave, name, spec, request, report)
        whole.begin()
        with _saying_how_to_resume(name, spec, request), interruption.leaving(leave):
            result = interruption.between(steps, partial(_tell_progress, report, title, whole))
        others = [*_pictures(request, result), *result.exported]
        facts = facts_of(spec, result, others)
        report.event("done", object=name, summary=summary_of(title, spec, result), **facts)
        done.append(result)
    return done


def _tell_progress(report: Report, title: str, whole: WholeProgress, step: Progress) -> None:
    report.progress(title, step, whole.at(step))


def _numbered_title(name: str, spec: BakeSpec, number: int, count: int) -> str:
    """The title of bake `number` (from 0) in a run of `count` bakes."""
    title = title_of(name, spec)
    return title if title == filled(spec.bake_name, name) else f"{title} ({number + 1} of {count})"


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


def _thumbnail(request: Request, report: Report, name: str) -> Thumbnail | None:
    """A picture of what is done of the bake called `name`, if one is wanted."""
    if request.thumbnail is None:
        return None

    def tell_map(uv_map: UvMap) -> None:
        covered = round(uv_map.coverage, 4)
        path = str(request.map_picture)
        report.event("map", object=name, path=path, islands=uv_map.islands, coverage=covered)

    return Thumbnail(
        request.thumbnail,
        lambda written: report.event("picture", object=name, path=str(written)),
        request.map_picture,
        tell_map,
    )


@contextmanager
def _saying_how_to_resume(name: str, spec: BakeSpec, request: Request) -> Iterator[None]:
    """Add to every error of a bake but InputError, which asks for another request, how to resume it."""
    try:
        yield
    except InputError:
        raise
    except (Exception, KeyboardInterrupt) as raised:
        raise _with_the_way_on(as_ours(raised), name, spec, request) from raised


def _leave(name: str, spec: BakeSpec, request: Request, report: Report) -> None:
    """End the process in the midst of a render, as a signal asks for: what is finished is kept."""
    end_process(_with_the_way_on(Cancelled(INTERRUPTED), name, spec, request), report)


def _with_the_way_on(failure: RadTexError, name: str, spec: BakeSpec, request: Request) -> RadTexError:
    """The same error; says how to resume if an unfinished bake was kept."""
    if request.bakes.place((name, spec)).state is not FolderState.UNFINISHED:
        return failure
    problem = failure.message.problem
    what = "interrupted" if problem == INTERRUPTED else problem
    return failure.saying(
        f"{what}; what is finished of '{name}' is kept", do("go on with it", Setting.RESUME)
    )


def _pictures(request: Request, result: BakeResult) -> list[Path]:
    """For the demo, render a picture of the saved preview; returns its path, or nothing."""
    if not request.demo or result.files.preview is None:
        return []
    picture = result.files.preview.with_suffix(".png")
    render_picture(result.files.preview, picture)
    return [picture]


def summary_of(title: str, spec: BakeSpec, result: BakeResult) -> str:
    """One line on a finished bake, for people."""
    if result.was_finished:
        return f"{title}: was baked already, and now has all that is made of it"
    layout = result.layout
    seconds = sum(result.seconds.values())
    size = readable_size(sum(path.stat().st_size for path in result.files.images))
    cells = f" of {layout.bucket} x {layout.bucket} cells" if spec.form.any_cells else ""
    stored = f", {spec.form.layout}," if spec.form.by_paths else ""
    density = f", {told_density(result.density)}" if result.density is not None else ""
    clamped = f", {result.clamped} values clamped to what the file holds" if result.clamped else ""
    return (
        f"{title}: {layout.width} x {layout.height} texels{cells}{density}"
        f"{stored} at {spec.samples} spp, {result.covered_texels} texels covered{_map_of(result)}, "
        f"{result.paths:,} paths on {result.device} in {seconds:.1f} s, {size}{clamped}"
    )


def _map_of(result: BakeResult) -> str:
    """How much of the atlas the islands cover, as far as that is known."""
    if result.islands is None or result.coverage is None:
        return ""
    islands = "1 island" if result.islands == 1 else f"{result.islands} islands"
    return f" ({islands} on {result.coverage:.0%} of the atlas)"


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
        "covered_texels": None if result.was_finished else result.covered_texels,
        "islands": result.islands,
        "triangles": result.triangles,
        "coverage": result.coverage,
        "wasteful": result.wasteful or None,
        "texel_density": result.density,
        "paths": None if result.was_finished else result.paths,
        "device": result.device,
        "clamped": result.clamped,
        "seconds": {str(stage): round(value, 3) for stage, value in result.seconds.items()},
    }
