# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Plan, check and run the bakes of a request, for the command line, the panel and its workers."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from heapq import merge
from itertools import groupby
from math import inf
from time import monotonic
from typing import NamedTuple

import bpy

from ..bake.thumbnail import Thumbnail
from ..core.errors import InputError
from ..core.messages import Message
from ..prepare.unwrapping import Unwraps
from ..settings.spec import BakeSpec
from ..store.bake_folder import FolderState
from ..store.ownership import Overwrite
from .bake_request import BakeRequest
from .baking import BakeSteps, bake_steps
from .changed_bakes import BakeState, Changes, SceneReader, changes
from .checks import check_request
from .layout_choice import Choice, choose_layouts
from .preflight import Preflight, run_preflight
from .split_parts import may_lack_parts
from .variants import (
    Bake,
    bakes_to_resume,
    check_output_collisions,
    not_whole,
    skipped_warning,
    title_of,
    with_incomplete,
)


class Course(NamedTuple):
    """Whether a bake may replace files, and whether it goes on with what is there."""

    overwrite: Overwrite
    resume: bool


@dataclass(frozen=True)
class BakePlan:
    """The bakes of a request, with their layouts; `wanted` are those that are to be made.

    Resuming leaves out finished bakes. If `may_lack_parts`, a guessed plan may miss bakes of parts. If only
    changed bakes are asked for, `found` is what was found of each.
    """

    request: BakeRequest
    choices: dict[Bake, Choice]
    wanted: tuple[Bake, ...]
    may_lack_parts: bool = False
    found: Mapping[Bake, Changes] = field(default_factory=dict)

    @property
    def skipped(self) -> str:
        """A warning about bakes that resuming leaves out (see `skipped_warning`); empty if there are none."""
        return skipped_warning(tuple(self.choices), self.wanted)

    @property
    def layout_lines(self) -> tuple[str, ...]:
        """A line for each object for which layout buckets was chosen automatically, with the reason."""
        lines = (self.choices[bake].told(bake[0]) for bake in self.wanted)
        return tuple(dict.fromkeys(line for line in lines if line))

    @property
    def change_lines(self) -> tuple[str, ...]:
        """What was found of each bake, and what becomes of it, if only changed bakes are asked for."""
        return tuple(
            f"{title_of(*bake)}: {found}{_becomes(found, bake in self.wanted)}"
            for bake, found in self.found.items()
        )

    @property
    def replaced(self) -> tuple[Bake, ...]:
        """The wanted bakes that are baked, and not only get what is made of them."""
        return tuple(bake for bake in self.wanted if bake not in self.found or self.found[bake].asks_for_bake)

    @property
    def is_done(self) -> bool:
        """Whether all its bakes are finished, by the same settings and with all that is made of them."""
        request = self.request
        return not not_whole(tuple(self.choices), request.folder, request.saves_preview, request.exports)

    def course_of(self, bake: Bake) -> Course:
        """Whether a wanted bake may replace files, and whether it goes on with what is there."""
        if bake not in self.found:
            return Course(self.request.may_replace(self.request.overwrite), self.request.resume)
        again = self.found[bake].asks_for_bake
        return Course(overwrite=self.request.may_replace(again), resume=not again)


def _becomes(found: Changes, wanted: bool) -> str:
    if not wanted:
        return ""
    if not found.asks_for_bake:
        return ", but lacks its preview or an export, which is made"
    return ", baking" if found.state is BakeState.MISSING else ", baking again"


def plan_bakes(scene: bpy.types.Scene, request: BakeRequest, *, guess: bool = False) -> BakePlan:
    """Choose the layout of each bake; when resuming several bakes, also which of them are not finished.

    With `guess` no object is evaluated and no file deleted: parts may be missing (`BakeRequest.asked`).
    Raises InputError for what cannot be baked.
    """
    request = request.where_begun(scene, guess=guess)
    choices = choose_layouts(
        scene,
        request.asked(scene, guess=guess),
        request.open_layout,
        request.folder,
        resume=request.resume,
        overwrite=request.overwrite,
    )
    if request.only_changed:
        return _plan_of_changed(scene, request, choices)
    bakes, unsure = tuple(choices), guess and may_lack_parts(scene, request.objects, request.spec)
    if not (request.resume and not request.overwrite and request.is_of_several(scene)):
        return BakePlan(request, choices, bakes, unsure)
    if not guess:
        _clear_left(request, bakes)
    try:
        left = bakes_to_resume(bakes, request.folder, request.saves_preview, request.exports)
    except InputError:
        if not unsure:
            raise
        left = ()
    return BakePlan(request, choices, left, unsure)


