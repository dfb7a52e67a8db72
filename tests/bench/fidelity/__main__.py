# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How faithful are baked objects? Every method, on every scene, against path-traced views.

    python -m tests.bench.fidelity                     all scenes, the two views that nothing is tuned on
    python -m tests.bench.fidelity --quick             three scenes, one view of each
    python -m tests.bench.fidelity --quick --tuning    and a view to tune on
    python -m tests.bench.fidelity --lottery 16 --seed 7    scenes drawn by chance, the worst first
    python -m tests.bench.fidelity --scenes glass,ceramic --methods plain --out DIR
    python -m tests.bench.fidelity --methods layered --texels 256
    python -m tests.bench.fidelity --methods layered --samples 1     a sixteenth of the paths

Prints tables, and leaves them with figures.json and a sheet of pictures per scene in DIR. References are
rendered where the user's cache folder lacks them. A method is a module in methods/ with a `make` of its own.
"""

from __future__ import annotations

import argparse
import json
import resource
import tempfile
from dataclasses import asdict
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from typing import cast

import bpy

from radtex_addon.report.gbuffer import BakedSurface

from . import methods
from .choice import add_scene_options, chosen_scenes, names_of
from .composite import seen_light
from .lottery import is_lottery
from .method import Method
from .metrics import Figures, compare
from .pictures import LOTTERY_SAMPLES, SAMPLES
from .references import View, views
from .report import Result, Seen, distribution_table, save_sheet, scene_table, summary_table
from .scenes import Stage


def main() -> None:
    """Bake, look, compare, print."""
    options = _options()
    options.out.mkdir(parents=True, exist_ok=True)
    chosen = [_method(name, options.texels, options.samples) for name in options.methods]
    record: dict[str, object] = {"blender": bpy.app.version_string}
    summary: dict[str, list[Result]] = {}
    tables: list[str] = []
    for name, build in chosen_scenes(options).items():
        looked_from = views(build(), options.quick, options.tuning)
        results = [_measure(method, build(), looked_from) for method in chosen]
        floor = _noise_floor(results[0])
        summary[name] = results
        tables.append(scene_table(name, results, floor))
        print(f"\n{tables[-1]}", flush=True)
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        print(f"Peak of memory so far: {peak / 1e6:.1f} GB", flush=True)
        save_sheet(options.out / f"{name}.png", results)
        samples = LOTTERY_SAMPLES if is_lottery(name) else SAMPLES
        record[name] = {"reference_samples": samples, **_facts(results, floor)}
        (options.out / "figures.json").write_text(json.dumps(record, indent=2) + "\n")
    tables.append(distribution_table(summary) if options.lottery else summary_table(summary))
    print(f"\n{tables[-1]}")
    (options.out / "figures.md").write_text("\n".join(tables))


def _options() -> argparse.Namespace:
    found = sorted(
        (module.name for module in iter_modules(methods.__path__)), key=lambda m: (m != "plain", m)
    )
    parser = argparse.ArgumentParser(
        prog="python -m tests.bench.fidelity",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_scene_options(parser)
    parser.add_argument("--methods", type=names_of(found), default=found, help="of " + ", ".join(found))
    parser.add_argument("--texels", type=int, default=128, help="along each side of the atlas (128)")
    parser.add_argument("--samples", type=int, default=16, help="as of bake.py --samples (16)")
    default = Path(tempfile.gettempdir(), "radtex-fidelity")
    parser.add_argument("--out", type=Path, default=default, help=f"folder for what it makes ({default})")
    return parser.parse_args()


def _method(name: str, texels: int, samples: int) -> Method:
    return cast(Method, import_module(f"{methods.__name__}.{name}").make(texels, samples))


def _measure(method: Method, stage: Stage, looked_from: list[View]) -> Result:
    with tempfile.TemporaryDirectory() as folder:
        baked = method.bake(stage, Path(folder))
        seen = []
        for view in looked_from:
            surface = BakedSurface(baked.mesh, baked.matrix_world, baked.uv_layer)
            buffer = surface.gbuffer(view.rays, view.blocked)
            light = seen_light(baked, surface, view.rays, view.blocked, buffer, view.behind)
            picture = buffer.resolve(light)
            figures = compare(picture, view.reference, buffer.inside, buffer.eroded)
            seen.append(Seen(view, picture, buffer.inside, buffer.eroded, figures))
    return Result(method.name, baked.paths, baked.seconds, baked.bytes, tuple(seen))


def _noise_floor(result: Result) -> Figures:
    """The reference against itself, of another seed."""
    seen, repetition = next(
        (seen, seen.view.repetition) for seen in result.seen if seen.view.repetition is not None
    )
    return compare(repetition, seen.view.reference, seen.inside, seen.eroded)


def _facts(results: list[Result], floor: Figures) -> dict[str, object]:
    methods_facts = {
        result.method: {
            "paths": result.paths,
            "seconds": result.seconds,
            "bytes": result.bytes,
            "views": {
                seen.view.name: {"held_out": seen.view.held_out, **asdict(seen.figures)}
                for seen in result.seen
            },
        }
        for result in results
    }
    return {"noise_floor": asdict(floor), "methods": methods_facts}


if __name__ == "__main__":
    main()
