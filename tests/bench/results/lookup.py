# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What each method's lookup costs: frames by its shader over those by a diffuse texture alone.

A ball fills a picture; textures are noise of the sizes that a bake of `TEXELS` texels has. Without a GPU that
is llvmpipe, and the processor's time: arithmetic and filtering cost there more, beside each other, than on a
GPU, and memory less.
"""

from __future__ import annotations

from typing import Any

import moderngl
import numpy as np

from radtex_addon.core.arrays import Floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.forms.layered.shader_values import DEFAULT
from tests.layered.made_up import made_up_atlas
from tests.real.opengl import mipmapped

from ..drawing import Model, Painter
from ..fidelity.directional import lobe_axes
from ..fidelity.layered.compressed import compressed
from ..fidelity.layered.lookup import lookup_of
from ..fidelity.layered.lookup_cost import ball, painter_of, view_of
from ..gpu.lookups import Uploads, bucket_lookups, noise
from ..gpu.timing import device, measured
from .lookup_shaders import FETCHES, LIGHTMAP, PROBE, gaussians, harmonics

TEXELS = 64
_BUCKET = 8
_FINER = 4  # times as many texels of colour
_PIXELS, _ROUNDS = 768, 15
_CUBE = 104  # pixels along a face: as many as the bench's probe has


def lookup_costs() -> dict[str, Any]:
    """Fetches, milliseconds a frame and times over diffuse, by method; and what drew."""
    atlas = made_up_atlas(TEXELS, 512)
    decoded, textures = compressed(atlas)
    lookup = lookup_of(decoded, textures, DEFAULT)
    with device() as found_device:
        context, model = found_device.context, ball(decoded)
        painters = {"diffuse": noise(context, model)} | _baselines(context, model)
        layout = AtlasLayout(TEXELS, TEXELS, _BUCKET)
        buckets = bucket_lookups(Uploads(context, False), model, _noise(TEXELS * _BUCKET), layout)
        painters |= {
            "buckets nearest": buckets["buckets, nearest"].painter,
            "buckets": buckets["buckets, quadrilinear, by the sampler"].painter,
            "layered": painter_of(context, model, decoded, lookup),
        }
        views = {name: (painter, view_of(model)) for name, painter in painters.items()}
        found = measured(found_device, views, (_PIXELS, _PIXELS), _ROUNDS)
        drawn_by = found_device.card
    fetches = FETCHES | {"diffuse": 1, "buckets nearest": 1, "buckets": 4, "layered": lookup.fetches}
    rows = {
        name: {
            "fetches": fetches[name],
            "ms": round(float(np.median(frames.clock)), 2),
            "over_diffuse": round(float(np.median(frames.clock / found["diffuse"].clock)), 2),
        }
        for name, frames in found.items()
    }
    return {"renderer": drawn_by, "pixels": _PIXELS, "rounds": _ROUNDS, "texels": TEXELS, "methods": rows}


def _baselines(context: moderngl.Context, model: Model) -> dict[str, Painter]:
    fine, coarse = _texture(context, TEXELS * _FINER), _texture(context, TEXELS)
    flat = {"colour": fine, "light": coarse}
    rng = np.random.default_rng(2)
    low, high = model.middle - 3.0, model.middle + 3.0
    cube = _cube(context)
    probe = flat | {
        "surface": fine,
        "occlusion": coarse,
        "split_sum": mipmapped(context, [rng.random((32, 32, 2)).astype(np.float16)], moderngl.LINEAR),
        "probe": cube,
    }
    box = {"middle": tuple(model.middle), "low": tuple(low), "high": tuple(high)}
    axes = [tuple(axis) for axis in lobe_axes(9).tolist()]

    def painter(code: str, textures: dict[str, Any], values: dict[str, Any]) -> Painter:
        return Painter(context, model, code, textures, values)

    def layers(count: int) -> dict[str, Any]:
        images = rng.random((count, TEXELS, TEXELS, 4)).astype(np.float16)
        return flat | {"layers": mipmapped(context, [images], moderngl.LINEAR)}

    return {
        "lightmap": painter(LIGHTMAP, flat | {"rest": _texture(context, TEXELS)}, {}),
        "sh": painter(harmonics(9), layers(9), {}),
        "sh3": painter(harmonics(16), layers(16), {}),
        "sg": painter(gaussians(9), layers(9), {"axes": axes, "sharpness": 8.0}),
        "probe": painter(PROBE, probe, box),
    }


def _noise(side: int) -> Floats:
    noise: Floats = np.random.default_rng(3).random((side, side, 4)).astype(np.float16)
    return noise


def _texture(context: moderngl.Context, side: int) -> Any:
    return mipmapped(context, [_noise(side)], moderngl.LINEAR)


def _cube(context: moderngl.Context) -> Any:
    faces = np.random.default_rng(4).random((6, _CUBE, _CUBE, 4)).astype(np.float16)
    cube = context.texture_cube((_CUBE, _CUBE), 4, faces.tobytes(), dtype="f2")
    cube.build_mipmaps()
    cube.filter = (moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR)
    return cube
