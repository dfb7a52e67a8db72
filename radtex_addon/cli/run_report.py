# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Run `bake.py report`."""

from __future__ import annotations

from dataclasses import replace

from ..job.instances import join_for
from ..report.finished_bake import find_bake, object_of, objects_and_frame
from ..report.report_bake import ReportResult, report_path, report_steps
from ..report.report_progress import ReportStep
from .interruption import Interruption
from .opening import open_scene
from .options import check_psnr
from .report_arguments import ReportRequest
from .reporting import Report


def run_report(request: ReportRequest, report: Report, interruption: Interruption) -> None:
    """Measure the bake's quality and report the results. Raises RadTexError.

    QualityError: the mean of the views is below `min_psnr`.
    """
    sidecar = find_bake(request.bake, request.object, or_called=True)
    sidecar = replace(sidecar, path=sidecar.path.absolute())  # a relative path is Blender's, of its own file
    name = object_of(sidecar)
    out = request.out or report_path(sidecar)
    scene = open_scene(request.scene, request.demo, request.in_scene)
    join_for(scene, *objects_and_frame(sidecar))
    steps = report_steps(scene, sidecar, request.spec, out)

    def tell(step: ReportStep) -> None:
        report.progress(f"{name}, {step.about}" if step.about else name, step)

    result = interruption.between(steps, tell)
    report.event("done", object=name, summary=_summary(result), **_facts(result))
    check_psnr(name, result.psnr, request.min_psnr)


def _summary(result: ReportResult) -> str:
    flip = "" if result.flip is None else f", FLIP {result.flip:.3f}"
    floor = f"path tracing to itself {result.floor:.1f} dB"
    found = f"{result.verdict} Energy {result.energy:.3f}{flip}, {floor}.{_worst(result)}"
    return found if result.first_change is None else f"{found} {result.first_change}"


def _worst(result: ReportResult) -> str:
    for name, part in result.parts.items():
        return f" The worst of its {len(result.parts)} objects is '{name}': {part.mean.psnr:.1f} dB."
    return ""


def _facts(result: ReportResult) -> dict[str, object]:
    return {
        "files": [str(result.page)],
        "psnr": round(result.psnr, 3),
        "flip": None if result.flip is None else round(result.flip, 4),
        "energy": round(result.energy, 4),
        "noise_floor": round(result.floor, 3),
        "bytes": {"disk": result.disk, "gpu": result.gpu},
        "lost": {name: round(value, 3) for name, value in result.lost.items()},
        "first_change": result.first_change,
        "parts": {
            name: {
                "psnr": round(part.mean.psnr, 3),
                "flip": None if part.mean.flip is None else round(part.mean.flip, 4),
                "energy": round(part.mean.energy, 4),
            }
            for name, part in result.parts.items()
        },
    }
