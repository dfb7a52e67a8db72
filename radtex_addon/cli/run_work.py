# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Run `bake.py work`: what a background worker was ordered by the panel (`worker.orders`)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

from ..core.errors import FormatError, InputError
from ..core.sampler import Filter
from ..formats.json_reader import Facts
from ..formats.sidecar_file import read_text
from ..job.bake_request import BakeRequest
from ..job.variants import Bake
from ..report.side_by_side import ComparisonSpec
from ..report.viewpoint import Viewpoint
from ..settings.spec import spec_in
from ..textures.export_spec import Target, export_spec_in
from ..worker.order import Work
from .arguments import Request
from .compare_arguments import CompareRequest
from .interruption import Interruption
from .options import ProgressStyle
from .reporting import Report
from .run_bake import run_bake
from .run_compare import run_compare
from .run_estimate import EstimateRequest, run_estimate
from .run_export import OrderedExports, run_exports
from .run_ordered_farm import OrderedAssembly, OrderedFarm, run_ordered_assembly, run_ordered_farm

_Ordered: TypeAlias = (
    Request | OrderedExports | CompareRequest | EstimateRequest | OrderedFarm | OrderedAssembly
)


@dataclass(frozen=True)
class WorkRequest:
    """The order in the file `order`. Its progress is read by the program that ordered it."""

    order: Path
    inside_blender: bool
    progress: ProgressStyle = ProgressStyle.JSON
    verbose: bool = False


def parse_work(arguments: list[str], inside_blender: bool) -> WorkRequest:
    """Parse what follows the command's name: the order's file. Raises InputError."""
    if len(arguments) != 1:
        raise InputError("a worker takes one order: the file that the panel wrote")
    return WorkRequest(Path(arguments[0]), inside_blender)


def run_work(request: WorkRequest, report: Report, interruption: Interruption) -> None:
    """Bake, export, compare, estimate, or prepare or assemble a farm as ordered. Raises RadTexError."""
    ordered = read_order(request)
    if isinstance(ordered, Request):
        run_bake(ordered, report, interruption)
    elif isinstance(ordered, EstimateRequest):
        run_estimate(ordered, report, interruption)
    elif isinstance(ordered, OrderedExports):
        run_exports(ordered, report, interruption)
    elif isinstance(ordered, OrderedFarm):
        run_ordered_farm(ordered, report, interruption)
    elif isinstance(ordered, OrderedAssembly):
        run_ordered_assembly(ordered, report, interruption)
    else:
        run_compare(ordered, report, interruption)


def read_order(request: WorkRequest) -> _Ordered:
    """What the order's file asks for. Raises RadTexError."""
    facts = Facts.parse(read_text(request.order), str(request.order), "order of a worker")
    work = Work(facts.choice("work", tuple(Work)))
    read: dict[Work, Callable[[Facts, WorkRequest], _Ordered]] = {
        Work.BAKE: _bake,
        Work.EXPORT: _export,
        Work.COMPARISON: _comparison,
        Work.ESTIMATE: _estimate,
        Work.PREPARATION: _preparation,
        Work.ASSEMBLY: _assembly,
    }
    try:
        return read[work](facts, request)
    except InputError as error:
        raise FormatError(
            f"{request.order} is an order that cannot be done ({error}): give it again"
        ) from error


def _bake(facts: Facts, request: WorkRequest) -> Request:
    name, spec = facts.text("name"), spec_in(facts.inner("spec"))
    picture = _path(facts, "picture")
    return Request(
        bakes=BakeRequest(
            objects=spec.objects or (name,),
            spec=spec,
            folder=Path(facts.text("folder")),
            shared=name if spec.objects else None,
            preview=_preview(facts),
            overwrite=facts.truth("overwrite"),
            overwrite_any="overwrite_any" in facts.values and facts.truth("overwrite_any"),
            blend=Path(facts.text("of_blend")) if "of_blend" in facts.values else None,
            resume=facts.truth("resume"),
            exports=tuple(map(Target, facts.choices("exports", tuple(Target)))),
        ),
        thumbnail=picture,
        map_picture=None if picture is None else picture.with_suffix(".map.png"),
        **_of_scene(facts, request),
    )


def _export(facts: Facts, request: WorkRequest) -> OrderedExports:
    sidecars, folders = (map(Path, facts.texts(key)) for key in ("sidecars", "folders"))
    return OrderedExports(
        bakes=tuple(zip(sidecars, folders, strict=True)),
        spec=export_spec_in(facts.inner("spec")),
        overwrite=facts.truth("overwrite"),
        progress=request.progress,
        verbose=request.verbose,
        scene=None if _absent(facts, "scene") else facts.text("scene"),
    )


def _comparison(facts: Facts, request: WorkRequest) -> CompareRequest:
    view, window = (_matrix(facts, key) for key in ("view", "window"))
    return CompareRequest(
        objects=facts.texts("objects"),
        bake=_path(facts, "bake") or Path("radtex"),
        sidecars=tuple(Path(each) if each else None for each in facts.texts("sidecars"))
        if "sidecars" in facts.values
        else (),
        eye=Viewpoint.of_view(view, window),
        spec=ComparisonSpec(
            facts.whole_number("pixels", 1), facts.whole_number("samples", 1), facts.text("device")
        ),
        out=Path(facts.text("folder")),
        **_of_scene(facts, request),
    )


def _estimate(facts: Facts, request: WorkRequest) -> EstimateRequest:
    return EstimateRequest(bakes=_bakes(facts), **_of_scene(facts, request))


def _preparation(facts: Facts, request: WorkRequest) -> OrderedFarm:
    return OrderedFarm(
        bakes=_bakes(facts),
        folder=Path(facts.text("folder")),
        preview=_preview(facts),
        overwrite=facts.truth("overwrite"),
        blend=Path(facts.text("of_blend")),
        **_of_scene(facts, request),
    )


def _assembly(facts: Facts, _: WorkRequest) -> OrderedAssembly:
    return OrderedAssembly(
        farm=Path(facts.text("farm")),
        folder=Path(facts.text("folder")),
        overwrite=facts.truth("overwrite"),
        overwrite_any=facts.truth("overwrite_any"),
    )


def _bakes(facts: Facts) -> tuple[Bake, ...]:
    specs = facts.inner("specs")
    return tuple(
        (name, spec_in(specs.inner(str(number)))) for number, name in enumerate(facts.texts("names"))
    )


def _preview(facts: Facts) -> Filter | None:
    return None if _absent(facts, "preview") else Filter(facts.choice("preview", tuple(Filter)))


def _of_scene(facts: Facts, request: WorkRequest) -> dict[str, Any]:
    """What to open, and how to report; Blender has opened the file already."""
    return {
        "scene": None if request.inside_blender else _path(facts, "blend"),
        "demo": False,
        "progress": request.progress,
        "verbose": request.verbose,
        "in_scene": facts.text("scene"),
        "unsaved_images": _path(facts, "images"),
        "parent_pipe": True,
    }


def _absent(facts: Facts, key: str) -> bool:
    return facts.values.get(key) is None


def _path(facts: Facts, key: str) -> Path | None:
    return None if _absent(facts, key) else Path(facts.text(key))


def _matrix(facts: Facts, key: str) -> list[list[float]]:
    """16 numbers, as the rows of a matrix. Raises FormatError."""
    numbers = facts.numbers(key, 16)
    return [numbers[first : first + 4] for first in range(0, 16, 4)]
