# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""shaders/radtex_shadow.wgsl by wgpu, on a real Vulkan, against core.shadow: a light, a sun, a rectangle."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from radtex_addon.core.atlas import AtlasLayout
from tests.lookups import SIDE, random_lookups
from tests.real.root import Root
from tests.real.shadows import (
    ACROSS,
    ANGLE,
    CORNER,
    ONE,
    POINTS,
    RECTANGLE,
    SUN,
    UP,
    check,
    expected,
    random_words,
    stacked,
)
from tests.real.webgpu import Resource, drawn, fields, image

FOLDER = Path(__file__).parents[2] / "shaders"
FRAGMENT = """
struct Settings { corner: vec4f, across: vec4f, up: vec4f, texels: vec2i, n: i32, mode: i32 }
@group(0) @binding(0) var<uniform> s: Settings;
@group(0) @binding(1) var fields: texture_2d_array<f32>;
@group(0) @binding(2) var bits: texture_2d_array<u32>;
@fragment fn main(@builtin(position) at: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(at.xy);
    let normal = textureLoad(fields, pixel, 1, 0);
    let light = textureLoad(fields, pixel, 3, 0).xyz;
    let frame = radtex_frame(normal.xyz, textureLoad(fields, pixel, 2, 0).xyz, normal.w);
    let here = radtex_shadow(bits, s.texels, textureLoad(fields, pixel, 0, 0).xy);
    if s.mode == 0 { return vec4f(radtex_visible(bits, here, s.n, normalize(light) * frame)); }
    if s.mode == 1 { return vec4f(radtex_sun(bits, here, s.n, frame, light, s.corner.w, i32(s.up.w))); }
    let side = s.across.xyz;
    return vec4f(radtex_rectangle(bits, here, s.n, frame, light, s.corner.xyz, side, s.up.xyz, i32(s.up.w)));
}
"""


@pytest.mark.parametrize("mode", [ONE, SUN, RECTANGLE])
@pytest.mark.parametrize("cells", [5, 8, 12])
def test_wgsl_agrees_with_the_reference(root: Root, cells: int, mode: int) -> None:
    layout, lookups = AtlasLayout(13, 7, cells), random_lookups()
    words = random_words(layout)
    settings = np.array([*CORNER, ANGLE, *ACROSS, 0, *UP, POINTS], np.float32).tobytes()
    settings += np.array([layout.width, layout.height, cells, mode], np.int32).tobytes()
    normals = np.concatenate([lookups.normal, lookups.sign[:, None]], axis=1)
    resources: dict[int | str, Resource] = {
        "s": np.frombuffer(settings, np.uint8),
        "fields": fields(SIDE, lookups.uv, normals, lookups.tangent, lookups.viewer),
        "bits": image(stacked(words)),
    }
    code = "".join(
        FOLDER.joinpath(f"{name}.wgsl").read_text(encoding="utf-8") for name in ("radtex", "radtex_shadow")
    )
    found = drawn(root, code + FRAGMENT, resources, SIDE)[:, 0]
    wanted = expected(words, layout, lookups, mode, cells > 8)
    check(found, wanted, mode, cells > 8, f"WGSL, {cells} cells")
