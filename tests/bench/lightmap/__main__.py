# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How good is the diffuse light alone? Compare it with Cycles's converged bake, and with its light map.

    python -m tests.bench.lightmap --rooms sunlit,lamplit --object Floor --object Walls --out DIR
    python -m tests.bench.lightmap --scene room.blend --object Wall --out DIR

The irradiance of an object as the layered layout has it, without and with more paths and the denoiser where
it is noisy; beside it Cycles's own bake on the same UV map and texels with as many paths as the latter took,
as it is and denoised. All of them against Cycles's bake with many paths, in decibels: first of display
values, where the brightest hundredth of texels is white, then relative to the light around each texel. For
the latter the reference is two bakes with noise of their own, which the product of both differences leaves
out. Texels that Cycles's bake leaves out do not count. DIR gets a picture of each object: without, with,
Cycles's denoised light map, and the reference.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path
from typing import cast

import bpy
import numpy as np
from PIL import Image

from radtex_addon.bake.plan import CapturePlan
from radtex_addon.bake.pooling import Neighbours
from radtex_addon.bake.progress import finished
from radtex_addon.core.arrays import Floats
from radtex_addon.core.colour_spaces import LUMINANCE
from radtex_addon.core.gutter import nearest_covered
from radtex_addon.cycles.denoiser import image_denoiser
from radtex_addon.forms.layered.capture.light_map import denoise_texels
from radtex_addon.prepare.prepared import prepare
from radtex_addon.scene.objects import find_object
from radtex_addon.scene.scratch import scratch_scene
from radtex_addon.settings.spec import BakeSpec, Layout

from .cycles_bake import cycles_bake
from .ours import bake_ours
from .rooms import ROOMS

_WHITE = 0.99  # quantile of the reference that is shown white
_DIM = 0.05  # of the mean light: differences in the dark count relative to this
_ENLARGED = 4  # times, of the pictures


def main() -> None:
    """Build or open the scenes, bake, compare, print."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.bench.lightmap",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--scene", type=Path, help="a .blend")
    parser.add_argument("--rooms", default="", help=f"instead of a scene: {','.join(ROOMS)}")
    parser.add_argument("--object", action="append", required=True, dest="objects")
    parser.add_argument("--texels", type=int, default=64, help="along each side of the atlas (64)")
    parser.add_argument("--samples", type=int, default=16, help="as of bake.py --samples (16)")
    parser.add_argument("--reference", type=int, default=4096, help="paths a texel of the reference (4096)")
    parser.add_argument("--out", type=Path, required=True, help="folder for pictures")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    spec = BakeSpec(layout=Layout.LAYERED, texels=options.texels, samples=options.samples)
    print(
        "| scene | object | texels | paths a texel | seconds | before | with | Cycles | denoised |",
        flush=True,
    )
    print("|---|---|---|---|---|---|---|---|---|")
    for name in options.rooms.split(",") if options.rooms else [options.scene.stem]:
        for wanted in options.objects:
            if options.rooms:
                ROOMS[name]()
            else:
                bpy.ops.wm.open_mainfile(filepath=str(options.scene))
            row = _row(wanted, spec, options.reference, options.out / f"{name}-{wanted}.png")
            print(f"| {name} | {wanted} | {row} |", flush=True)


def _row(name: str, spec: BakeSpec, reference: int, picture: Path) -> str:
    kept: list[bpy.types.ID] = []
    scene = cast(bpy.types.Scene, bpy.context.scene)
    with tempfile.TemporaryDirectory() as temporary, scratch_scene(scene, None, kept) as scratch:
        folder = Path(temporary)
        prepared = finished(prepare(scratch, [find_object(scratch, name)], spec, kept))
        ours = bake_ours(scratch, prepared, spec, folder)
        with cycles_bake(bpy.data.objects[name], prepared) as bake:
            first, there = bake.light(reference // 2, 1)
            second, _ = bake.light(reference // 2, 2)
            theirs, _ = bake.light(round(ours.paths[1]), 3)
        plan = ours.plan
        found = [ours.before, ours.after]
        inside = there.ravel()[plan.texel]
        rows, columns = nearest_covered(plan.placed(inside))
        number = plan.placed(np.arange(len(plan.texel)))[rows, columns]
        with image_denoiser(folder) as denoiser:
            if denoiser is None:
                raise SystemExit("this Blender has no OpenImageDenoise")
            light = theirs.reshape(-1, 3)[plan.texel]
            found += [light, denoise_texels(light, plan, number, denoiser)]
    truth = np.stack([one.reshape(-1, 3)[plan.texel] for one in (first, second)])
    white = float(np.quantile((truth.mean(axis=0) @ LUMINANCE)[inside], _WHITE))
    shown = [one.reshape(-1, 3) for one in (found[0], found[1], found[3], truth.mean(axis=0))]
    tiles = [plan.placed(_display(np.where(inside[:, None], one, 0), white)) for one in shown]
    sheet = np.concatenate(tiles, axis=1)[::-1].repeat(_ENLARGED, 0).repeat(_ENLARGED, 1)
    Image.fromarray((sheet * 255 + 0.5).astype(np.uint8)).save(picture)
    level = _level(plan, truth.mean(axis=0))
    values = [
        f"{_psnr(one[inside], truth[:, inside].mean(axis=0), white):.1f} / "
        f"{_relative(one[inside], truth[:, inside], level[inside]):.1f}"
        for one in found
    ]
    paths = " -> ".join(f"{number:.0f}" for number in ours.paths)
    seconds = " -> ".join(f"{number:.1f}" for number in ours.seconds)
    return " | ".join([str(int(inside.sum())), paths, seconds, *values])


def _level(plan: CapturePlan, light: Floats) -> Floats:
    """The light around each texel, (K, 1)."""
    table = np.stack([light @ LUMINANCE, np.ones(len(light))])[..., None].astype(np.float32)
    near, total = Neighbours(plan).pool(table, wide=True)
    return cast(Floats, near / total + _DIM * float((light @ LUMINANCE).mean()))


def _display(light: Floats, white: float) -> Floats:
    return cast(Floats, np.clip(light / white, 0, 1) ** (1 / 2.2))


def _psnr(light: Floats, truth: Floats, white: float) -> float:
    return -10 * float(np.log10(np.mean((_display(light, white) - _display(truth, white)) ** 2)))


def _relative(light: Floats, truth: Floats, level: Floats) -> float:
    """Decibels of the light's (K, 3) squared error against two references (2, K, 3), relative to a level."""
    product = (light - truth[0]) * (light - truth[1]) / level**2
    return -10 * float(np.log10(max(float(product.mean()), 1e-9)))


if __name__ == "__main__":
    main()
