# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a request to bake would meet: errors, warnings, and bakes that are there already."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import inf
from time import monotonic
from typing import Any

import bpy

from ...core.errors import InputError
from ...core.messages import Message, Setting, do
from ...job.bake_plan import BakePlan, plan_bakes, preflight
from ...job.bake_request import BakeRequest
from ...job.left_out import Found, LeftOut, find_bakeable
from ...job.preflight import Preflight
from ...preview.swap import is_on
from ...scene.mesh.mesh_checks import scale_in_world
from ...store.bake_folder import FolderState
from ..jobs.repeated_exports import RepeatedExports
from ..settings.bake_settings import BakeSettings
from ..settings.object_settings import by_settings
from ..settings.request import spec_of, values_of

_EVEN = 1.01  # the longest axis to the shortest


@dataclass(frozen=True)
class FilesThere:
    """How many `bakes` a request is for, and how many of them are `finished` and `unfinished` on disk.

    `done` are those of the finished ones that have these settings. Of those that are `unfinished`, `former`
    have an earlier finished bake beside what was begun.
    """

    bakes: int = 0
    finished: int = 0
    unfinished: int = 0
    done: int = 0
    former: int = 0


def sort_out(
    scene: bpy.types.Scene,
    names: Sequence[str],
    values: Callable[[BakeSettings], dict[str, Any]] = values_of,
    *,
    shows_objects: bool = True,
    patience: float = inf,
    evaluate: bool = False,
) -> Found:
    """Which of the objects can be baked by their settings, and why the others are left out.

    `values` are the settings' values; `patience` and `evaluate` are as in `find_bakeable`. If the bake
    `shows_objects` whose preview is on, these can be baked.
    """
    found: dict[str, LeftOut] = {}
    shown = {item.name for item in scene.objects if is_on(item)} if shows_objects else set()
    groups = by_settings(scene, [name for name in names if name not in shown])
    for settings, group in groups:
        of_group = values(settings)
        try:
            spec = spec_of(of_group)
        except InputError:  # which the bake's own checks report
            spec = None
        left = find_bakeable(
            scene,
            group,
            spec,
            preview=of_group["preview"],
            now=of_group["variants"] != "frames",
            patience=patience / len(groups),
            evaluate=evaluate and len(names) > 1,
        ).left_out
        found |= {one.name: one for one in left}
    kept = tuple(name for name in names if name not in found)
    return Found(kept, tuple(found[name] for name in dict.fromkeys(names) if name in found))


def scale_notes(
    layer: bpy.types.ViewLayer, items: Sequence[bpy.types.Object], patience: float
) -> tuple[Message, ...]:
    """What negative and uneven scales mean for a bake: the picture is right; a line for each sort.

    After `patience` seconds no further object is looked at.
    """
    mirrored: list[str] = []
    uneven: list[str] = []
    since = monotonic()
    for item in items:
        if monotonic() - since > patience:
            break
        length, is_mirrored = scale_in_world(layer, item)
        if is_mirrored:
            mirrored.append(item.name)
        if length.max() > _EVEN * length.min() > 0:
            uneven.append(item.name)
    notes = []
    if mirrored:
        several = "have negative scales" if len(mirrored) > 1 else "has a negative scale"
        notes.append(Message(f"{_first(mirrored)} {several}: baked as it looks, nothing needs to be applied"))
    if uneven:
        several = "have uneven scales" if len(uneven) > 1 else "has an uneven scale"
        told = "baked as it looks, and new unwraps allow for that; in your own UV map texels are stretched"
        notes.append(Message(f"{_first(uneven)} {several}, not applied: {told}"))
    return tuple(notes)


def _first(names: Sequence[str]) -> str:
    """The first name, and how many more there are."""
    return f"'{names[0]}' and {len(names) - 1} more" if len(names) > 1 else f"'{names[0]}'"


def foreseen(scene: bpy.types.Scene, request: BakeRequest, patience: float) -> Preflight:
    """What the bakes of a request would meet, as far as `patience` seconds tell. Changes nothing."""
    try:
        plan = plan_bakes(scene, request, guess=True)
        check_left([plan])
        RepeatedExports.of(scene, [plan])
    except InputError as error:
        return Preflight((error.message,))
    return preflight(scene, plan, patience)


def check_left(plans: list[BakePlan]) -> None:
    """Raise InputError if resuming finds all bakes of all plans finished."""
    if not plans or any(not plan.choices or plan.wanted or plan.may_lack_parts for plan in plans):
        return
    several = sum(len(plan.request.objects) for plan in plans) > 1
    raise all_finished("objects" if several else "variants")


def all_finished(what: str) -> InputError:
    """The error where nothing is left to resume."""
    return InputError(f"all {what} are finished", do("bake anew", Setting.OVERWRITE))


def files_there(scene: bpy.types.Scene, request: BakeRequest) -> FilesThere:
    """Which of the requested bakes are on disk; none if they cannot be planned."""
    try:
        bakes = plan_bakes(scene, request, guess=True).wanted
    except InputError:
        return FilesThere()
    there = [request.place(bake) for bake in bakes]
    states = [one.state for one in there]
    done = sum(one.is_finished() for one in there)
    finished, unfinished = states.count(FolderState.FINISHED), states.count(FolderState.UNFINISHED)
    former = sum(one.files.sidecar.is_file() for one in there) - finished
    return FilesThere(len(bakes), finished, unfinished, done, former)
