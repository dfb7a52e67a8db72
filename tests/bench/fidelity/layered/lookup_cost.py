# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What does a lookup in the layered layout cost? Texture fetches, bytes, time, and what thrift changes.

    python -m tests.bench.fidelity.layered.lookup_cost [--atlas PICKLE]

Of a made-up bake of 128 texels that has every part, or of a pickled LayeredAtlas. A ball fills a square
picture of 8-bit colours; all shaders draw in turns, round after round, beside a diffuse texture. Real bakes,
and cards, are for `tests.bench.gpu`. Differences are those of the shader's answers at random fragments from
`sample_layered` of the decoded atlas, over what that finds and a twentieth of white.
"""

from __future__ import annotations

import argparse
import pickle
from dataclasses import replace
from pathlib import Path

import moderngl
import numpy as np

from radtex_addon.core.arrays import Floats
from radtex_addon.forms.layered.lookup.atlas import LayeredAtlas, sample_layered
from radtex_addon.forms.layered.shader_values import DEFAULT, FULL
from tests.bench.drawing import Model, Painter, View
from tests.bench.gpu.lookups import noise
from tests.bench.gpu.timing import device, measured
from tests.layered.made_up import made_up_atlas, made_up_fragments
from tests.real.opengl import uniform

from .compressed import MATERIAL_MAPS, compressed
from .drawn_fragments import radiance
from .lookup import Lookup, lookup_of

SHADE = """
vec4 shade() {
    return vec4(radtex_layered(uv, position, normalize(normal), normalize(camera - position)), 1.0);
}
"""
WAYS = {
    "all of it": FULL,
    "three cells of a direction": replace(FULL, own_taps=3, rest_taps=3),
    "one fetch of distances": replace(FULL, steps=1),
    "both, as it is by default": DEFAULT,
    "and no distances": replace(DEFAULT, steps=0),
    "and one lobe": replace(DEFAULT, steps=0, second_lobe=False),
}


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--atlas", type=Path, help="a pickled LayeredAtlas")
    parser.add_argument("--pixels", type=int, default=1024, help="of the picture's side")
    parser.add_argument("--rounds", type=int, default=15)
    options = parser.parse_args()
    atlas = pickle.loads(options.atlas.read_bytes()) if options.atlas else made_up_atlas(128, 512)
    decoded, textures = compressed(atlas)
    for name, texture in textures.items():
        height, width = texture.levels[0].shape[:2]
        print(f"{name:12s} {texture.format:9s} {width:5d} x {height:4d} {texture.bytes:9,d} bytes")
    lookups = {name: lookup_of(decoded, textures, cost) for name, cost in WAYS.items()}
    fragments = made_up_fragments(decoded, 40_000)
    expected = sample_layered(decoded, fragments)
    with device() as found_device:
        context, model = found_device.context, ball(decoded)
        painters = {"diffuse": noise(context, model)}
        off = {}
        for name, lookup in lookups.items():
            found = radiance(context, decoded, lookup, fragments)
            off[name] = np.abs(found - expected) / (np.abs(expected) + 0.05)
            painters[name] = painter_of(context, model, decoded, lookup)
        print(f"{found_device.card}, {options.pixels} x {options.pixels}, {options.rounds} rounds")
        views = {name: (painter, view_of(model)) for name, painter in painters.items()}
        figures = measured(found_device, views, (options.pixels, options.pixels), options.rounds)
    diffuse = figures["diffuse"].clock
    print("| lookup | fetches | bytes | a frame, ms | over diffuse | off, mean | off, 99.9 % |")
    print(f"|---|---|---|---|---|---|---|\n| diffuse | 1 | | {np.median(diffuse):.1f} | 1.00 | | |")
    for name, lookup in lookups.items():
        milliseconds = np.median(figures[name].clock)
        ratio = np.median(figures[name].clock / diffuse)
        print(
            f"| {name} | {lookup.fetches} | {light_bytes(lookup):,d} | {milliseconds:.1f} | {ratio:.2f} "
            f"| {off[name].mean():.4f} | {np.quantile(off[name], 0.999):.4f} |"
        )


def light_bytes(lookup: Lookup) -> int:
    """Without the maps of the material."""
    return sum(texture.bytes for layer, texture in lookup.textures.items() if layer not in MATERIAL_MAPS)


def painter_of(context: moderngl.Context, model: Model, atlas: LayeredAtlas, lookup: Lookup) -> Painter:
    """Draws the model with the atlas's first material."""
    values = {name: uniform(value) for name, value in lookup.values(0).items()}
    return Painter(context, model, lookup.code + SHADE, lookup.uploaded(context), values)


def view_of(model: Model) -> View:
    """A view in which the model fills a square."""
    half = 0.2
    away = np.array([0.4, -0.85, 0.25])
    distance = 0.85 * model.radius / half
    return View(model.middle + away / np.linalg.norm(away) * distance, model.middle, half)


def ball(atlas: LayeredAtlas, around: int = 96) -> Model:
    """A ball about the bake's middle, its texture coordinates longitude and latitude."""
    u, v = np.meshgrid(np.linspace(0, 1, around + 1), np.linspace(0, 1, around // 2 + 1))
    turn, rise = 2 * np.pi * u, np.pi * (v - 0.5)
    parts = (np.cos(turn) * np.cos(rise), np.sin(turn) * np.cos(rise), np.sin(rise))
    normal = np.stack(parts, axis=-1)
    tangent = np.stack([-np.sin(turn), np.cos(turn), np.zeros_like(turn)], axis=-1)
    fields = (atlas.around.middle + 0.8 * normal, normal, tangent, np.ones((*u.shape, 1)))
    points: Floats = np.concatenate([*fields, u[..., None], v[..., None]], axis=-1).astype(np.float32)
    first, right, above, last = points[:-1, :-1], points[:-1, 1:], points[1:, :-1], points[1:, 1:]
    corners = np.stack([first, right, last, first, last, above], axis=2).reshape(-1, 12)
    return Model.of(np.ascontiguousarray(corners))


if __name__ == "__main__":
    main()
