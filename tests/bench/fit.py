# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How long the fit of a layered bake takes, step by step: `python -m tests.bench.fit`.

    python -m tests.bench.fit --scenes mechanical,coat --texels 64 --times 3

A scene of `tests.bench.fidelity` is captured once, and fitted several times, of which the fastest counts;
`ball`, which is taken if none is named, is a plain ball over a plane. Seconds of processors tell more than
the clock's where others work on the machine. Memory is the peak beyond the capture's.
"""

from __future__ import annotations

import argparse
import resource
import tempfile
from pathlib import Path
from time import perf_counter, process_time

import bpy
import numpy as np

from radtex_addon.core.blas import one_blas_thread
from radtex_addon.forms.layered.fit.fitting import fit_layered
from radtex_addon.forms.layered.samples import LayeredSamples
from radtex_addon.settings.spec import BakeSpec, Layout

from .fidelity.choice import names_of
from .fidelity.layered.staged import capture_staged
from .fidelity.scenes import SCENES, Stage
from .fidelity.scenes.materials import assign, principled
from .fidelity.scenes.meshes import as_subject, made
from .fidelity.scenes.stage import checkered_floor, floor_height, start, with_cameras

_STEPS = (
    "diffuse light",
    "what is free",
    "lobes",
    "own light and the rest",
    "what comes through",
    "the atlas",
)


def ball() -> Stage:
    """A ball of plain plastic over a checkered floor."""
    start("courtyard.exr", strength=0.9, turn=40)
    bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32)
    item = as_subject(made())
    bpy.ops.object.shade_smooth()
    assign(item, principled("Plastic", (0.8, 0.3, 0.1), Roughness=0.2))
    checkered_floor(floor_height(item))
    return with_cameras("ball", item)


def seconds(capture: LayeredSamples) -> list[tuple[float, float]]:
    """Seconds of processors, and of the clock, that each of the `_STEPS` of a fit takes."""
    found = []
    with one_blas_thread():
        steps = fit_layered(capture)
        next(steps)
        before = process_time(), perf_counter()
        for _ in _STEPS:
            next(steps, None)
            now = process_time(), perf_counter()
            found.append((now[0] - before[0], now[1] - before[1]))
            before = now
    return found


def main() -> None:
    """Capture, fit, print."""
    known = {"ball": ball, **SCENES}
    parser = argparse.ArgumentParser(
        prog="python -m tests.bench.fit",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--scenes", type=names_of(list(known)), default=["ball"])
    parser.add_argument("--texels", type=int, default=128)
    parser.add_argument("--samples", type=int, default=16)
    parser.add_argument("--times", type=int, default=2, help="fits of each scene")
    options = parser.parse_args()
    spec = BakeSpec(layout=Layout.LAYERED, texels=options.texels, samples=options.samples)
    for name in options.scenes:
        with tempfile.TemporaryDirectory() as folder:
            capture = capture_staged(known[name](), spec, Path(folder)).captured.capture
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        least = np.min([seconds(capture) for _ in range(options.times)], axis=0)
        more = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - peak
        for step, (processors, clock) in zip((*_STEPS, "all"), (*least, least.sum(axis=0)), strict=True):
            print(f"{name:12} {step:24} {processors:6.2f} s of processors {clock:6.2f} s", flush=True)
        print(f"{name:12} {more / 1024:.0f} MiB beyond the capture's peak", flush=True)


if __name__ == "__main__":
    main()
