# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Remember how long this machine's finished bakes took, for estimates: see `settings.bake_history`."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple
from uuid import uuid4

import bpy

if TYPE_CHECKING:
    from ...settings.estimate import Measurement
    from ...worker.job import Job

_FILE = "bake-times.jsonl"
_SESSION = uuid4().hex
_read: dict[Path, tuple[tuple[int, int], tuple[Measurement, ...]]] = {}  # by the file's time and size


def history_file() -> Path:
    """The file of finished bakes: in the extension's own folder, else in Blender's for users' data."""
    package = ".".join(__name__.split(".")[:3])
    try:
        return Path(bpy.utils.extension_path_user(package)) / _FILE
    except ValueError:  # not installed as an extension
        return Path(bpy.utils.user_resource("DATAFILES", path="radtex")) / _FILE


def measured() -> tuple[Measurement, ...]:
    """All finished bakes of this machine, the latest last; read again when the file changes."""
    from ...settings.bake_history import read_history

    path = history_file()
    try:
        stat = path.stat()
    except OSError:
        return ()
    state = stat.st_mtime_ns, stat.st_size
    if path not in _read or _read[path][0] != state:
        _read[path] = state, read_history(path)
    return _read[path][1]


class BakedScene(NamedTuple):
    """What is remembered of a bake's scene: its `key`, and the object's triangles in the viewport then."""

    key: str
    triangles: int


def scene_key(scene_name: str) -> str:
    """What tells the open file and its scene from others, without naming it; of this session if not saved."""
    told = f"{bpy.data.filepath or _SESSION}|{scene_name}"
    return hashlib.sha256(told.encode(errors="surrogateescape")).hexdigest()[:16]


def shown_triangles(scene: bpy.types.Scene, names: Sequence[str]) -> int:
    """How many triangles the objects have, as the viewport shows them; renders may show more."""
    total = 0
    graph = bpy.context.evaluated_depsgraph_get() if scene == bpy.context.scene else None
    for name in names:
        item = scene.objects.get(name)
        if item is None:
            continue
        shown: Any = item.data if graph is None else item.evaluated_get(graph).data
        if isinstance(shown, bpy.types.Mesh):  # a polygon of k corners has k - 2 triangles
            total += len(shown.loops) - 2 * len(shown.polygons)
    return total


def remember_job(scene: BakedScene, job: Job, seconds: float) -> None:
    """Add a bake that a worker has finished in so many `seconds`, unless it went on with an earlier one."""
    from ...formats.json_reader import Facts
    from ...settings.bake_history import remember
    from ...settings.estimate import EXPORT, START, BakeWork, Measurement
    from ...settings.spec import spec_in

    facts, order = job.facts, job.order.facts
    if order["resume"] or not facts.get("covered_texels") or not facts.get("triangles"):
        return
    spec = spec_in(Facts(dict(order["spec"]), "the order"))
    if spec.incremental:
        return
    work = BakeWork.of(
        spec,
        facts["triangles"],
        covered=facts["covered_texels"],
        texels=max(facts["texels"]),
        preview=order["preview"] is not None,
        exports=len(order["exports"]),
        device=facts["device"],
    )
    by_stage = dict(facts["seconds"])
    if order["exports"]:  # they take time that no stage of the bake counts
        by_stage[EXPORT] = 0.0 if job.course is None else job.course.took.get(EXPORT, 0.0)
    by_stage[START] = max(0.0, seconds - sum(by_stage.values()))
    made = Measurement(scene.key, job.object, work, by_stage, shown_triangles=scene.triangles)
    remember(history_file(), made)
