# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How many paths a second does a bake trace here, on the processor or a card? This needs Blender, as bpy.

    python -m tests.bench.gpu.baking [convex rough film lights shared] --device gpu --out DIR

Of each scene of `scenes`: a plain camera that the object fills, the portal with as many paths in layout
buckets, and a whole default bake, from unwrapping to files. Medians of rounds in turn, after one to warm up.
DIR gets baking.json; the table is printed.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from importlib import import_module
from math import atan, sqrt
from pathlib import Path
from statistics import median
from time import perf_counter
from typing import Any, cast

import bpy
from mathutils import Vector

from radtex_addon.bake.plan import Tile, plan_capture
from radtex_addon.bake.progress import finished
from radtex_addon.core.texel_map import rasterise
from radtex_addon.cycles.capture_settings import apply_capture_settings
from radtex_addon.cycles.device import use_device
from radtex_addon.cycles.portal import PortalCapture
from radtex_addon.job import bake_object
from radtex_addon.prepare.prepared import prepare
from radtex_addon.scene.objects import find_object
from radtex_addon.scene.scratch import scratch_scene
from radtex_addon.settings.spec import BakeSpec, Kind, Layout

from .scenes import SCENES, Staged

_BUCKET, _SAMPLES = 8, 16
_ASPECT = 16 / 9
_RUNS = ("plain camera", "portal", "whole default bake")
Run = Callable[[], int]


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("names", nargs="*", metavar="object", help=f"of {', '.join(SCENES)} (default: all)")
    parser.add_argument("--device", default="gpu", help="cpu, gpu, optix, … as of bake.py (default: gpu)")
    parser.add_argument("--texels", type=int, default=128)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--out", type=Path, default=Path("speed"), help="folder for the results")
    options = parser.parse_args()
    objects, used = {}, ""
    for name in options.names or SCENES:
        objects[name], used = _of_scene(name, options.device, options.texels, options.rounds)
    figures = {
        "device": used,
        "card": _card(used),
        "blender": bpy.app.version_string,
        "texels": options.texels,
        "samples": _SAMPLES,
        "rounds": options.rounds,
        "objects": objects,
    }
    options.out.mkdir(parents=True, exist_ok=True)
    (options.out / "baking.json").write_text(json.dumps(figures, indent=1) + "\n", encoding="utf-8")
    print(table(figures))


def _card(used: str) -> str:
    """What Cycles calls the devices of that type."""
    devices: Any = import_module("_cycles").available_devices(used)  # name, type and more of each
    return ", ".join(sorted({name for name, kind, *_ in devices if kind == used}))


def _of_scene(name: str, wish: str, texels: int, rounds: int) -> tuple[dict[str, Any], str]:
    """Paths a second and seconds of each run in a scene; and the type of the device that rendered."""
    staged = SCENES[name]
    staged.build()
    scene = cast("bpy.types.Scene", bpy.context.scene)
    objects = staged.objects if len(staged.objects) > 1 else ()
    spec = BakeSpec(layout=Layout.LAYERED, texels=texels, objects=objects, device=wish)
    atlas = name if objects else staged.objects[0]
    paces: dict[str, list[float]] = {run: [] for run in _RUNS}
    took: dict[str, list[float]] = {run: [] for run in _RUNS}
    with tempfile.TemporaryDirectory() as temporary, ExitStack() as stack:
        folder = Path(temporary)
        portal, paths, used = stack.enter_context(_portal(scene, staged, spec, folder))
        camera = stack.enter_context(_camera(scene, staged, wish, paths, folder))

        def whole() -> int:
            return bake_object(scene, atlas, spec, folder / "bake", overwrite=True).paths

        for number in range(-1, rounds):
            for run, call in zip(_RUNS, (camera, portal, whole), strict=True):
                started = perf_counter()
                traced = call()
                seconds = perf_counter() - started
                if number >= 0:
                    paces[run].append(traced / seconds)
                    took[run].append(seconds)
    return {
        run: {"paths_per_second": round(median(paces[run])), "seconds": round(median(took[run]), 2)}
        for run in _RUNS
    }, used


@contextmanager
def _portal(
    scene: bpy.types.Scene, staged: Staged, spec: BakeSpec, folder: Path
) -> Iterator[tuple[Run, int, str]]:
    """The capture of all the object's buckets, its paths, and the device's type."""
    kept: list[bpy.types.ID] = []
    with scratch_scene(scene, None, kept) as scratch, use_device(scratch, spec.device) as used:
        items = [find_object(scratch, each) for each in staged.objects]
        prepared = finished(prepare(scratch, items, spec, kept, name="Atlas"))
        plan = plan_capture(rasterise(prepared.surface, prepared.width, prepared.height), _BUCKET)
        paths = len(plan.texel) * _BUCKET**2 * _SAMPLES
        capture = PortalCapture(scratch, plan, Kind.RADIANCE, _SAMPLES, 0, folder)

        def run() -> int:
            capture.render(Tile(0, plan.rows))
            return paths

        yield run, paths, used
    bpy.data.batch_remove(kept)


@contextmanager
def _camera(scene: bpy.types.Scene, staged: Staged, wish: str, paths: int, folder: Path) -> Iterator[Run]:
    """A picture of the object, with about so many paths."""
    with scratch_scene(scene) as scratch, use_device(scratch, wish):
        data: Any = bpy.data.cameras.new("Camera")
        data.angle = 2 * atan(staged.half * _ASPECT)
        item: Any = bpy.data.objects.new("Camera", data)
        towards: Any = Vector(staged.place) - Vector(staged.target)
        item.location, item.rotation_mode = staged.place, "QUATERNION"
        item.rotation_quaternion = towards.to_track_quat("Z", "Y")
        scratch.collection.objects.link(item)
        scratch.camera = item
        render = scratch.render
        height = round(sqrt(paths / _SAMPLES / _ASPECT))
        render.resolution_x, render.resolution_y = round(height * _ASPECT), height
        render.resolution_percentage = 100
        apply_capture_settings(scratch, _SAMPLES, 0)
        render.filepath = str(folder / "plain.exr")

        def run() -> int:
            bpy.ops.render.render(write_still=True, scene=scratch.name)
            return render.resolution_x * render.resolution_y * _SAMPLES

        yield run


def table(figures: dict[str, Any]) -> str:
    """The figures as a table in Markdown: a row for each scene."""
    conditions = (
        f"*{figures['card']}, by {figures['device']}, Blender {figures['blender']}. {figures['texels']} "
        f"texels, {figures['samples']} samples; medians of {figures['rounds']}.*"
    )
    rows = [
        conditions,
        "",
        "| M paths a second | plain camera | portal | whole default bake | portal over camera | a bake, s |",
        "|---|---|---|---|---|---|",
    ]
    for name, runs in figures["objects"].items():
        camera, portal, whole = (runs[run]["paths_per_second"] / 1e6 for run in _RUNS)
        rows.append(
            f"| {name} | {camera:.3f} | {portal:.3f} | {whole:.3f} | {portal / camera:.2f} "
            f"| {runs[_RUNS[2]]['seconds']:.0f} |"
        )
    return "\n".join(rows)


if __name__ == "__main__":
    main()
