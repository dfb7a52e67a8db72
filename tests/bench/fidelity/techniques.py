# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What each technique of the shared layout gives: the fit with it, and without it.

    python -m tests.bench.fidelity.techniques                    metal_20, ceramic, mechanical
    python -m tests.bench.fidelity.techniques --scenes glass

A scene is captured once and fitted many times; where paths end, spread, rest and colour are taken from a
finished fit, so that nothing else of it can make up for them. A row says what is lost without the technique:
the fit's PSNR and FLIP over the untuned views, minus those of the row "all". Bytes and paths are the same in
each, but for the colour's.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from time import process_time
from typing import Any, cast
from unittest.mock import patch

import numpy as np

from radtex_addon.bake import ends, fit, gloss
from radtex_addon.bake.fit import fit_shared
from radtex_addon.bake.light_samples import SurroundingsSamples
from radtex_addon.bake.plan import CapturePlan
from radtex_addon.bake.pooling import Neighbours
from radtex_addon.bake.progress import finished
from radtex_addon.bake.rays import FINER
from radtex_addon.bake.spec import BakeSpec, Layout
from radtex_addon.core.arrays import Floats
from radtex_addon.core.shared import Lobe, SharedAtlas
from radtex_addon.cycles.shared_capture import SharedCapture
from radtex_addon.report.gbuffer import GBuffer

from .captured import capture_stage
from .methods.shared import look
from .metrics import compare
from .references import View, gbuffer, views
from .report import markdown
from .scenes import SCENES

_SCENES = "metal_20,ceramic,mechanical"
_BOUNDLESS = 1e9


@dataclass(frozen=True)
class _Technique:
    """What to put in the place of something of the fit's, and what to make of its atlas."""

    name: str
    instead: tuple[tuple[object, str, Any], ...] = ()
    afterwards: Callable[[SharedAtlas], SharedAtlas] = lambda atlas: atlas


def _lobes(change: Callable[[Lobe], Lobe]) -> Callable[[SharedAtlas], SharedAtlas]:
    return lambda atlas: replace(atlas, lobes=tuple(change(lobe) for lobe in atlas.lobes))


def _sharp(lobe: Lobe) -> Lobe:
    return replace(lobe, ends=lobe.ends * np.array([1, 1, 1, 0], dtype=np.float32))


def _coarse(atlas: SharedAtlas) -> SharedAtlas:
    height, width = (size // FINER for size in atlas.colour.shape[:2])
    return replace(atlas, colour=atlas.colour.reshape(height, FINER, width, FINER, 3).mean(axis=(1, 3)))


def _alone(
    _: Neighbours, table: Floats, __: bool = False, solve: Callable[[Floats], Floats] = lambda sums: sums
) -> Floats:
    return solve(table)


def _no_shift(plan: CapturePlan, _: SurroundingsSamples, cells: int) -> Floats:
    return np.zeros((3, len(plan.texel), cells * cells), dtype=np.float32)


_TECHNIQUES = (
    _Technique("all"),
    _Technique("where paths end", afterwards=_lobes(lambda lobe: replace(lobe, ends=0 * lobe.ends))),
    _Technique("a spread of its own for each cell", afterwards=_lobes(_sharp)),
    _Technique("rest", afterwards=_lobes(lambda lobe: replace(lobe, rest=0 * lobe.rest))),
    _Technique("sums over neighbouring texels", ((Neighbours, "pool", _alone),)),
    _Technique("from coarse cells to fine", ((ends, "_STAGES", ()), (gloss, "_STAGES", ((1, True),)))),
    _Technique("doubt in steps no larger than noise", ((ends, "_DOUBT", 0.0),)),
    _Technique("fireflies limited", ((gloss, "_BRIGHTEST", _BOUNDLESS), (gloss, "_WHITE_LIMIT", _BOUNDLESS))),
    _Technique("errors relative to the light", ((gloss, "_EYE", 0.0),)),
    _Technique("a prior for gain and rest", ((gloss, "_PRIOR", 0.1),)),
    _Technique("parallax as a first shift", ((fit, "_parallax", _no_shift),)),
    _Technique("colour four times finer", afterwards=_coarse),
)


def main() -> None:
    """Capture, fit with and without, look, print."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.bench.fidelity.techniques",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--scenes", default=_SCENES, help="of " + ", ".join(SCENES))
    parser.add_argument("--texels", type=int, default=128)
    parser.add_argument("--samples", type=int, default=16)
    options = parser.parse_args()
    names = options.scenes.split(",")
    rows = {name: _scene(name, options.texels, options.samples) for name in names}
    head = ["without", *(f"{name}: dB, FLIP, fit CPU s" for name in names), "mean dB"]
    table = [head, ["---"] * len(head)]
    for number, technique in enumerate(_TECHNIQUES):
        found = [rows[name][number] for name in names]
        mean = float(np.mean([psnr for psnr, _, _ in found]))
        cells = [f"{psnr:+.2f}, {flip:+.3f}, {seconds:+.0f}" for psnr, flip, seconds in found]
        table.append([technique.name, *cells, f"{mean:+.2f}"])
    print("\n" + markdown(table))


def _scene(name: str, texels: int, samples: int) -> list[tuple[float, float, float]]:
    """PSNR, FLIP and seconds of each technique: the first row's own, the others' minus those."""
    stage = SCENES[name]()
    looked_from = [view for view in views(stage) if view.held_out]
    stage = SCENES[name]()
    spec = BakeSpec(layout=Layout.SHARED, texels=texels, samples=samples)
    with tempfile.TemporaryDirectory() as folder:
        captured = capture_stage(stage, spec, Path(folder))
    prepared, matrix = captured.prepared, captured.matrix_world
    seen = [(view, gbuffer(view, prepared.mesh, matrix, prepared.uv_layer)) for view in looked_from]
    found: list[tuple[float, float, float]] = []
    for technique in _TECHNIQUES:
        psnr, flip, seconds = _measured(technique, captured.capture, seen)
        print(
            f"{name}, without {technique.name}: {psnr:.2f} dB, FLIP {flip:.3f}, {seconds:.0f} s", flush=True
        )
        first = found[0] if found else (0.0, 0.0, 0.0)
        found.append((psnr - first[0], flip - first[1], seconds - first[2]))
    return found


def _measured(
    technique: _Technique, capture: SharedCapture, seen: list[tuple[View, GBuffer]]
) -> tuple[float, float, float]:
    started = process_time()
    with ExitStack() as changes:
        for owner, attribute, value in technique.instead:
            changes.enter_context(patch.object(owner, attribute, value))
        fitted = finished(fit_shared(capture.light, capture.ends, capture.surroundings, capture.colour))
    seconds = process_time() - started
    atlas = technique.afterwards(fitted.atlas)
    figures = [
        compare(buffer.resolve(look(atlas, buffer)), view.reference, buffer.inside, buffer.eroded)
        for view, buffer in seen
    ]
    return (
        float(np.mean([f.psnr for f in figures])),
        float(np.mean([cast(float, f.flip) for f in figures])),
        seconds,
    )


if __name__ == "__main__":
    main()
