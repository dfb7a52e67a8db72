# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Run `bake.py prepare`."""

from __future__ import annotations

from dataclasses import asdict
from functools import partial

from ..core.errors import InputError
from ..core.quoting import quoted
from ..farm.frame_list import commands
from ..farm.prepare_farm import Farm, prepare_steps
from ..job import Choice
from .arguments import Request
from .collection_objects import with_collections
from .interruption import Interruption
from .opening import open_asked
from .options import ASSEMBLE
from .reporting import Report

_LISTED = 20  # most files listed in the summary


def run_prepare(request: Request, report: Report, interruption: Interruption) -> None:
    """Write the farm's folder and print the commands that render it. Raises RadTexError."""
    scene = open_asked(request, interruption)
    request = with_collections(scene, request, report)
    asked = request.bakes.asked(scene)
    if len(asked) > 1:
        raise InputError(
            f"a farm makes one atlas, and these are {len(asked)}: prepare them one by one (--lights, --part)"
        )
    ((name, spec),) = asked
    out, preview = request.bakes.folder, request.bakes.preview
    overwrite = request.bakes.may_replace(request.bakes.overwrite)
    steps = prepare_steps(scene, name, spec, out, preview=preview, overwrite=overwrite)
    farm = interruption.between(steps, partial(report.progress, name))
    if request.bakes.open_layout is not None:
        report.event("note", message=Choice(spec, "a farm renders no other").told(name))
    report.event("done", object=name, summary=_summary(name, farm), **_facts(farm))


def _summary(name: str, farm: Farm) -> tuple[str, ...]:
    manifest = farm.manifest
    height, width = manifest.pixels
    blender, _ = commands(farm.files, range(1, manifest.sheets + 1))
    beside = f", with {len(farm.beside)} files beside the .blend" if farm.beside else ""
    made = (
        f"{name}: {manifest.sheets} frames of {width} x {height} pixels at {manifest.spec.samples} spp, "
        f"{farm.texels} texels covered, for {manifest.device}{beside}"
    )
    return (
        made,
        *_carried(farm),
        f"render them: {blender}",
        f"then join them: {quoted(['python', 'bake.py', ASSEMBLE, str(farm.files.folder)])}",
    )


def _carried(farm: Farm) -> list[str]:
    """A heading, and a line for each file of this machine that is included with the farm's folder."""
    lines = [f"  {each}" for each in farm.carried[:_LISTED]]
    if not lines:
        return ["no other file of this machine goes along with its folder"]
    if left := len(farm.carried) - len(lines):
        lines.append(f"  … and {left} more, which {farm.files.manifest.name} lists")
    return ["these files of this machine go along with its folder:", *lines]


def _facts(farm: Farm) -> dict[str, object]:
    manifest = farm.manifest
    return {
        "files": [str(farm.files.folder)],
        "job": manifest.job,
        "blend": str(farm.files.blend),
        "frames": [1, manifest.sheets],
        "beside": list(farm.beside),
        "carried": [asdict(each) for each in farm.carried],
        "device": manifest.device,
    }
