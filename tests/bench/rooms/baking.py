# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rooms as files, their bakes in a process of their own, and what these cost."""

from __future__ import annotations

import hashlib
import inspect
import json
import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from time import perf_counter
from typing import Any, cast

import bpy

from radtex_addon.report.finished_bake import find_bakes_of_all, read_bake
from radtex_addon.scene.surfaces import shown_mesh
from tests.real.exhibit import ROOT

from ..assets import drawn
from ..assets.judging import Part
from . import building, gallery, living, lottery

SURFACES = ("MESH", "CURVE", "FONT", "META", "SURFACE")
_SEED = "seed"
_COSTS = "costs.json"
_DRAWN: dict[str, Callable[[], None]] = {"living": living.living, "gallery": gallery.gallery}


@dataclass(frozen=True)
class Costs:
    """Seconds of a bake by the clock and of the processor, and its process's peak memory in megabytes."""

    wall: float
    processor: float
    memory: float


@dataclass(frozen=True)
class Written:
    """What bakes consist of: megabytes of all images, how many atlases, and how many draw calls show them."""

    megabytes: float
    atlases: int
    draw_calls: int


def room_file(scene: str, folder: Path) -> Path:
    """The .blend of a room: `scene` itself, or that of living, gallery, or seed N, built into `folder` once.

    A file's name has a digest of the sources that build it, for Blender writes no file twice alike.
    """
    if scene.endswith(".blend"):
        return Path(scene)
    sources = "".join(inspect.getsource(module) for module in (drawn, building, gallery, living, lottery))
    digest = hashlib.sha256(f"{sources}{bpy.app.version_string}".encode()).hexdigest()[:12]
    file = folder / f"{scene.replace(' ', '-')}-{digest}.blend"
    if not file.exists():
        build(scene)
        beside = file.with_suffix(".building.blend")
        bpy.ops.wm.save_as_mainfile(filepath=str(beside))
        beside.rename(file)
    return file


def build(scene: str) -> None:
    """Build a room in a new file: living, gallery, or seed N. Raises KeyError for other names."""
    if scene.startswith(_SEED):
        lottery.draw_room(int(scene.removeprefix(_SEED)))
    else:
        _DRAWN[scene]()
    bpy.context.view_layer.update()


def rendered(kinds: tuple[str, ...] = ("MESH",)) -> list[bpy.types.Object]:
    """The open scene's objects of some kinds that renders show."""
    scene = cast(bpy.types.Scene, bpy.context.scene)
    return [item for item in scene.objects if item.type in kinds and not item.hide_render]


def bake(scene: Path, objects: list[str], folder: Path, more: list[str]) -> Costs:
    """Bake a file by bake.py with its defaults and `more` options, and keep what it costs.

    All of it in one go, or `objects` alone if some are named.

    Raises SystemExit with the end of what it said if it fails.
    """
    folder.mkdir(parents=True, exist_ok=True)
    named = [word for one in objects for word in ("--object", one)]
    what = [*named, "--together", "auto"] if named else ["--all"]
    wanted = [
        "--out",
        str(folder),
        "--save-preview",
        "--overwrite",
        "--progress",
        "none",
    ]
    command = [sys.executable, str(ROOT / "bake.py"), str(scene), *what, *wanted, *more]
    log = folder.with_suffix(".log")
    started = perf_counter()
    with log.open("wb") as said:
        process = subprocess.Popen(command, stdout=said, stderr=subprocess.STDOUT, cwd=ROOT)
        _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise SystemExit(f"{scene.name} was not baked: {log.read_text(encoding='utf-8')[-2000:]}")
    kilobyte = 1024 * 1024 if sys.platform == "darwin" else 1024
    costs = Costs(perf_counter() - started, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / kilobyte)
    (folder / _COSTS).write_text(json.dumps(asdict(costs)), encoding="utf-8")
    return costs


def kept_costs(folder: Path) -> Costs | None:
    """What the bake in a folder cost, if `bake` made it."""
    file = folder / _COSTS
    return Costs(**json.loads(file.read_text(encoding="utf-8"))) if file.exists() else None


def texels_of(folder: Path) -> int:
    """How many texels the atlases of all bakes in a folder have. Raises InputError if it has no bake."""
    bakes = [read_bake(file).sidecar for file in find_bakes_of_all(folder, "judged")]
    return sum(bake.width * bake.height for bake in bakes)


def written(parts: list[Part]) -> Written:
    """What the bakes of some parts consist of.

    A draw call for each part and each of its materials, as exports have it.
    """
    bakes = {part.bake.file.path: part.bake for part in parts}
    size = sum(image.stat().st_size for one in bakes.values() for image in one.images)
    calls = 0
    for part in parts:
        item: Any = bpy.data.objects[part.name]
        graph = bpy.context.evaluated_depsgraph_get()
        with shown_mesh(item.evaluated_get(graph)) as mesh:  # of curves and texts, too
            calls += len({face.material_index for face in mesh.polygons})
    return Written(size / 1e6, len(bakes), calls)
