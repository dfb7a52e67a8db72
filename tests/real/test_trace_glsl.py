# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""shaders/radtex_trace.* on a real OpenGL and in a real Godot, against asking each ray and triangle."""

from __future__ import annotations

from pathlib import Path

import moderngl
import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.core.ray_tree import build_tree
from radtex_addon.export.mirror import packed
from tests.lookups import SIDE
from tests.real.godot import RENDERERS, Job, answers
from tests.real.opengl import VERSIONS, compiled, drawn
from tests.real.root import Root
from tests.reference.traced import random_rays, random_surface, trace

SHADER = Path(__file__).parents[2] / "shaders" / "radtex_trace.glsl"
WIDTH = 64  # of the texture
LEAST_CLEAR = 0.8  # of the rays, so that the test tells something
ANSWER = """
vec4 told(ivec2 here, int what) {
    vec3 from = texelFetch(origins, here, 0).xyz, ray = texelFetch(rays, here, 0).xyz;
    RadtexMet met = radtex_trace(tree, %d, from, ray, 0.0, CULLED);
    if (what == 0) return vec4(met.far, met.uv, float(met.material));
    if (what == 1) return vec4(met.normal, met.tangent.w);
    return vec4(met.tangent.xyz, 0.0);
}
"""
MAIN = "uniform int what;\nout vec4 result;\nvoid main() { result = told(ivec2(gl_FragCoord.xy), what); }\n"
CULLED = {"culled": "#define CULLED true\n", "both sides": "#define CULLED false\n"}


class Case:
    """A surface as a texture, rays, and what they must find."""

    def __init__(self, culled: bool) -> None:
        self.surface = random_surface()
        tree = build_tree(self.surface.corner_position)
        self.nodes = len(tree.skip)
        texels = packed(self.surface, tree, mirrored=False)
        rows = -(-len(texels) // WIDTH)
        image = np.zeros((rows * WIDTH, 4), np.float32)
        image[: len(texels)] = texels
        self.texture = image.reshape(rows, WIDTH, 4)
        origin, ray = random_rays()
        self.fields = {
            "origins": origin.reshape(SIDE, SIDE, 3),
            "rays": ray.reshape(SIDE, SIDE, 3),
        }
        self.truth = trace(self.surface.corner_position, origin, ray, culled)

    def check(self, told: list[Floats], whose: str) -> None:
        """Hold a shader's three answers, (N, 4) each, to the truth."""
        truth, surface = self.truth, self.surface
        clear = truth.clear
        hit = np.isfinite(truth.far)
        assert clear.mean() > LEAST_CLEAR
        assert 0.1 < hit.mean() < 0.95
        assert np.array_equal(told[0][clear, 0] >= 0, hit[clear])
        here = clear & hit
        expected = [
            truth.far[here, None],
            truth.between(surface.uv)[here],
            surface.material_numbers[truth.triangle][here, None],
            truth.between(surface.normal)[here],
            surface.sign[truth.triangle][here, :1],
            truth.between(surface.tangent)[here],
        ]
        found = np.concatenate([part[here] for part in told], axis=1)[:, :11]
        error = np.abs(found - np.concatenate(expected, axis=1)).max()
        print(f"{whose}: {here.sum()} hits, worst error {error:.1e}")
        assert error < 1e-2


@pytest.mark.parametrize("sides", CULLED)
@pytest.mark.parametrize("version", VERSIONS)
def test_glsl_finds_what_each_triangle_tells(context: moderngl.Context, version: str, sides: str) -> None:
    case = Case(sides == "culled")
    uniforms = "uniform sampler2D tree, origins, rays;\n"
    code = CULLED[sides] + SHADER.read_text(encoding="utf-8") + uniforms + ANSWER % case.nodes + MAIN
    told = []
    for what in range(3):
        program = compiled(context, VERSIONS[version], code)
        if "what" in program:
            program["what"] = what
        told.append(drawn(context, program, {"tree": case.texture, **case.fields}, SIDE))
    case.check(told, f"{version}, {sides}")


@pytest.mark.parametrize("renderer", RENDERERS)
def test_godot_finds_the_same(root: Root, renderer: str) -> None:
    case = Case(True)
    jobs = [
        Job(
            code=ANSWER % case.nodes + f"vec4 answer(ivec2 here) {{ return told(here, {what}); }}\n",
            textures={"tree": case.texture, **case.fields},
            includes=("radtex_trace",),
            defines=CULLED["culled"],
            hints={"tree": "filter_nearest"},
        )
        for what in range(3)
    ]
    case.check(answers(root, renderer, jobs), renderer)