def _plan_of_changed(scene: bpy.types.Scene, request: BakeRequest, choices: dict[Bake, Choice]) -> BakePlan:
    """The bakes that are not there, unfinished or changed, and those that lack a preview or an export."""
    bakes = tuple(choices)
    _clear_left(request, bakes)
    reader = SceneReader(scene)
    found = {
        (name, spec): changes(
            scene, name, spec, request.folder, surroundings=request.surroundings, reader=reader
        )
        for name, spec in bakes
    }
    again = [bake for bake in bakes if found[bake].asks_for_bake]
    wanted = with_incomplete(bakes, again, request.folder, request.saves_preview, request.exports)
    return BakePlan(request, choices, wanted, found=found)


def _clear_left(request: BakeRequest, bakes: Sequence[Bake]) -> None:
    for bake in bakes:
        request.place(bake).clear_left()


def check_plans(scene: bpy.types.Scene, plans: Sequence[BakePlan]) -> None:
    """Check all bakes of plans into one folder before the first starts. Raises InputError."""
    for plan in plans:
        _check_plan(scene, plan)
    check_apart(plans)


def check_apart(plans: Sequence[BakePlan]) -> None:
    """Check that no two bakes of several plans write the same file. Raises InputError."""
    for folder in dict.fromkeys(plan.request.folder for plan in plans):
        there = [plan for plan in plans if plan.request.folder == folder]
        wanted = [bake for plan in there for bake in plan.wanted]
        check_output_collisions(wanted, folder, any(plan.request.saves_preview for plan in there))


def _check_plan(scene: bpy.types.Scene, plan: BakePlan) -> None:
    request = plan.request
    for name, spec in plan.wanted:
        course = plan.course_of((name, spec))
        check_request(
            scene,
            name,
            spec,
            request.folder,
            request.saves_preview,
            course.overwrite,
            resume=course.resume,
            exports=request.exports,
        )


def preflight(scene: bpy.types.Scene, plan: BakePlan, patience: float = inf) -> Preflight:
    """Find the errors and warnings of all bakes. Changes nothing; stops after about `patience` seconds."""
    request, since = plan.request, monotonic()
    errors: dict[Message, None] = {}
    warnings: dict[Message, None] = {}
    try:
        check_output_collisions(plan.wanted, request.folder, request.saves_preview)
    except InputError as error:
        return Preflight((error.message,))
    for (spec, course), group in groupby(plan.wanted, key=lambda bake: (bake[1], plan.course_of(bake))):
        found = run_preflight(
            scene,
            (name for name, _ in group),
            spec,
            request.folder,
            preview=request.saves_preview,
            overwrite=course.overwrite,
            resume=course.resume,
            targets=request.exports,
            patience=patience - (monotonic() - since),
        )
        errors |= dict.fromkeys(found.errors)
        warnings |= dict.fromkeys(found.warnings)
        if monotonic() - since > patience:
            break
    return Preflight(tuple(errors), tuple(warnings))


def in_order(plans: Sequence[BakePlan], names: Sequence[str]) -> list[tuple[BakePlan, Bake]]:
    """The wanted bakes of all plans, each with its plan, in the order of their objects among `names`.

    Each plan's bakes stay in its own order: those of a frame, say, before those of the next one.
    """
    places = {name: number for number, name in enumerate(names)}

    def place(planned: tuple[BakePlan, Bake]) -> int:
        name, spec = planned[1]
        return min(places.get(each, len(places)) for each in spec.objects or (name,))

    return list(merge(*([(plan, bake) for bake in plan.wanted] for plan in plans), key=place))


def steps_of_bakes(
    scene: bpy.types.Scene, plan: BakePlan, thumbnail: Callable[[str], Thumbnail | None] = lambda _: None
) -> Iterator[tuple[str, BakeSpec, BakeSteps]]:
    """Yield each bake's name, specification and steps; run the steps before asking for the next bake.

    Bakes of one object share its unwrap. `thumbnail` returns the thumbnail for a bake's name.
    """
    request = plan.request
    if len(plan.replaced) > 1:
        _announce(plan)
    unwraps: Unwraps | None = {} if len(plan.wanted) > 1 else None  # it is as large as the mesh
    for name, spec in plan.wanted:
        course = plan.course_of((name, spec))
        steps = bake_steps(
            scene,
            name,
            spec,
            request.folder,
            preview=request.preview,
            overwrite=course.overwrite,
            resume=course.resume,
            thumbnail=thumbnail(name),
            unwraps=unwraps,
            exports=request.exports,
        )
        yield name, spec, steps


def _announce(plan: BakePlan) -> None:
    """Mark those bakes that replace existing files as unfinished, before the first one starts.

    Otherwise, if the run is killed between two bakes, resuming it would take the old files of the next one
    for finished. Raises InputError if a process works on one of them, BakeError where the system refuses.
    """
    request = plan.request
    replaces = request.overwrite or request.only_changed
    for name, spec in plan.replaced:
        place = request.place((name, spec))
        if (replaces or spec.incremental) and place.state is FolderState.FINISHED:
            place.announce(request.exports, request.may_replace(replaces).blend.name)
