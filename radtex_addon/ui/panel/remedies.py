# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a request to bake would meet, and which settings would help."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import bpy

from ...bake.key import is_unfinished
from ...core.errors import InputError
from ...core.messages import Message, Setting, do
from ...job.bake_plan import BakePlan, plan_bakes, preflight
from ...job.bake_request import BakeRequest
from ...job.output_files import OutputFiles
from ...job.preflight import Preflight


def foreseen(scene: bpy.types.Scene, request: BakeRequest, patience: float) -> Preflight:
    """What the bakes of a request would meet, as far as `patience` seconds tell. Changes nothing."""
    try:
        plan = plan_bakes(scene, request, guess=True)
        check_left(plan)
    except InputError as error:
        return Preflight((error.message,))
    return preflight(scene, plan, patience)


def check_left(plan: BakePlan) -> None:
    """Raise InputError if resuming finds all bakes finished."""
    request = plan.request
    if plan.choices and not plan.wanted and not plan.may_lack_parts:
        what = "objects" if len(request.objects) > 1 else "variants"
        raise InputError(f"all {what} are finished", do("bake anew", Setting.OVERWRITE))


def remedies(
    scene: bpy.types.Scene, request: BakeRequest, errors: Sequence[Message], patience: float
) -> dict[str, int]:
    """Settings that would settle some of the `errors` if toggled, and how many errors each leaves."""
    overwrite = [error for error in errors if Setting.OVERWRITE in _used(error)]
    if request.resume:
        resume = [error for error in errors if _is_settled_without(Setting.RESUME, error)]
    else:
        resume = _settled_by_resuming(scene, request, errors, overwrite, patience)
    settled = {"overwrite": overwrite, "resume": resume}
    return {name: len(errors) - len(found) for name, found in settled.items() if found}


def _settled_by_resuming(
    scene: bpy.types.Scene,
    request: BakeRequest,
    errors: Sequence[Message],
    existing: list[Message],
    patience: float,
) -> list[Message]:
    """Errors about unfinished bakes, or `existing` ones of several, if resuming meets fewer than `errors`."""
    unfinished = [error for error in errors if Setting.RESUME in _used(error)]
    try:
        found = unfinished or (existing if existing and request.is_of_several(scene) else [])
    except InputError:  # there are no lamps, or no such object
        return []
    anew = replace(request, resume=True, overwrite=False)
    return found if found and len(foreseen(scene, anew, patience).errors) < len(errors) else []


def _is_settled_without(setting: Setting, error: Message) -> bool:
    return any(setting in remedy.without for remedy in error.remedies)


def forgets(scene: bpy.types.Scene, request: BakeRequest, patience: float) -> bool:
    """Whether a request would discard an unfinished bake that could be resumed."""
    if request.resume or not request.overwrite or not _unfinished(scene, request):
        return False
    return not foreseen(scene, replace(request, resume=True), patience).errors


def _unfinished(scene: bpy.types.Scene, request: BakeRequest) -> bool:
    """Whether any of the requested bakes was started and not finished."""
    try:
        bakes = plan_bakes(scene, request, guess=True).wanted
    except InputError:
        return False
    files = [OutputFiles.of(name, spec, request.folder, request.saves_preview) for name, spec in bakes]
    return any(is_unfinished(one.unfinished) for one in files)


def _used(error: Message) -> set[Setting]:
    """The settings that its remedies turn on."""
    return {setting for remedy in error.remedies for setting in remedy.settings}
