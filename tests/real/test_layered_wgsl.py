# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""shaders/radtex_layered.wgsl by wgpu, on a real Vulkan, against the layered layout's reference sampler."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.forms.layered.files.arrangement import CHANNELS
from radtex_addon.forms.layered.shader_values import (
    BAKE_BUFFER,
    DEFAULT,
    FULL,
    MATERIAL_BUFFER,
    THROUGH_BUFFER,
    Cost,
    Values,
    bake_values,
    buffer_of,
    definitions,
    material_values,
)
from tests.layered_lookups import Case, assert_agrees, case_of, off
from tests.lookups import SIDE
from tests.real.root import Root
from tests.real.webgpu import Resource, Sampler, drawn, fields, image

SHADERS = Path(__file__).parents[2] / "shaders"
FRAGMENT = """
@group(0) @binding(20) var fields: texture_2d_array<f32>;
@fragment fn main(@builtin(position) at: vec4f) -> @location(0) vec4f {
    let here = vec2i(at.xy);
    let uv = textureLoad(fields, here, 0, 0).xy;
    let position = textureLoad(fields, here, 1, 0).xyz;
    let N = textureLoad(fields, here, 2, 0).xyz;
    let V = textureLoad(fields, here, 3, 0).xyz;
    let T = textureLoad(fields, here, 4, 0).xyz;
    let B = textureLoad(fields, here, 5, 0).xyz;
    return vec4f(%s, 1.0);
}
"""
LOOKUP, THROUGH = (
    "radtex_layered(uv, position, N, V)",
    "radtex_layered_through(uv, position, N, V, T, B)",
)


def run(root: Root, case: Case, cost: Cost) -> Floats:
    """The shader's answers, (N, 3) float32."""
    names = ["radtex_layered", *(["radtex_layered_through"] if case.through else [])]
    code = "".join((SHADERS / f"{name}.wgsl").read_text(encoding="utf-8") for name in names)
    code = code.replace("@group(1)", "@group(0)") + FRAGMENT % (THROUGH if case.through else LOOKUP)
    constants = {name: float(value) for name, value in definitions(case.sidecar, cost).items()}
    constants.pop("RADTEX_THROUGH", None)
    values = bake_values(case.sidecar, case.stored, cost)
    resources: dict[int | str, Resource] = {
        "radtex": packed(values, BAKE_BUFFER),
        "radtex_filtering": Sampler("linear"),
        "fields": fields(SIDE, *case.fields.values()),
    }
    if case.through:
        resources["radtex_exit"] = packed(values, THROUGH_BUFFER)
    lacking = image(np.zeros((1, 1, 4), np.float16))
    for layer in CHANNELS:
        if f"radtex_{layer}_map" in code:
            levels = case.textures.get(layer)
            resources[f"radtex_{layer}_map"] = lacking if levels is None else image(*levels)

    def with_material(number: int) -> Floats:
        of_material = packed(material_values(case.sidecar, number, cost), MATERIAL_BUFFER)
        return drawn(root, code, resources | {"radtex_of": of_material}, SIDE, constants=constants)

    return case.by_material(with_material)


def packed(values: Values, layout: Mapping[str, int]) -> Floats:
    return np.array(buffer_of(values, layout), dtype=np.float32)


@pytest.mark.parametrize(
    "name", ["everything", "everything, in ranges", "made up", "things alone", "clear", "bare", "matt"]
)
def test_wgsl_agrees_with_the_reference(root: Root, name: str) -> None:
    case = case_of(name)
    assert_agrees(name, run(root, case, FULL), case)


def test_thrift_changes_little(root: Root) -> None:
    case = case_of("everything")
    wrong = off(run(root, case, DEFAULT), case.answers())
    print(f"as it is by default: mean error {wrong.mean():.1e}")
    assert wrong.mean() < 0.01
