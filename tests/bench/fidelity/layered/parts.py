# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What each part of the layered layout is worth: the fit with it, and without it.

    python -m tests.bench.fidelity.layered.parts --scenes coat,metal_20

A scene is captured once and fitted many times. A row says what is lost without a part: the PSNR of the
untuned views, minus that of the row "all"; and what block compression costs. References are rendered where
the user's cache folder lacks them.
"""

from __future__ import annotations

import argparse
import tempfile
from dataclasses import fields
from pathlib import Path

import numpy as np

from radtex_addon.bake.progress import finished
from radtex_addon.forms.layered.fit.buckets import Parts
from radtex_addon.forms.layered.fit.fitting import fit_layered
from radtex_addon.forms.layered.lookup.atlas import LayeredAtlas
from radtex_addon.report.gbuffer import BakedSurface
from radtex_addon.settings.spec import BakeSpec, Layout

from ..choice import add_scene_options, chosen_scenes
from ..composite import seen_light
from ..methods.layered import baked_of
from ..metrics import compare
from ..references import View, views
from ..report import markdown
from .compressed import MATERIAL_MAPS, compressed
from .staged import Staged, capture_staged

_ALL, _COMPRESSED = "all", "all, compressed in blocks"


def main() -> None:
    """Capture, fit with and without, look, print."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.bench.fidelity.layered.parts",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_scene_options(parser)
    parser.add_argument("--texels", type=int, default=128)
    parser.add_argument("--samples", type=int, default=16)
    options = parser.parse_args()
    spec = BakeSpec(layout=Layout.LAYERED, texels=options.texels, samples=options.samples)
    rows: dict[str, list[float]] = {}
    names = []
    for name, build in chosen_scenes(options).items():
        names.append(name)
        looked_from = views(build(), options.quick)
        with tempfile.TemporaryDirectory() as folder:
            staged = capture_staged(build(), spec, Path(folder))
        for row, psnr in _measured(staged, looked_from).items():
            rows.setdefault(row, []).append(psnr)
            print(f"{name}, {row}: {psnr:.2f} dB", flush=True)
    table = [["", *names, "mean, dB"], ["---"] * (len(names) + 2)]
    for row, found in rows.items():
        first = np.zeros(len(found)) if row == _ALL else np.array(rows[_ALL])
        shown = np.array(found) - first
        sign = "" if row == _ALL else "+"
        table.append([row, *(f"{value:{sign}.2f}" for value in shown), f"{shown.mean():{sign}.2f}"])
    print("\n" + markdown(table))


def _measured(staged: Staged, looked_from: list[View]) -> dict[str, float]:
    """The mean PSNR of the untuned views, by what is left out."""
    prepared, matrix = staged.prepared, staged.matrix_world
    surface = BakedSurface(prepared.mesh, matrix, prepared.uv_layer)
    held_out = [view for view in looked_from if view.held_out]
    seen = [(view, surface.gbuffer(view.rays, view.blocked)) for view in held_out]

    def psnr(atlas: LayeredAtlas) -> float:
        baked, figures = baked_of(atlas, staged), []
        for view, buffer in seen:
            light = seen_light(baked, surface, view.rays, view.blocked, buffer, view.behind)
            picture = buffer.resolve(light)
            figures.append(compare(picture, view.reference, buffer.inside, buffer.eroded).psnr)
        return float(np.mean(figures))

    whole = finished(fit_layered(staged.captured.capture))
    found = {_ALL: psnr(whole)}
    decoded, textures = compressed(whole)
    size = sum(texture.bytes for name, texture in textures.items() if name not in MATERIAL_MAPS)
    print(f"compressed: {size} bytes of textures", flush=True)
    found[_COMPRESSED] = psnr(decoded)
    for part in fields(Parts):
        without = finished(fit_layered(staged.captured.capture, Parts(**{part.name: False})))
        found[f"without {part.name.replace('_', ' ')}"] = psnr(without)
    return found


if __name__ == "__main__":
    main()
