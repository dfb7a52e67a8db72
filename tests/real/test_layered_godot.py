# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""shaders/radtex_layered.gdshaderinc in a real Godot, against the layered layout's reference sampler."""

from __future__ import annotations

import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.forms.layered.shader_values import (
    FULL,
    Cost,
    bake_values,
    definitions,
    layers_read,
    material_values,
)
from tests.layered_lookups import Case, assert_agrees, case_of
from tests.lookups import SIDE
from tests.real.godot import RENDERERS, Image, Job, answers
from tests.real.root import Root

CODE = """
vec4 answer(ivec2 here) {
    vec2 uv = texelFetch(uvs, here, 0).xy;
    vec3 position = texelFetch(positions, here, 0).xyz;
    vec3 N = texelFetch(normals, here, 0).xyz, V = texelFetch(viewers, here, 0).xyz;
#ifdef RADTEX_THROUGH
    vec3 T = texelFetch(tangents, here, 0).xyz, B = texelFetch(bitangents, here, 0).xyz;
    return vec4(radtex_layered_through(uv, position, N, V, T, B), 1.0);
#else
    return vec4(radtex_layered(uv, position, N, V), 1.0);
#endif
}
"""


def jobs(case: Case, cost: Cost) -> list[Job]:
    """A picture of each material."""
    defines = "".join(f"#define {name} {value}\n" for name, value in definitions(case.sidecar, cost).items())
    includes = ("radtex_layered", *(["radtex_layered_through"] if case.through else []))
    textures: dict[str, Image] = {
        f"radtex_{layer}_map": _levels(case.textures[layer]) for layer in layers_read(case.sidecar, cost)
    }
    textures |= {name: values.reshape(SIDE, SIDE, -1) for name, values in case.fields.items()}
    values = bake_values(case.sidecar, case.stored, cost)
    return [
        Job(
            CODE,
            textures,
            includes,
            defines,
            values=values | material_values(case.sidecar, number, cost),
            declared="radtex_",
        )
        for number in range(len(case.sidecar.materials))
    ]


def _levels(levels: list[Floats]) -> Image:
    return levels if len(levels) > 1 else levels[0]


@pytest.mark.parametrize("renderer", RENDERERS)
def test_godot_agrees_with_the_reference(root: Root, renderer: str) -> None:
    names = ["everything", "everything, in ranges", "made up", "things alone", "clear", "bare", "matt"]
    asked = {name: jobs(case_of(name), FULL) for name in names}
    drawn = iter(answers(root, renderer, [job for some in asked.values() for job in some]))
    for name, some in asked.items():
        by_material = [next(drawn) for _ in some]
        case = case_of(name)
        assert_agrees(f"{renderer}, {name}", case.by_material(by_material.__getitem__), case)
