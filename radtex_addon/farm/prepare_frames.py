# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Write the .blends whose frames machines without RadTex render for a farm's tasks.

Light and ends of a layered bake are plain renders, once the maps are made, which say what is rendered: so
these are made at once.
"""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import bpy

from ..bake.plan import CapturePlan
from ..core.errors import InputError
from ..core.messages import do
from ..cycles.path_ends import emission_values
from ..cycles.sampling import EMITTED
from ..forms.layered.capture.parts import Part
from ..job.variants import Bake
from ..scene.digests import Looks
from ..settings.layered_times import LayeredTimes
from ..settings.rays import LayeredRays
from ..settings.spec import BakeSpec
from .blend import SheetFrames, check_seed, finish_blend, save_draft
from .farm_files import RUNNER
from .farm_manifest import check_frame_count
from .farm_progress import AnyStep, FarmStep, FarmTask
from .freeze_scene import Held, check_holdable
from .part_frames import FRAMES, PartFrames, has_frames
from .run_task import show_parts_of, task_steps
from .self_contained import pack_files
from .task_graph import BEGIN
from .tasks import FarmBake, TaskFarm
from .templates import write_runner


@dataclass(frozen=True, eq=False)
class _Draft:
    """A scene for frames, saved in the file `path`; `looks` and `cached` are as of `save_draft`."""

    path: Path
    scene: str
    frames: PartFrames
    looks: Looks
    cached: Held


def check_rendered_as_frames(scene: bpy.types.Scene, bakes: Sequence[Bake]) -> None:
    """Raises InputError if no part of any of these bakes can be frames, or not of that scene or seed."""
    if not any(has_frames(spec) for _, spec in bakes):
        specs = dict.fromkeys(f"{spec.kind} in layout {spec.layout}" for _, spec in bakes)
        raise InputError(
            "frames for machines without RadTex are parts of bakes in the layered layout, "
            f"not of {' or '.join(specs)}",
            do("prepare without them"),
        )
    check_holdable(scene)
    for _, spec in bakes:
        if has_frames(spec):
            check_seed(spec.seed, len(EMITTED))


def prepare_frames_steps(farm: TaskFarm) -> Generator[AnyStep, None, tuple[PartFrames, ...]]:
    """Do the tasks of maps, and write the .blends of all layered bakes of a farm, whose tasks are listed.

    Returns what their frames are. Yields progress; the session is empty afterwards. Raises InputError for
    what no frames can show, BakeError for what fails.
    """
    folder = farm.folder / FRAMES
    folder.mkdir()
    write_runner(folder / RUNNER)
    found: list[PartFrames] = []
    bakes = [bake for bake in farm.bakes if has_frames(bake.spec)]
    for number, bake in enumerate(bakes):
        yield FarmStep(FarmTask.HOLD, number, len(bakes))
        yield from task_steps(farm, f"{bake.key}.{Part.MAPS}")
        drafts: list[_Draft] = []
        yield from show_parts_of(farm, bake, partial(_save, farm, bake, drafts))
        for draft in drafts:
            _finish(farm, bake.spec, draft)
        found += [draft.frames for draft in drafts]
    yield FarmStep(FarmTask.HOLD, len(bakes), len(bakes))
    return tuple(found)


def _save(
    farm: TaskFarm,
    bake: FarmBake,
    drafts: list[_Draft],
    part: Part,
    scene: bpy.types.Scene,
    plan: CapturePlan,
) -> None:
    """Save a scene that was set up for a part's sheets as a draft."""
    times = LayeredTimes(len(plan.texel), LayeredRays.of(bake.spec.samples)).capture
    frames = PartFrames.of(bake.key, part, plan, times[part], BEGIN)
    check_frame_count(frames.count)
    path = farm.folder / FRAMES / f"{frames.name}.draft.blend"
    drafts.append(_Draft(path, scene.name, frames, *save_draft(scene, path)))


def _finish(farm: TaskFarm, spec: BakeSpec, draft: _Draft) -> None:
    """Make a draft the .blend that is rendered."""
    frames, folder = draft.frames, farm.folder / FRAMES
    sheets = range(frames.sheets)
    lit = [emission_values(turn) for _ in sheets for turn in EMITTED] if frames.part is Part.ENDS else []
    shown = SheetFrames(
        sheet=[sheet for sheet in sheets for _ in range(frames.lights)],
        sheet_rows=frames.sheet_rows,
        seed=spec.seed,
        output=frames.output,
        note=frames.note(farm.job),
        values={label: [values[label] for values in lit] for label in (lit[0] if lit else ())},
    )
    pack = partial(pack_files, folder, shared=farm.folder)
    finish_blend(draft.path, draft.scene, frames.blend(farm.folder), shown, draft.looks, draft.cached, pack)
    draft.path.unlink()
    (folder / frames.name).mkdir()
