# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How faithful are rooms? Bake all that is in them with the defaults, and compare with path tracing.

    python -m tests.bench.rooms --scene living --out DIR          or gallery; or "seed 3"; or a .blend
    python -m tests.bench.rooms --scene living --scene gallery --out DIR -- --samples 8
    python -m tests.bench.rooms --scene living --baked FOLDER --out DIR           what is baked already
    python -m tests.bench.rooms … --objects Floor,Mirror          these alone
    python -m tests.bench.rooms … --eevee --three                 beside two ways without RadTex
    python -m tests.bench.rooms … --keep                          figures for docs/results.md, too

Prints a table of the views, the worst first, of the objects, the worst first, and what the bake cost. Leaves
figures.json, a sheet of pictures for each view (traced, baked, others; differences below) and an overview
below DIR. What no bake shows counts in no figure. What follows -- goes to the bake.

--eevee is Eevee with traced reflections, a sphere probe and a baked volume of probes. --three is a web page
of today: three.js with light maps by Cycles's own bake, of as many texels as the bakes have, and one probe.
"""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import asdict
from pathlib import Path
from time import perf_counter
from typing import Any

import bpy
import numpy as np

from ..assets.judging import Figures, baked_parts, judge, save_overview
from ..assets.three_scene import pictures_by_three
from ..assets.views import PIXELS, Pictures, View, bounds_inside, scene_cameras
from ..engines.__main__ import programs
from ..fidelity.references import distances, tree_of
from ..results import kept_json
from .baking import SURFACES, bake, kept_costs, rendered, room_file, texels_of, written
from .light_maps import SAMPLES as LIGHT_SAMPLES
from .light_maps import write_lit_page

SAMPLES = 512  # of a path-traced pixel, denoised
SUBSAMPLES = 3  # along a pixel's side
_BAKED = "all"


def main() -> None:
    """Build or open the rooms, bake, judge, print."""
    options, more = _options()
    options.out.mkdir(parents=True, exist_ok=True)
    for name in options.scene:
        room = Path(name).stem.replace(" ", "-")
        folder = options.out / room
        folder.mkdir(exist_ok=True)
        record = judged_room(name, folder, options, more)
        (folder / "figures.json").write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
        print_room(room, record)
        if options.keep:
            _keep(room, record)


def _keep(room: str, record: dict[str, Any]) -> None:
    """Write a room's figures, but those of its single objects, to the project's results.

    Views and ways that this run has not measured stay as they are, and so do costs of a bake that was there.
    """
    kept = kept_json.read("rooms") or {}
    earlier = kept.get(room, {"views": {}, "costs": None})
    ways = [_BAKED, *record["others"]]
    views = {
        view: earlier["views"].get(view, {}) | {way: found[way] for way in ways}
        for view, found in record["views"].items()
    }
    kept[room] = {
        **{key: value for key, value in record.items() if key != "others"},
        "views": earlier["views"] | views,
        "costs": record["costs"] or earlier["costs"],
    }
    kept_json.write("rooms", kept)


def judged_room(name: str, folder: Path, options: argparse.Namespace, more: list[str]) -> dict[str, Any]:
    """Bake a room unless it is baked, judge its views, and tell all figures, ready for JSON."""
    kept = options.references or folder
    kept.mkdir(parents=True, exist_ok=True)
    scene = room_file(name, kept)
    bpy.ops.wm.open_mainfile(filepath=str(scene))
    bakes = options.baked or folder / "bake"
    if options.baked is None:
        bake(scene, options.objects, bakes, more)
    pictures = Pictures(scene, kept, options.samples)
    views = _views(pictures, options)
    if options.eevee:
        _add_eevee(views, pictures)
    if options.three:
        _add_three(views, pictures, folder / "shown", texels_of(bakes), options.light_samples)
    parts = baked_parts(bakes)
    facts = written(parts)
    named = {part.name for part in parts}
    others = [item for item in rendered(SURFACES) if item.name not in named]
    beside = tree_of(others) if others else None
    figures: dict[str, dict[str, Figures]] = {}
    for view in views:
        started = perf_counter()
        blocked = None if beside is None else distances(beside, view.rays)
        figures[view.name] = judge(parts, view, folder / f"{view.name}.png", blocked)
        print(f"{view.name} looked up in {perf_counter() - started:.0f} s", file=sys.stderr, flush=True)
    save_overview([folder / f"{view.name}.png" for view in views], folder / "views.jpg")
    costs = kept_costs(bakes)
    return {
        "views": {view: {one: _told(of) for one, of in found.items()} for view, found in figures.items()},
        "others": list(views[0].others),
        "objects": len(parts),
        "written": asdict(facts),
        "costs": None if costs is None else asdict(costs),
    }


def _views(pictures: Pictures, options: argparse.Namespace) -> list[View]:
    """Of the scene's cameras, as Cycles sees them."""
    cameras = scene_cameras(options.pixels)
    if options.views:
        cameras = [camera for camera in cameras if camera.name in options.views]
    return [View(camera, pictures.traced(camera), subsamples=options.subsamples) for camera in cameras]


