# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How faithful are assets of several parts? Bake them with the defaults, and compare with path tracing.

    python -m tests.bench.assets --seeds 1,2,3 --out DIR        assets drawn by these seeds, the worst first
    python -m tests.bench.assets --scene helmet.blend --objects Head,Hose --out DIR
    python -m tests.bench.assets --scene helmet.blend --objects Head,Hose --apart --out DIR    one by one
    python -m tests.bench.assets --scene helmet.blend --baked FOLDER --out DIR    what is baked already
    python -m tests.bench.assets … --three --eevee                beside what needs no bake
    python -m tests.bench.assets … --close-ups view0:128:64 --programs    near by, in all that shows bakes

Prints a table of views and parts, and leaves figures.json, a sheet of pictures for each view, and overviews
in DIR. With --baked figures are added to those of the same asset that figures.json has, so that ways may be
run in turn. A scene has cameras view0, view1 and so on. What follows -- goes to the bake.
"""

from __future__ import annotations

import argparse
import json
import resource
import sys
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from radtex_addon.cli.main import main as bake_py

from ..engines.__main__ import programs
from .close_ups import Spot, close_up
from .drawn import draw_asset
from .judging import Figures, Part, baked_parts, judge, save_overview
from .programs import pictures_by_programs
from .three_scene import pictures_by_three, write_page
from .views import Pictures, View, scene_cameras

ASSET = "asset"
VIEW = "view"  # begins the names of the scene's cameras
CLOSE = "close"  # begins the names of close-ups, which count in no mean
BAKED = "all"
_MEANS = {"psnr": 1, "flip": 3, "energy": 2, "glints": 2}  # digits


@dataclass(frozen=True)
class Result:
    """The figures of a baked asset by view, then by part, and how long its bake took, of the processor.

    `others` are the other ways by which the views are shown, each as a part of that name.
    """

    name: str
    seconds: float
    views: dict[str, dict[str, Figures]]
    others: tuple[str, ...] = ()

    def whole(self, way: str = BAKED) -> list[Figures]:
        """Of the scene's views, by the bake or another way."""
        views = self.views.items()
        return [found[way] for view, found in views if not view.startswith(CLOSE) and way in found]

    def mean(self, field: str, way: str = BAKED) -> float:
        """The mean of a field of `Figures` over the scene's views."""
        return float(np.nanmean([getattr(found, field) for found in self.whole(way)]))

    def row(self, way: str = BAKED) -> str:
        """A row of the table that `main` prints."""
        worst = min(found.psnr for found in self.whole(way))
        means = [f"{self.mean(field, way):.{digits}f}" for field, digits in _MEANS.items()]
        name, seconds = (self.name, f"{self.seconds:.0f}") if way == BAKED else (f"{self.name}, {way}", "")
        return f"| {' | '.join([name, *means])} | {worst:.1f} | {seconds} |"

    def to_json(self) -> dict[str, Any]:
        """All figures, None for those that are not there."""
        ways = (BAKED, *self.others)
        return {
            "mean": {way: {field: _kept(self.mean(field, way)) for field in _MEANS} for way in ways},
            "seconds": _kept(self.seconds),
            "views": {view: _told(found) for view, found in self.views.items()},
        }


def _told(found: dict[str, Figures]) -> dict[str, dict[str, float | None]]:
    return {
        name: {field: _kept(value) for field, value in asdict(one).items()} for name, one in found.items()
    }


def _kept(value: float) -> float | None:
    return None if np.isnan(value) else round(value, 4)


def main() -> None:
    """Build or open the scenes, bake, judge, print."""
    options, more = _options()
    options.out.mkdir(parents=True, exist_ok=True)
    results: list[Result] = []
    for name in [f"seed {seed}" for seed in options.seeds] or [options.scene.stem]:
        folder = options.out / name.replace(" ", "-")
        folder.mkdir(exist_ok=True)
        results.append(_result(name, folder, options, more))
        _record(results, options.out / "figures.json", add=options.baked is not None)
    print("\n| asset | mean dB | FLIP | energy | glints kept | worst view, dB | seconds of processor |")
    print("|---|---|---|---|---|---|---|")
    for result in sorted(results, key=lambda one: one.mean("psnr")):
        for way in (BAKED, *result.others):
            print(result.row(way))


def _record(results: list[Result], path: Path, *, add: bool) -> None:
    """Write all figures, or `add` them to those of the same assets that the file has."""
    before = json.loads(path.read_text(encoding="utf-8")) if add and path.exists() else {}
    record = {result.name: result.to_json() for result in results}
    for name, facts in record.items():
        known = before.get(name, {"mean": {}, "views": {}})
        facts["mean"] = known["mean"] | facts["mean"]
        for view, found in facts["views"].items():
            facts["views"][view] = known["views"].get(view, {}) | found
    path.write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")


