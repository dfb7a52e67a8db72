# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Does an object far away shimmer? It turns and shrinks, drawn in four ways, against a supersampled picture.

    uv run bake.py demo --out DIR
    python -m tests.bench.minification DIR --figure docs/figures/minification.png

Prints PSNR (display values: clipped, gamma 2.2) and flicker: how much the picture changes from frame to
frame, as a share of what the supersampled one changes (1 is right, more shimmers); both where the object
covers a pixel wholly.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import moderngl
import numpy as np
from PIL import Image

from radtex_addon.core.arrangements import fitting_levels, to_slices
from radtex_addon.core.arrays import Floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.formats.containers.exr import read_atlas
from radtex_addon.report.finished_bake import find_bake, read_bake
from radtex_addon.report.metrics import Mask, Picture, display, psnr
from tests.bench.baked_model import read_model
from tests.bench.drawing import SHADERS, Canvas, Model, Painter, View, canvas
from tests.real.opengl import mipmapped
from tests.reference.levels import level_chain
from tests.reference.slices import mip_chain

PIXELS, RAYS = 192, 8  # of a picture's side, and rays along a pixel's side of the supersampled one
LARGEST, SMALLEST = 160, 10  # the object's height in pixels, first and last
EDGES = 4  # samples a pixel for edges, as games have it: no texture filter is to blame for those
FRAMES = 81  # 20 while the object halves, and each turns it by 2 degrees
TURN = np.radians(2)
HALF = 0.1  # tangent of half the angle of view
MATRIX = "uniform sampler2D atlas; uniform ivec2 texels; uniform int n, levels;"
SLICES = "uniform sampler2DArray slices; uniform int n;"
INCIDENCE = "radtex_incidence(camera - position, normal, tangent.xyz, tangent.w)"
WAYS = {
    "level 0": f"{MATRIX} vec4 shade() {{ return radtex_sample("
    f"atlas, texels, n, uv, {INCIDENCE}, RADTEX_QUADRILINEAR); }}",
    "levels": f"{MATRIX} vec4 shade() {{ return radtex_sample_level("
    f"atlas, texels, n, uv, {INCIDENCE}, radtex_level(uv, texels, levels)); }}",
    "slices": f"{SLICES} vec4 shade() {{ return radtex_slices(slices, n, uv, {INCIDENCE}); }}",
    "slices, anisotropic": f"{SLICES} vec4 shade() {{ return radtex_slices(slices, n, uv, {INCIDENCE}); }}",
}
TRUTH = f"supersampled, {RAYS} x {RAYS}"


@dataclass(frozen=True, eq=False)
class Frame:
    """A moment of the film: the object's height in pixels, linear pictures (H, W, 3), where it is whole."""

    height: float
    pictures: dict[str, Picture]
    inside: Mask


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("bake", type=Path, help="folder of a bake with a saved preview")
    parser.add_argument("--figure", type=Path, help="where to leave a picture")
    options = parser.parse_args()
    frames = film(find_bake(options.bake, None).path)
    print_table(frames)
    if options.figure:
        save_figure(frames, options.figure)


def film(sidecar: Path) -> list[Frame]:
    bake = read_bake(sidecar)
    model = read_model(bake)
    with moderngl.create_context(standalone=True, backend="egl") as context:  # type: ignore[arg-type]  # wrong stub
        print(context.info["GL_RENDERER"])
        ways = painters(context, model, bake.images[0])
        small, large = (
            canvas(context, (PIXELS, PIXELS), EDGES),
            canvas(context, (PIXELS * RAYS, PIXELS * RAYS)),
        )
        frames = []
        for number, height in enumerate(np.geomspace(LARGEST, SMALLEST, FRAMES)):
            view = view_of(model, height, number * TURN)
            supersampled, cover = resolved(drawn(ways["level 0"], large, view))
            pictures, inside = {TRUTH: supersampled}, cover == 1
            for way, painter in ways.items():
                picture = drawn(painter, small, view)
                pictures[way], inside = picture[..., :3].astype(float), inside & (picture[..., 3] == 1)
            frames.append(Frame(float(height), pictures, inside))
    return frames


