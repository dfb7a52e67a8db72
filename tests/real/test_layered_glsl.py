# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""shaders/radtex_layered.glsl on a real OpenGL, over EGL, against the layered layout's reference sampler."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import moderngl
import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.forms.layered.shader_values import (
    DEFAULT,
    FULL,
    Cost,
    bake_values,
    definitions,
    layers_read,
    material_values,
)
from tests.bench.fidelity.layered.conditions import fetches
from tests.layered_lookups import CASES, Case, assert_agrees, case_of, off
from tests.lookups import SIDE
from tests.real.opengl import VERSIONS, Texture, compiled, drawn, mipmapped, set_values

SHADERS = Path(__file__).parents[2] / "shaders"
FRAGMENT = """
uniform sampler2D uvs, positions, normals, viewers, tangents, bitangents;
out vec4 result;
void main() {
    ivec2 here = ivec2(gl_FragCoord.xy);
    vec2 uv = texelFetch(uvs, here, 0).xy;
    vec3 position = texelFetch(positions, here, 0).xyz;
    vec3 N = texelFetch(normals, here, 0).xyz, V = texelFetch(viewers, here, 0).xyz;
#ifdef RADTEX_THROUGH
    vec3 T = texelFetch(tangents, here, 0).xyz, B = texelFetch(bitangents, here, 0).xyz;
    result = vec4(radtex_layered_through(uv, position, N, V, T, B), 1.0);
#else
    result = vec4(radtex_layered(uv, position, N, V), 1.0);
#endif
}
"""


def code_of(case: Case, cost: Cost) -> str:
    """The shader's text, without a version."""
    head = "".join(f"#define {name} {value}\n" for name, value in definitions(case.sidecar, cost).items())
    names = ["radtex_layered", *(["radtex_layered_through"] if case.through else [])]
    return head + "".join((SHADERS / f"{name}.glsl").read_text(encoding="utf-8") for name in names)


def run(context: moderngl.Context, version: str, case: Case, cost: Cost) -> Floats:
    """The shader's answers, (N, 3) float32."""
    program = compiled(context, VERSIONS[version], code_of(case, cost) + FRAGMENT)
    textures: dict[str, Floats | Texture] = {
        f"radtex_{layer}_map": mipmapped(
            context,
            case.textures[layer],
            moderngl.LINEAR_MIPMAP_LINEAR if len(case.textures[layer]) > 1 else moderngl.LINEAR,
        )
        for layer in layers_read(case.sidecar, cost)
    }
    textures |= {name: values.reshape(SIDE, SIDE, -1) for name, values in case.fields.items()}
    textures = {name: texture for name, texture in textures.items() if name in program}
    set_values(program, bake_values(case.sidecar, case.stored, cost))

    def with_material(number: int) -> Floats:
        set_values(program, material_values(case.sidecar, number, cost))
        return drawn(context, program, textures, SIDE)

    return case.by_material(with_material)


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", CASES)
def test_glsl_agrees_with_the_reference(context: moderngl.Context, version: str, name: str) -> None:
    case = case_of(name)
    assert_agrees(f"{version}, {name}", run(context, version, case, FULL), case)


@pytest.mark.parametrize(
    ("cost", "most"),
    [
        (DEFAULT, 5e-3),
        (replace(FULL, exit_taps=4), 5e-3),
        (replace(DEFAULT, steps=0), 0.02),
        (replace(DEFAULT, second_lobe=False), 0.04),
    ],
)
def test_thrift_changes_little(context: moderngl.Context, cost: Cost, most: float) -> None:
    case = case_of("everything")
    wrong = off(run(context, "GLSL 330", case, cost), case.answers())
    print(f"{cost}: mean error {wrong.mean():.1e}, 99 % {np.quantile(wrong, 0.99):.1e}")
    assert wrong.mean() < most


def test_a_filter_does_not_follow_ways_that_part(context: moderngl.Context) -> None:
    case = case_of("parted ways")
    found = run(context, "GLSL 330", case, replace(FULL, exit_taps=4))
    assert off(found, case.answers()).mean() > 0.03


@pytest.mark.parametrize(
    ("name", "counts"),
    [
        ("everything", (22, 19, 18, 16)),
        ("clear", (19, 16, 15, 13)),
        ("made up", (18, 15, 14, 12)),
        ("things alone", (16, 13, 12, 11)),
        ("bare", (12, 10, 10, 9)),
        ("matt", (6, 5, 5, 5)),
    ],
)
def test_fetches_are_those_of_the_parts(name: str, counts: tuple[int, ...]) -> None:
    costs = (FULL, DEFAULT, replace(DEFAULT, steps=0), replace(DEFAULT, second_lobe=False))
    assert tuple(fetched(case_of(name), cost, "radtex_layered") for cost in costs) == counts


def test_light_that_comes_through_costs_more() -> None:
    case = case_of("everything")
    more = {
        taps: fetched(case, replace(DEFAULT, exit_taps=taps), "radtex_layered_through")
        - fetched(case, DEFAULT, "radtex_layered")
        for taps in (16, 4)
    }
    # exits, colour, the rest, alpha once more, the world, the plane, things and their distance
    assert more == {16: 32 + 1 + 3 + 1 + 4, 4: 8 + 1 + 3 + 1 + 4}


def fetched(case: Case, cost: Cost, function: str) -> int:
    return fetches(code_of(case, cost), definitions(case.sidecar, cost), function)
