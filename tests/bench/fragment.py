# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What does a lookup in layout buckets cost? Frame times of each shader over those of a diffuse-only one.

    python -m tests.bench.fragment DIR

DIR keeps the plain bake of `tests.real.exhibit`, which is made if it is missing. The head fills a square
picture of 8-bit colours; all shaders draw in turns, round after round. Prints the median frame and the
median, over the rounds, of its ratio to the diffuse shader's. On llvmpipe that is the processor's time, all
threads together, which other programs disturb less. `tests.bench.fidelity.layered.lookup_cost` measures the
layered layout.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path
from time import perf_counter, process_time

import moderngl
import numpy as np

from radtex_addon.core.arrays import Floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.levels import fitting_levels
from radtex_addon.core.slices import to_slices
from radtex_addon.formats.containers.exr import read_atlas
from radtex_addon.report.finished_bake import Finished
from tests.bench.drawing import SHADERS, Model, Painter, View, canvas, read_model
from tests.real.exhibit import Bake, Exhibit, Form
from tests.real.opengl import mipmapped
from tests.reference.levels import level_chain
from tests.reference.slices import mip_chain

SRGB8_ALPHA8 = 0x8C43  # GL_SRGB8_ALPHA8: colours as games store them
HALF = 0.2  # tangent of half the angle of view
DIFFUSE = """
uniform sampler2D colour;
vec4 shade() { return texture(colour, uv) * max(dot(normalize(normal), vec3(0.36, -0.48, 0.8)), 0.1); }
"""
MATRIX = "uniform sampler2D atlas; uniform ivec2 texels; uniform int n;"
INCIDENCE = "radtex_incidence(camera - position, normal, tangent.xyz, tangent.w)"
HARDWARE = "#define RADTEX_HARDWARE_LINEAR\n"
BY_FILTER = "{} vec4 shade() {{ return radtex_sample(atlas, texels, n, uv, {}, RADTEX_{}); }}"
LEVELS = f"""{MATRIX} uniform int levels;
vec4 shade() {{
    return radtex_sample_level(atlas, texels, n, uv, {INCIDENCE}, radtex_level(uv, texels, levels));
}}"""
SLICES = f"""uniform sampler2DArray slices; uniform int n;
vec4 shade() {{ return radtex_slices(slices, n, uv, {INCIDENCE}); }}"""
Painters = dict[str, Painter]


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("bakes", type=Path, help="folder for the bake")
    parser.add_argument("--pixels", type=int, default=1024, help="of the picture's side")
    parser.add_argument("--rounds", type=int, default=40)
    options = parser.parse_args()
    with moderngl.create_context(standalone=True, backend="egl") as context:  # type: ignore[arg-type]  # wrong stub
        folder = options.bakes / Form.PLAIN
        bake = Bake(folder) if folder.is_dir() else Exhibit(options.bakes).plain
        model = read_model(bake.finished)
        painters = {"diffuse": diffuse(context, model)} | plain(context, model, bake.finished)
        print(f"{context.info['GL_RENDERER']}, {options.pixels} x {options.pixels}, {options.rounds} rounds")
        print_table(measured(context, painters, view_of(model), options.pixels, options.rounds))


def view_of(model: Model) -> View:
    away = np.array([0.4, -0.85, 0.25])
    distance = 0.85 * model.radius / HALF
    return View(model.middle + away / np.linalg.norm(away) * distance, model.middle, HALF)


def diffuse(context: moderngl.Context, model: Model) -> Painter:
    """A colour texture, trilinear, times the cosine to a lamp."""
    image = np.random.default_rng(1).integers(0, 256, (512, 512, 4)).astype(np.uint8)
    texture = context.texture((512, 512), 4, image.tobytes(), internal_format=SRGB8_ALPHA8)
    texture.build_mipmaps()
    return Painter(context, model, DIFFUSE, {"colour": texture}, {})


def plain(context: moderngl.Context, model: Model, bake: Finished) -> Painters:
    """Each filter of the bucket matrix, and slices."""
    image, facts = read_atlas(bake.images[0])
    return of_buckets(context, model, image, AtlasLayout(facts.width, facts.height, facts.bucket))


def of_buckets(context: moderngl.Context, model: Model, image: Floats, layout: AtlasLayout) -> Painters:
    """The same of an atlas's image."""
    levels = fitting_levels(layout)
    matrix = mipmapped(context, [image], moderngl.LINEAR)
    chain = [level.astype(np.float16) for level in level_chain(image, layout, levels)]
    with_levels = mipmapped(context, chain, moderngl.LINEAR_MIPMAP_NEAREST)
    layers = [level.astype(np.float16) for level in mip_chain(to_slices(image, layout))]
    slices = mipmapped(context, layers, moderngl.LINEAR_MIPMAP_LINEAR)
    code = (SHADERS / "radtex.glsl").read_text(encoding="utf-8")
    values = {"texels": (layout.width, layout.height), "n": layout.bucket}

    def filtered(name: str, head: str = "") -> Painter:
        shade = BY_FILTER.format(MATRIX, INCIDENCE, name)
        return Painter(context, model, head + code + shade, {"atlas": matrix}, values)

    by_level = {"levels": levels} | values
    return {
        "nearest": filtered("NEAREST"),
        "linear": filtered("LINEAR"),
        "linear, by hardware": filtered("LINEAR", HARDWARE),
        "quadrilinear": filtered("QUADRILINEAR"),
        "quadrilinear, by hardware": filtered("QUADRILINEAR", HARDWARE),
        "levels": Painter(context, model, code + LEVELS, {"atlas": with_levels}, by_level),
        "levels, by hardware": Painter(
            context, model, HARDWARE + code + LEVELS, {"atlas": with_levels}, by_level
        ),
        "slices": Painter(context, model, code + SLICES, {"slices": slices}, {"n": layout.bucket}),
    }


def measured(
    context: moderngl.Context, painters: Painters, view: View, pixels: int, rounds: int
) -> dict[str, tuple[float, float]]:
    """Each shader's median frame in milliseconds, and the median of its ratio to the diffuse shader's."""
    target = canvas(context, pixels, dtype="f1").drawn
    clock = process_time if "llvmpipe" in context.info["GL_RENDERER"] else perf_counter
    times: dict[str, list[float]] = {name: [] for name in painters}
    for number in range(-2, rounds):  # two to warm up
        for name, painter in painters.items():
            start = clock()
            painter.draw(target, view)
            context.finish()
            if number >= 0:
                times[name].append(1e3 * (clock() - start))
    return {
        name: (float(np.median(own)), float(np.median(np.array(own) / times["diffuse"])))
        for name, own in times.items()
    }


def print_table(figures: Mapping[str, tuple[float, float]]) -> None:
    print("| lookup | a frame, ms | over diffuse |\n|---|---|---|")
    for name, (milliseconds, ratio) in figures.items():
        print(f"| {name} | {milliseconds:.1f} | {ratio:.2f} |")


if __name__ == "__main__":
    main()
