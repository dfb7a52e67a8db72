# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Quality per byte: the shared layout, condensed to ever smaller budgets, against path-traced views.

    python -m tests.bench.fidelity.curve                     every scene; budgets from 1/4 to 1/100
    python -m tests.bench.fidelity.curve --scenes glass --texels 64

A budget is a share of what the plain layout's half floats take at as many texels of 8 x 8 cells. Each scene
is captured and fitted once; its textures are written, read back and looked up.
"""

from __future__ import annotations

import argparse
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from radtex_addon.bake.progress import finished
from radtex_addon.bake.spec import BakeSpec, Layout
from radtex_addon.core.errors import InputError
from radtex_addon.formats.shared_files import read_shared
from radtex_addon.forms.condensed.condense import check_budget, condense_steps
from radtex_addon.forms.outcome import Condensed
from radtex_addon.prepare.facts import facts_of

from .fitted import fit_stage, quality
from .references import views
from .report import Result, markdown, save_sheet
from .scenes import SCENES

_RATIOS = (4, 10, 25, 50, 100)
_SHOWN = (0, 2, 3)  # of all and those, on a sheet: all, 1/10 and 1/25
_PLAIN_TEXEL = 8 * 8 * 8  # bytes of a texel of the plain layout: 8 x 8 cells, four half floats


def main() -> None:
    """Fit, condense, look, print."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.bench.fidelity.curve",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--scenes", default=",".join(SCENES), help="of " + ", ".join(SCENES))
    parser.add_argument("--texels", type=int, default=128)
    default = Path(tempfile.gettempdir(), "radtex-curve")
    parser.add_argument(
        "--out", type=Path, default=default, help=f"folder for sheets of pictures ({default})"
    )
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    summary: dict[str, list[float]] = {}
    for name in options.scenes.split(","):
        results = _scene(name, options.texels)
        summary[name] = [result.mean("psnr", held_out=True) for result in results]
        save_sheet(options.out / f"{name}.png", [results[index] for index in _SHOWN if index < len(results)])
    means = [float(np.mean(column)) for column in zip(*summary.values(), strict=False)]
    rows = [[name, *(f"{value:.2f}" for value in values[: len(means)])] for name, values in summary.items()]
    rows.append(["mean", *(f"{value:.2f}" for value in means)])
    rows.append(["loss", *(f"{means[0] - value:.2f}" for value in means)])
    head = ["scene", "all", *(f"1/{ratio}" for ratio in _RATIOS)][: 1 + len(means)]
    print("\nPSNR of the untuned views, dB\n\n" + markdown([head, ["---"] * len(head), *rows]))


def _scene(name: str, texels: int) -> list[Result]:
    """All that was fitted, then by budget."""
    stage = SCENES[name]()
    looked_from = views(stage)
    stage = SCENES[name]()
    spec = BakeSpec(layout=Layout.SHARED, texels=texels, budget=2**40)
    with tempfile.TemporaryDirectory() as folder:
        fitted, looked, uv_layer = fit_stage(stage, looked_from, spec, Path(folder))
        found = [looked.result("all", fitted.atlas)]
        print(f"\n{name}: {quality(found[0])} with every texel's own buckets", flush=True)
        layout = fitted.plan.layout
        plain = layout.width * layout.height * _PLAIN_TEXEL
        facts = facts_of(stage.subject.name, spec, layout.width, layout.height, uv_layer)
        for ratio in _RATIOS:
            path = Path(folder, f"{ratio}.json")
            within = replace(spec, budget=plain // ratio)
            try:
                check_budget(within, layout.width, layout.height)
            except InputError as refusal:
                print(f"  1/{ratio}: {refusal}", flush=True)
                break
            steps = condense_steps(path, fitted.atlas, fitted.plan, within, facts)
            _, chosen = finished(steps)
            found.append(looked.result(f"1/{ratio}", read_shared(path)[0], chosen.bytes))
            print(_line(chosen, found[-1]), flush=True)
    return found


def _line(chosen: Condensed, result: Result) -> str:
    clusters = " and ".join(str(count) for count in chosen.clusters)
    return (
        f"  {result.method}: {chosen.bytes / 1e6:.3f} MB, {clusters} clusters, "
        f"colour {chosen.colour[0]} pixels and surroundings {chosen.surroundings} cells wide: "
        f"{quality(result)}; {chosen.agreement:.1f} dB from what was fitted"
    )


if __name__ == "__main__":
    main()
