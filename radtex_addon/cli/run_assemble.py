# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Run `bake.py assemble`."""

from __future__ import annotations

from functools import partial

from ..core.errors import InputError
from ..farm.assemble_farm import assemble_steps
from ..farm.farm_files import FarmFiles
from ..farm.farm_manifest import read_manifest
from ..settings.targets import check_target
from ..store.bake_folder import BakeFolder
from .assemble_arguments import AssembleRequest
from .interruption import Interruption
from .reporting import Report
from .run_bake import facts_of, summary_of
from .run_export import export_baked


def run_assemble(request: AssembleRequest, report: Report, interruption: Interruption) -> None:
    """Check and join the farm's frames, and report the result. Raises RadTexError."""
    if request.parent_pipe:
        interruption.ask_when_input_ends()
    manifest = read_manifest(FarmFiles(request.farm))
    for target in request.exports:
        check_target("the farm", manifest.spec.kind, target)
        if manifest.copies is None:
            raise InputError("--export is made from the preview: prepare the farm with --save-preview")
    if request.exports:
        folder = request.farm.absolute().parent if request.out is None else request.out
        place = BakeFolder(manifest.name, manifest.spec, folder, preview=True)
        place.check_exports(request.exports, request.overwrite, resume=False)
    steps = assemble_steps(
        request.farm, request.out, overwrite=request.overwrite, overwrite_any=request.overwrite_any
    )
    made = interruption.between(steps, partial(report.progress, manifest.name))
    sidecar = made.result.files.sidecar
    others = export_baked(sidecar, request.exports, request.overwrite, interruption)
    facts = facts_of(made.spec, made.result, others)
    report.event("done", object=made.name, summary=summary_of(made.name, made.spec, made.result), **facts)
