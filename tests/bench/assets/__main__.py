# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How faithful are assets of several parts? Bake them with the defaults, and compare with path tracing.

    python -m tests.bench.assets --seeds 1,2,3 --out DIR        assets drawn by these seeds, the worst first
    python -m tests.bench.assets --scene helmet.blend --objects Head,Hose --out DIR
    python -m tests.bench.assets --scene helmet.blend --objects Head,Hose --apart --out DIR    one by one
    python -m tests.bench.assets --scene helmet.blend --baked FOLDER --out DIR    what is baked already

Prints a table of views and parts, and leaves figures.json and a sheet of pictures for each view in DIR. A
scene has cameras view0, view1 and so on. What follows -- goes to the bake.
"""

from __future__ import annotations

import argparse
import json
import resource
import sys
import tempfile
from dataclasses import asdict, dataclass
from pathlib import Path

import bpy
import numpy as np

from radtex_addon.cli.main import main as bake_py

from .drawn import draw_asset
from .judging import Figures, baked_parts, judge, traced_views

ASSET = "asset"
_MEANS = {"psnr": 1, "flip": 3, "energy": 2, "glints": 2}  # digits


@dataclass(frozen=True)
class Result:
    """The figures of a baked asset by view, then by part, and how long its bake took, of the processor."""

    name: str
    seconds: float
    views: dict[str, dict[str, Figures]]

    def mean(self, field: str) -> float:
        """The mean of a field of `Figures` over whole views."""
        return float(np.nanmean([getattr(found["all"], field) for found in self.views.values()]))

    def row(self) -> str:
        """The row of the table that `main` prints."""
        worst = min(found["all"].psnr for found in self.views.values())
        means = [f"{self.mean(field):.{digits}f}" for field, digits in _MEANS.items()]
        return f"| {' | '.join([self.name, *means])} | {worst:.1f} | {self.seconds:.0f} |"

    def to_json(self) -> dict[str, object]:
        """All figures."""
        views = {
            view: {part: asdict(one) for part, one in found.items()} for view, found in self.views.items()
        }
        return {
            "mean": {field: self.mean(field) for field in _MEANS},
            "seconds": self.seconds,
            "views": views,
        }


def main() -> None:
    """Build or open the scenes, bake, judge, print."""
    options, more = _options()
    options.out.mkdir(parents=True, exist_ok=True)
    results: list[Result] = []
    for name in [f"seed {seed}" for seed in options.seeds] or [options.scene.stem]:
        folder = options.out / name.replace(" ", "-")
        folder.mkdir(exist_ok=True)
        results.append(_result(name, folder, options, more))
        record = {result.name: result.to_json() for result in results}
        (options.out / "figures.json").write_text(json.dumps(record, indent=1) + "\n")
    print("\n| asset | mean dB | FLIP | energy | glints kept | worst view, dB | seconds of processor |")
    print("|---|---|---|---|---|---|---|")
    for result in sorted(results, key=lambda one: one.mean("psnr")):
        print(result.row())


def _result(name: str, folder: Path, options: argparse.Namespace, more: list[str]) -> Result:
    scene = folder / "scene.blend" if options.scene is None else options.scene
    objects = options.objects
    if options.scene is None:
        objects = [part.name for part in draw_asset(int(name.split()[1]))]
        bpy.ops.wm.save_as_mainfile(filepath=str(scene))
    else:
        bpy.ops.wm.open_mainfile(filepath=str(scene))
    with tempfile.TemporaryDirectory() as place:
        views = traced_views(Path(place), options.eevee)
    before = _processor_seconds()
    bakes = options.baked or folder / "bake"
    if options.baked is None:
        named = [word for one in objects for word in ("--object", one)]
        together = [] if options.apart or len(objects) == 1 else ["--together", ASSET]
        wanted = ["--out", str(bakes), "--save-preview", "--overwrite", "--progress", "none"]
        if bake_py([str(scene), *named, *together, *wanted, *more], inside_blender=False):
            raise SystemExit(f"{name} was not baked")
    seconds = _processor_seconds() - before
    parts = baked_parts(bakes)
    figures = {view.name: judge(parts, view, folder / f"{view.name}.png") for view in views}
    for view, found in figures.items():
        for part, one in found.items():
            told = f"{one.psnr:6.2f} dB  {one.flip:.3f}  {one.energy:.2f}  {one.glints:.2f}"
            print(f"{name:10} {view} {part:24} {told}", flush=True)
    return Result(name, seconds, figures)


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
