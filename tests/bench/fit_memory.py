# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How much memory the fit of a layered bake takes: `python -m tests.bench.fit_memory --texels 512 --files`.

Of samples that are made up, so that nothing is rendered: a wavy square that covers 60 % of the atlas, glossy
and matt, some of whose mirror rays meet itself. With `--files` its large arrays lie in files of the folder
for temporary files, else in memory. Told are the peaks of memory that lies in no file, step by step (Linux).
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from threading import Thread
from time import sleep
from typing import Any

import numpy as np

from radtex_addon.bake.light_samples import (
    Axis,
    EndSamples,
    LightSamples,
    LobeSamples,
    mirrored,
    spread_shifts,
)
from radtex_addon.bake.plan import CapturePlan
from radtex_addon.core import large_arrays
from radtex_addon.core.arrays import Floats, blocks
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.blas import one_blas_thread
from radtex_addon.cycles.portal import Aim
from radtex_addon.forms.layered.fit.fitting import fit_layered
from radtex_addon.forms.layered.samples import LayeredSamples, OwnRays
from radtex_addon.settings.rays import LayeredRays, finer, own_side
from tests.layered.made_up import made_up_atlas

_COVERED = 0.6
_random = np.random.default_rng(5)


def in_memory() -> int:
    """MiB of this process that lie in no file."""
    (line,) = (each for each in Path("/proc/self/status").read_text().splitlines() if "RssAnon" in each)
    return int(line.split()[1]) >> 10


def made(shape: tuple[int, ...], rows: Callable[[slice], Any], kind: Any = np.float16) -> Any:
    """An array whose blocks of rows are broadcast from what `rows` makes."""
    found = large_arrays.empty(shape, kind)
    for some in blocks(shape[0], max(1, (1 << 22) // int(np.prod(shape[1:])))):
        found[some] = rows(some)
    return found


def plan_of(texels: int, cells: int) -> CapturePlan:
    """The wavy square's."""
    height = int(texels * _COVERED)
    x, y = np.meshgrid(*((np.arange(count) + 0.5) / texels for count in (texels, height)))
    place = np.stack([x, y, 0.05 * np.sin(20 * x) * np.sin(20 * y)], axis=-1).astype(np.float32)

    def axis(number: int) -> Floats:
        found: Floats = made(place.shape, lambda _: np.eye(3)[number], np.float32)
        return found

    layout, up = AtlasLayout(texels, texels, cells), axis(2)
    places = large_arrays.stowed(place)
    return CapturePlan(layout, np.arange(height * texels), places, axis(0), axis(1), up, up)


def samples_of(texels: int, samples: int, met: float) -> LayeredSamples:
    """Samples of so many texels, of whose mirror rays a share has `met` the object."""
    rays = LayeredRays.of(samples)
    plan = plan_of(texels, rays.light)
    count, light, ends = len(plan.texel), rays.light**2, rays.ends**2
    dark = np.float16(0)
    shade = 1 + np.sin(12 * plan.points[:, :2]).sum(axis=1)[:, None, None] / 3

    def lit(some: slice) -> Floats:
        noise: Floats = shade[some] * _random.random((len(shade[some]), light, 3), dtype=np.float32)
        return noise

    to_ends = Aim(spread_shifts(count, 2)).squares(rays.ends)

    def ended(some: slice) -> Floats:
        axis = mirrored(plan, to_ends[some], some)
        axis = axis + 0.15 * _random.normal(size=axis.shape)
        found: Floats = axis / np.linalg.norm(axis, axis=-1, keepdims=True)
        return found

    side = own_side(count)
    hit = made((count, side**2), lambda some: _random.random((len(plan.texel[some]), side**2)) < met, bool)
    places = made((int(hit.sum()),), lambda _: _random.integers(0, count), np.int32)
    own = LobeSamples(
        plan, Axis.MIRROR, Aim(spread_shifts(count, 5)).squares(side),
        np.broadcast_to(dark, (*hit.shape, 3)), np.broadcast_to(np.True_, hit.shape),
    )  # fmt: skip
    maps = []
    for width in (round(texels * finer(texels)), texels):
        colour = ("diffuse", "glossy")
        parts = {name: made((width, width, 3), lambda _: (0.5, 0.4, 0.3), np.float32) for name in colour}
        parts["normal"] = made((width, width, 3), lambda _: (0, 0, 1), np.float32)
        maps.append(parts | {"material": large_arrays.zeros((width, width, 1))})
    return LayeredSamples(
        LightSamples(
            plan, Aim(spread_shifts(count, 0)).squares(rays.light),
            made((count, light, 3), lit), made((count, light, 3), lit),
            np.broadcast_to(dark, (count, light, 3)),
            np.full((count, 3), 0.5, np.float32), made((count, light), lambda _: True, bool),
        ),
        EndSamples(
            plan, to_ends, made((count, ends, 3), lambda _: 0.5), made((count, ends, 3), ended),
            np.broadcast_to(dark, (count, ends, 3)), np.broadcast_to(dark, (count, ends, 3)),
        ),
        OwnRays(own, hit, places, large_arrays.taken(plan.points, places)),
        made_up_atlas(16, 64).around, maps[0], maps[1], np.zeros(count, np.int32),
    )  # fmt: skip


def main() -> None:
    """Make samples up, fit, print."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.bench.fit_memory",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--texels", type=int, default=256)
    parser.add_argument("--samples", type=int, default=16)
    parser.add_argument("--met", type=float, default=0.002, help="share of mirror rays that meet the object")
    parser.add_argument("--files", action="store_true")
    options = parser.parse_args()
    peak = before = in_memory()

    def watch() -> None:
        nonlocal peak
        while True:
            peak = max(peak, in_memory())
            sleep(0.01)

    Thread(target=watch, daemon=True).start()
    with tempfile.TemporaryDirectory() as folder, one_blas_thread(), ExitStack() as files:
        if options.files:
            files.enter_context(large_arrays.arrays_in_files(Path(folder)))
        steps = fit_layered(samples_of(options.texels, options.samples, options.met))
        for step in (*map(str, range(6)), "atlas"):
            next(steps, None)
            print(f"step {step:6} {peak - before:6} MiB at most so far", flush=True)


if __name__ == "__main__":
    main()