def painters(context: moderngl.Context, model: Model, image: Path) -> dict[str, Painter]:
    pixels, facts = read_atlas(image)
    layout = AtlasLayout(facts.width, facts.height, facts.bucket)
    levels = fitting_levels(layout)
    code = (SHADERS / "radtex.glsl").read_text(encoding="utf-8")
    matrix = {"texels": (layout.width, layout.height), "n": layout.bucket}
    chain = [level.astype(np.float16) for level in level_chain(pixels, layout, levels)]
    slices = [level.astype(np.float16) for level in mip_chain(to_slices(pixels, layout))]
    made = {}
    for way, shade in WAYS.items():
        values: dict[str, object] = {"n": layout.bucket}
        if "slices" in way:
            texture = mipmapped(context, slices, moderngl.LINEAR_MIPMAP_LINEAR)
            texture.anisotropy = 16.0 if "anisotropic" in way else 1.0
            made[way] = Painter(context, model, code + shade, {"slices": texture}, values)
        else:
            values = dict(matrix) | ({"levels": levels} if way == "levels" else {})
            texture = mipmapped(context, chain, moderngl.NEAREST)
            made[way] = Painter(context, model, code + shade, {"atlas": texture}, values)
    return made


def view_of(model: Model, height: float, angle: float) -> View:
    """The camera goes round the object, as if it turned, and shows its sphere `height` pixels high."""
    distance = model.radius / (HALF * height / PIXELS)
    away = np.array([np.sin(angle), -np.cos(angle), 0.25]) / np.hypot(1, 0.25)
    return View(model.middle + away * distance, model.middle, HALF)


def drawn(painter: Painter, target: Canvas, view: View) -> Floats:
    """The picture, rows from the top, (H, W, 4): linear light and the share of samples on the object."""
    painter.draw(target.drawn, view)
    return target.read()[::-1]


def resolved(picture: Floats) -> tuple[Picture, Floats]:
    """The mean light of a pixel's rays, (H, W, 3), and the share that meets the object, (H, W)."""
    mean = picture.reshape(PIXELS, RAYS, PIXELS, RAYS, 4).astype(float).mean(axis=(1, 3))
    return mean[..., :3], mean[..., 3]


def print_table(frames: list[Frame]) -> None:
    """PSNR and flicker by the object's height, halving from row to row."""
    ways = list(WAYS)
    heights = np.geomspace(LARGEST, SMALLEST, 5)
    print("| its sphere, pixels | " + " | ".join(f"{way}, dB | flicker" for way in ways) + " |")
    print("|---|" + "---|---|" * len(ways))
    for high, low in pairwise(heights):
        some = [frame for frame in frames if low * 0.999 <= frame.height <= high * 1.001]
        cells = [f"{decibels(some, way):.1f} | {flicker(some, way):.2f}" for way in ways]
        print(f"| {high:.0f} to {low:.0f} | " + " | ".join(cells) + " |")


def decibels(frames: list[Frame], way: str) -> float:
    return float(
        np.mean([psnr(frame.pictures[way], frame.pictures[TRUTH], frame.inside) for frame in frames])
    )


def flicker(frames: list[Frame], way: str) -> float:
    return change(frames, way) / change(frames, TRUTH)


def change(frames: list[Frame], way: str) -> float:
    """The mean difference of display values between frames, over pixels that are whole in both."""
    total, count = 0.0, 0
    for before, after in pairwise(frames):
        both = before.inside & after.inside
        total += float(np.abs(display(after.pictures[way]) - display(before.pictures[way]))[both].sum())
        count += 3 * int(both.sum())
    return total / count


def save_figure(frames: list[Frame], path: Path) -> None:
    """Rows: ever smaller; columns: the ways and the supersampled picture; each cut out and enlarged."""
    side, rows = 192, []
    for frame in frames[20::20]:
        reach = int(np.ceil(frame.height / 2)) + 1
        box = slice(PIXELS // 2 - reach, PIXELS // 2 + reach)
        cut = [display(frame.pictures[way][box, box]) * 255 + 0.5 for way in (*WAYS, TRUTH)]
        images = (Image.fromarray(some.astype(np.uint8)) for some in cut)
        large = [image.resize((side, side), Image.Resampling.NEAREST) for image in images]
        rows.append(np.concatenate([np.asarray(image) for image in large], axis=1))
    Image.fromarray(np.concatenate(rows)).save(path, optimize=True)


if __name__ == "__main__":
    main()
