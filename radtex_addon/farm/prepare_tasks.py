# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Write a folder of tasks, of which any machine with RadTex can do any: bakes of a scene, of any layout."""

from __future__ import annotations

import logging
import secrets
from collections.abc import Generator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import bpy

from ..core.errors import BakeError, InputError
from ..core.messages import Setting, do, leave_out
from ..core.sampler import Filter
from ..formats.sidecar import safe_name
from ..forms.layered.capture.enclosed import is_clear
from ..job.changed_bakes import SceneReader
from ..job.variants import Bake
from ..scene.objects import find_object
from ..scene.scratch import at_frame, find_view_layer
from ..settings.spec import BakeSpec
from ..store.output_files import OutputFiles
from ..store.ownership import open_blend
from ..version import VERSION
from .animation import hold_sequences
from .blend import check_images_saved, without_extras
from .farm_files import SUFFIX, tasks_file
from .farm_progress import AnyStep, FarmStep, FarmTask
from .freeze_scene import check_caches_travel
from .prepare_farm import replacing_folder
from .prepare_frames import check_rendered_as_frames, prepare_frames_steps
from .self_contained import make_local, pack_files
from .task_graph import Subject, keyed, tasks_of
from .tasks import FarmBake, TaskFarm
from .templates import write_task_templates

log = logging.getLogger(__name__)

_SCENE_BYTES = 1100 << 20  # of a process with Blender, a scene of some dozen objects and its renders
_OF_FILE = 4  # times the size of the .blend and its images, which a scene takes in memory


@dataclass(frozen=True)
class PreparedTasks:
    """A farm of tasks, and the `size` in bytes of what travels."""

    farm: TaskFarm
    size: int


def check_farmed(bakes: Sequence[Bake]) -> None:
    """Raises InputError for bakes that add to one that is there, which is not in a farm's folder."""
    if any(spec.incremental for _, spec in bakes):
        raise InputError(
            "a farm bakes anew", leave_out(Setting.ACCUMULATE, Setting.REFRESH), do("bake without a farm")
        )


def tasks_folder(bakes: Sequence[Bake], out: Path, blend: Path | None = None) -> Path:
    """The farm's folder: `<name>.<kind>.radtex-farm` of one bake, else named like the .blend.

    That is the file `blend`, by default the open one.
    """
    if len(bakes) == 1:
        ((name, spec),) = bakes
        return OutputFiles.of(name, spec, out).sidecar.with_suffix(SUFFIX)
    return out / f"{safe_name((open_blend() if blend is None else blend).stem or 'scene')}{SUFFIX}"


def prepare_tasks_steps(
    scene: bpy.types.Scene,
    bakes: Sequence[Bake],
    out: Path,
    *,
    preview: Filter | None = None,
    overwrite: bool = False,
    blend: Path | None = None,
    frames: bool = False,
) -> Generator[AnyStep, None, PreparedTasks]:
    """Write a farm's folder into `out`, of bakes that were checked (`job.bake_plan.check_plans`).

    `blend` is the file that the scene is of, by default the open one. With `frames` the maps of layered bakes
    are made at once, and .blends whose frames any Blender renders for their light and ends. Yields progress.
    No file of the user's changes, but **the session is empty afterwards**. On failure nothing is left in the
    folder. Raises InputError for what cannot travel, BakeError for what fails.
    """
    check_farmed(bakes)
    check_images_saved()
    check_caches_travel(scene)
    if frames:
        check_rendered_as_frames(scene, bakes)
    own = open_blend() if blend is None else blend
    folder = tasks_folder(bakes, out, own)
    subjects = [_subject(scene, name, spec) for name, spec in bakes]
    reader, layer = SceneReader(scene), find_view_layer(scene, None)
    named = [
        replace(bake, fingerprint=reader.at(bake.spec.frame).of_bake(bake.name, bake.spec, layer))
        for bake in keyed(subjects)
    ]
    name = scene.name  # it is opened anew meanwhile
    with replacing_folder(folder, overwrite) as place:
        yield FarmStep(FarmTask.HOLD, 0, 2)
        draft = place / "draft.blend"
        _save(draft)
        bpy.ops.wm.open_mainfile(filepath=str(draft), load_ui=False, use_scripts=False)
        try:
            yield FarmStep(FarmTask.HOLD, 1, 2)
            carried = _make_independent(bpy.data.scenes[name], named, place)
        finally:
            bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        draft.unlink()
        farm = TaskFarm(
            folder=place,
            job=secrets.token_hex(16),
            scene=name,
            blend=own.name,
            radtex=VERSION,
            blender=bpy.app.version_string,
            preview=preview,
            bakes=tuple(named),
            tasks=(),
            carried=carried,
        )
        travels = sum(path.stat().st_size for path in place.rglob("*") if path.is_file())
        memory = _SCENE_BYTES + _OF_FILE * travels
        farm = replace(farm, tasks=tuple(tasks_of(named, subjects, memory, frames)))
        _write_list(farm)
        if frames:
            farm = replace(farm, frames=(yield from prepare_frames_steps(farm)))
            _write_list(farm)
        write_task_templates(farm)
        size = sum(path.stat().st_size for path in place.rglob("*") if path.is_file())
    return PreparedTasks(replace(farm, folder=folder), size)


def _write_list(farm: TaskFarm) -> None:
    tasks_file(farm.folder).write_text(farm.to_json(), encoding="utf-8", newline="\n")


def _subject(scene: bpy.types.Scene, name: str, spec: BakeSpec) -> Subject:
    items = [find_object(scene, each) for each in spec.objects or (name,)]
    shown = items if spec.source is None else [find_object(scene, spec.source)]
    triangles = sum(_triangles(item) for item in items)
    with at_frame(scene, spec.frame):
        return Subject(name, spec, any(map(is_clear, shown)), triangles)


def _triangles(item: Any) -> int:
    """About how many triangles an object has: those of its own mesh."""
    polygons = getattr(item.data, "polygons", ())
    return 2 * len(polygons)


def _save(path: Path) -> None:
    try:
        bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True, relative_remap=True, compress=False)
    except RuntimeError as error:
        raise BakeError(f"{path}: Blender cannot write it ({error}); choose another folder") from error


def _make_independent(scene: bpy.types.Scene, bakes: Sequence[FarmBake], folder: Path) -> Any:
    """Save the open file as the farm's scene, which needs no others; returns what it carries."""
    file = folder / "scene.blend"
    try:
        without_extras(scene)
        libraries = make_local()
        _hold_pictures(scene, bakes)
        packed = pack_files(folder)
        bpy.ops.wm.save_as_mainfile(filepath=str(file), compress=True, relative_remap=False)
    except RuntimeError as error:
        raise BakeError(f"{file}: Blender cannot make it ({' '.join(str(error).split())})") from error
    return libraries + packed.carried


def _hold_pictures(scene: bpy.types.Scene, bakes: Sequence[FarmBake]) -> None:
    """Show image sequences' pictures at the frame that is baked. Raises InputError for several frames."""
    frames = {scene.frame_current if bake.spec.frame is None else bake.spec.frame for bake in bakes}
    hold_sequences(frames)
