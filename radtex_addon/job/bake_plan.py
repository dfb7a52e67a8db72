# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Plan, check and run the bakes of a request, for the command line, the panel and its workers."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import groupby
from math import inf
from operator import itemgetter
from time import monotonic

import bpy

from ..bake.spec import BakeSpec
from ..bake.thumbnail import Thumbnail
from ..core.errors import InputError
from ..core.messages import Message
from ..prepare.unwrapping import Unwraps
from .bake_request import BakeRequest
from .baking import BakeSteps, bake_steps
from .checks import check_request
from .layout_choice import Choice, choose_layouts
from .output_collisions import check_output_collisions
from .preflight import Preflight, run_preflight
from .split_parts import may_lack_parts
from .variants import Bake, announce_all, bakes_to_resume, skipped_warning, tidy


@dataclass(frozen=True)
class BakePlan:
    """The bakes of a request, with their layouts; `wanted` are those that are to be made.

    Resuming leaves out finished bakes. If `may_lack_parts`, a guessed plan may miss bakes of parts.
    """

    request: BakeRequest
    choices: dict[Bake, Choice]
    wanted: tuple[Bake, ...]
    may_lack_parts: bool = False

    @property
    def skipped(self) -> str:
        """A warning about bakes that resuming leaves out (see `skipped_warning`); empty if there are none."""
        return skipped_warning(tuple(self.choices), self.wanted)

    @property
    def layout_lines(self) -> tuple[str, ...]:
        """A line for each object for which layout buckets was chosen automatically, with the reason."""
        lines = (self.choices[bake].told(bake[0]) for bake in self.wanted)
        return tuple(dict.fromkeys(line for line in lines if line))


def plan_bakes(scene: bpy.types.Scene, request: BakeRequest, *, guess: bool = False) -> BakePlan:
    """Choose the layout of each bake; when resuming several bakes, also which of them are not finished.

    With `guess` no object is evaluated and no file deleted: parts may be missing (`BakeRequest.asked`).
    Raises InputError for what cannot be baked.
    """
    choices = choose_layouts(
        scene,
        request.asked(scene, guess=guess),
        request.open_layout,
        request.folder,
        resume=request.resume,
        overwrite=request.overwrite,
    )
    bakes, unsure = tuple(choices), guess and may_lack_parts(scene, request.objects, request.spec)
    if not (request.resume and not request.overwrite and request.is_of_several(scene)):
        return BakePlan(request, choices, bakes, unsure)
    if not guess:
        tidy(bakes, request.folder)
    try:
        left = bakes_to_resume(bakes, request.folder, request.saves_preview, request.exports)
    except InputError:
        if not unsure:
            raise
        left = ()
    return BakePlan(request, choices, left, unsure)


def check_plan(scene: bpy.types.Scene, plan: BakePlan) -> None:
    """Check all bakes before the first starts. Raises InputError with the first problem."""
    request = plan.request
    for name, spec in plan.wanted:
        check_request(
            scene,
            name,
            spec,
            request.folder,
            request.saves_preview,
            request.overwrite,
            resume=request.resume,
            exports=request.exports,
        )
    check_output_collisions(plan.wanted, request.folder, request.saves_preview)


def preflight(scene: bpy.types.Scene, plan: BakePlan, patience: float = inf) -> Preflight:
    """Find the errors and warnings of all bakes. Changes nothing; stops after about `patience` seconds."""
    request, since = plan.request, monotonic()
    errors: dict[Message, None] = {}
    warnings: dict[Message, None] = {}
    try:
        check_output_collisions(plan.wanted, request.folder, request.saves_preview)
    except InputError as error:
        return Preflight((error.message,))
    for spec, group in groupby(plan.wanted, key=itemgetter(1)):
        found = run_preflight(
            scene,
            (name for name, _ in group),
            spec,
            request.folder,
            preview=request.saves_preview,
            overwrite=request.overwrite,
            resume=request.resume,
            targets=request.exports,
            patience=patience - (monotonic() - since),
        )
        errors |= dict.fromkeys(found.errors)
        warnings |= dict.fromkeys(found.warnings)
        if monotonic() - since > patience:
            break
    return Preflight(tuple(errors), tuple(warnings))


def steps_of_bakes(
    scene: bpy.types.Scene, plan: BakePlan, thumbnail: Callable[[str], Thumbnail | None] = lambda _: None
) -> Iterator[tuple[str, BakeSpec, BakeSteps]]:
    """Yield each bake's name, specification and steps; run the steps before asking for the next bake.

    Bakes of one object share its unwrap. `thumbnail` returns the thumbnail for a bake's name.
    """
    request = plan.request
    announce_all(plan.wanted, request.folder, request.saves_preview, request.exports, request.overwrite)
    unwraps: Unwraps | None = {} if len(plan.wanted) > 1 else None  # it is as large as the mesh
    for name, spec in plan.wanted:
        steps = bake_steps(
            scene,
            name,
            spec,
            request.folder,
            preview=request.preview,
            overwrite=request.overwrite,
            resume=request.resume,
            thumbnail=thumbnail(name),
            unwraps=unwraps,
            exports=request.exports,
        )
        yield name, spec, steps