def _add_eevee(views: list[View], pictures: Pictures) -> None:
    """Eevee's pictures of the open scene, which is that of `pictures`."""
    room = bounds_inside(scene_cameras())
    for view in views:
        view.others["Eevee"] = pictures.by_eevee_inside(view.camera, room)


def _add_three(views: list[View], pictures: Pictures, folder: Path, texels: int, samples: int) -> None:
    """Pictures of the open scene by three.js with light maps, from a page below a folder."""
    name = "three"
    with programs(folder) as showing:
        started = perf_counter()
        maps = write_lit_page(pictures, showing.site.folder / name, texels, samples)
        have = sum(one.width * one.height for one in maps)
        seconds = perf_counter() - started
        print(f"{len(maps)} light maps of {have} texels in {seconds:.0f} s", file=sys.stderr, flush=True)
        taken = pictures_by_three(showing.site, name, [view.camera for view in views])
    for view, picture in zip(views, taken, strict=True):
        view.others["three.js"] = picture


def _told(figures: Figures) -> dict[str, float | None]:
    return {key: None if np.isnan(value) else round(value, 4) for key, value in asdict(figures).items()}


def print_room(room: str, record: dict[str, Any]) -> None:
    """Print tables of a room's views and objects, the worst first, and what its bake cost."""
    ways = [_BAKED, *record["others"]]
    print(f"\n| {room} | way | dB | FLIP | energy |\n|---|---|---|---|---|")
    for view, found in sorted(record["views"].items(), key=lambda one: float(one[1][_BAKED]["psnr"])):
        for way in ways:
            one = found[way]
            print(f"| {view} | {way} | {one['psnr']:.2f} | {one['flip']:.3f} | {one['energy']:.3f} |")
    for way in ways:
        means = [
            float(np.mean([found[way][field] for found in record["views"].values()]))
            for field in ("psnr", "flip", "energy")
        ]
        print(f"| mean | {way} | {means[0]:.2f} | {means[1]:.3f} | {means[2]:.3f} |")
    print(f"\n| object of {room} | worst view, dB | mean dB | views |\n|---|---|---|---|")
    objects: dict[str, list[float]] = {}
    for found in record["views"].values():
        for name, one in found.items():
            if name not in ways:
                objects.setdefault(name, []).append(float(one["psnr"]))
    for name, values in sorted(objects.items(), key=lambda one: min(one[1])):
        print(f"| {name} | {min(values):.1f} | {np.mean(values):.1f} | {len(values)} |")
    wrote, costs = record["written"], record["costs"]
    size = f"{record['objects']} objects, {wrote['atlases']} atlases, {wrote['draw_calls']} draw calls"
    print(f"\n{size}, {wrote['megabytes']:.1f} MB")
    if costs:
        print(
            f"baked in {costs['wall'] / 60:.1f} minutes, {costs['processor'] / 60:.1f} of the processor, "
            f"{costs['memory']:.0f} MB at most"
        )


def _options() -> tuple[argparse.Namespace, list[str]]:
    mine, more = sys.argv[1:], []
    if "--" in mine:
        mine, more = mine[: mine.index("--")], mine[mine.index("--") + 1 :]
    parser = argparse.ArgumentParser(
        prog="python -m tests.bench.rooms",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )

    def names(text: str) -> list[str]:
        return text.split(",")

    parser.add_argument("--scene", action="append", required=True, metavar="living|gallery|FILE|'seed N'")
    parser.add_argument("--objects", type=names, default=[], help="bake these alone")
    parser.add_argument("--views", type=names, default=[], help="judge these alone, such as view0,view3")
    parser.add_argument("--baked", type=Path, help="the folder of bakes that are there, with previews")
    parser.add_argument("--pixels", type=int, default=PIXELS, help="of a picture's side")
    parser.add_argument("--samples", type=int, default=SAMPLES, help="of a path-traced pixel")
    parser.add_argument("--subsamples", type=int, default=SUBSAMPLES, help="looked up along a pixel's side")
    parser.add_argument("--eevee", action="store_true", help="also Eevee with probes")
    parser.add_argument("--three", action="store_true", help="also three.js with light maps and a probe")
    parser.add_argument("--light-samples", type=int, default=LIGHT_SAMPLES, help="of a light map's texel")
    parser.add_argument("--keep", action="store_true", help="the figures in docs/results")
    parser.add_argument("--references", type=Path, help="where scenes and path-traced pictures are kept")
    parser.add_argument("--out", type=Path, required=True)
    options = parser.parse_args(mine)
    if options.baked and len(options.scene) > 1:
        parser.error("--baked wants one --scene")
    if options.keep and options.objects:
        parser.error("--keep wants all that a room has, not --objects")
    return options, more


if __name__ == "__main__":
    main()