def _result(name: str, folder: Path, options: argparse.Namespace, more: list[str]) -> Result:
    scene = folder / "scene.blend" if options.scene is None else options.scene
    objects = options.objects
    if options.scene is None:
        objects = [part.name for part in draw_asset(int(name.split()[1]))]
        bpy.ops.wm.save_as_mainfile(filepath=str(scene))
    bakes = options.baked or folder / "bake"
    seconds = 0.0
    if options.baked is None:
        before = _processor_seconds()
        named = [word for one in objects for word in ("--object", one)]
        together = [] if options.apart or len(objects) == 1 else ["--together", ASSET]
        wanted = ["--out", str(bakes), "--save-preview", "--overwrite", "--progress", "none"]
        if bake_py([str(scene), *named, *together, *wanted, *more], inside_blender=False):
            raise SystemExit(f"{name} was not baked")
        seconds = _processor_seconds() - before
    bpy.ops.wm.open_mainfile(filepath=str(scene))
    parts = baked_parts(bakes)
    views = _views(Pictures(scene, folder), parts, options)
    if options.three or options.programs:
        _show(views, parts, bakes, Pictures(scene, folder), options)
    figures = {view.name: judge(parts, view, folder / f"{view.name}.png") for view in views}
    for kind in (VIEW, CLOSE):
        shown = [folder / f"{view.name}.png" for view in views if view.name.startswith(kind)]
        save_overview(shown, folder / f"{kind}s.jpg")
    for view, found in figures.items():
        for part, one in found.items():
            told = f"{one.psnr:6.2f} dB  {one.flip:.3f}  {one.energy:.2f}  {one.glints:.2f}"
            print(f"{name:10} {view} {part:24} {told}", flush=True)
    return Result(name, seconds, figures, tuple(views[0].others))


def _views(pictures: Pictures, parts: list[Part], options: argparse.Namespace) -> list[View]:
    """Of the scene's cameras and of close-ups, as Cycles sees them, and Eevee if it is asked for."""
    cameras = scene_cameras()
    near = [
        close_up(parts, cameras, spot, f"{CLOSE}{number}") for number, spot in enumerate(options.close_ups)
    ]
    views = [View(camera, pictures.traced(camera)) for camera in [*cameras, *near]]
    for view in views if options.eevee else []:
        view.others["Eevee"] = pictures.by_eevee(view.camera, _objects(parts))
    return views


def _objects(parts: list[Part]) -> list[str]:
    """The scene's objects that were baked."""
    return sorted({name for part in parts for name in part.bake.sidecar.surfaces})


def _show(
    views: list[View], parts: list[Part], bakes: Path, pictures: Pictures, options: argparse.Namespace
) -> None:
    """Have real programs show the views: three.js without the bake, and what shows bakes."""
    cameras = [view.camera for view in views]
    with programs(pictures.folder / "shown") as showing:
        if options.three:
            write_page(pictures, _objects(parts), showing.site.folder / "three")
            taken = pictures_by_three(showing.site, "three", cameras)
            for view, picture in zip(views, taken, strict=True):
                view.others["MeshPhysicalMaterial"] = picture
        if options.programs:
            every = pictures_by_programs(bakes, cameras, showing.root, showing.site)
            for view, shown in zip(views, every, strict=True):
                view.others.update(shown)


def _processor_seconds() -> float:
    return sum(sum(resource.getrusage(who)[:2]) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))


def _options() -> tuple[argparse.Namespace, list[str]]:
    mine, more = sys.argv[1:], []
    if "--" in mine:
        mine, more = mine[: mine.index("--")], mine[mine.index("--") + 1 :]
    parser = argparse.ArgumentParser(
        prog="python -m tests.bench.assets",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--seeds", type=lambda text: [int(seed) for seed in text.split(",")], default=[])
    parser.add_argument("--scene", type=Path)
    parser.add_argument("--objects", type=lambda text: text.split(","), default=[])
    parser.add_argument("--apart", action="store_true", help="each object in an atlas of its own")
    parser.add_argument("--eevee", action="store_true", help="also how far Eevee's picture of the scene is")
    parser.add_argument("--three", action="store_true", help="also MeshPhysicalMaterial with a probe")
    parser.add_argument(
        "--programs", action="store_true", help="also the bake in Chromium, in Godot and as preview"
    )
    parser.add_argument(
        "--close-ups",
        metavar="VIEW:COLUMN:ROW,...",
        type=lambda text: [Spot.parse(spot) for spot in text.split(",")],
        default=[],
        help="pixels of views to come so near to that a texel fills a tenth of the picture",
    )
    parser.add_argument("--baked", type=Path, help="the folder of bakes that are there")
    parser.add_argument("--out", type=Path, required=True)
    options = parser.parse_args(mine)
    if bool(options.seeds) == bool(options.scene) or (
        options.scene and not (options.objects or options.baked)
    ):
        parser.error("give --seeds, or --scene with --objects or --baked")
    return options, more


if __name__ == "__main__":
    main()
