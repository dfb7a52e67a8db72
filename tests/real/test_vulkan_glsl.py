# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The GLSL includes as Vulkan wants them: compiled by glslang, the result checked by spirv-val."""

from __future__ import annotations

import pytest

from tests.real.root import Root

EXAMPLES = "/repository/shaders/examples"
WAYS = {
    "matrix": [],
    "matrix, by hardware": ["-DRADTEX_HARDWARE_LINEAR"],
    "pages": ["-DRADTEX_PAGES"],
    "pages, by hardware": ["-DRADTEX_PAGES", "-DRADTEX_HARDWARE_LINEAR"],
    "slices": ["-DRADTEX_SLICES"],
}
TOGETHER = """#version 450
#extension GL_GOOGLE_include_directive : require
#include "radtex.glsl"
#include "radtex_shadow.glsl"
#include "radtex_transfer.glsl"
layout(set = 0, binding = 0) uniform usampler2D bits;
layout(set = 0, binding = 1) uniform sampler2D atlas;
layout(location = 0) in vec3 L;
layout(location = 1) in vec2 uv;
layout(location = 0) out vec4 result;
void main() {
    RadtexShadow here = radtex_shadow(bits, ivec2(64), uv);
    result = radtex_transfer(atlas, ivec2(64), 9, uv, L) * radtex_visible(here, 8, L);
}
"""
LAYERED = """#version 450
#extension GL_GOOGLE_include_directive : require
#define RADTEX_DECLARED
#define RADTEX_MIRRORS 1
#define RADTEX_WIDTH 1
#define RADTEX_ALPHA 1
#define RADTEX_PLANE 1
#define RADTEX_THINGS 1
#define RADTEX_SHELL 6
#define RADTEX_BOXES 4
#define RADTEX_LAMPS 2
#define RADTEX_OWN_CELLS 14
#define RADTEX_REST_CELLS 8
layout(set = 0, binding = 0) uniform Bake {
    vec4 radtex_material[16], radtex_lobes[32], radtex_lamp_place[2], radtex_lamp_light[2];
    vec4 radtex_colour_range, radtex_irradiance_range, radtex_rest_range, radtex_rest_tile;
    vec4 radtex_alpha_range, radtex_width_range, radtex_own_range, radtex_own_tile, radtex_middle;
    vec4 radtex_world_range, radtex_world_levels, radtex_plane_range, radtex_plane_levels;
    vec4 radtex_plane_place, radtex_plane_eye, radtex_things_range, radtex_things_levels;
    vec4 radtex_distances_range, radtex_distances_size, radtex_things_eye, radtex_shell[6],
    radtex_box_low[4], radtex_box_high[4];
};
layout(set = 0, binding = 1) uniform sampler2D radtex_colour_map;
layout(set = 0, binding = 2) uniform sampler2D radtex_irradiance_map;
layout(set = 0, binding = 3) uniform sampler2D radtex_rest_map;
layout(set = 0, binding = 4) uniform sampler2D radtex_alpha_map;
layout(set = 0, binding = 5) uniform sampler2D radtex_width_map;
layout(set = 0, binding = 6) uniform sampler2D radtex_own_map;
layout(set = 0, binding = 7) uniform sampler2D radtex_world_map;
layout(set = 0, binding = 8) uniform sampler2D radtex_plane_map;
layout(set = 0, binding = 9) uniform sampler2D radtex_things_map;
layout(set = 0, binding = 10) uniform sampler2D radtex_distances_map;
#include "radtex.glsl"
#include "radtex_layered.glsl"
layout(location = 0) out vec4 result;
void main() {
    vec2 uv = vec2(0.5);
    result = vec4(radtex_layered(uv, vec3(1, 0, 0), vec3(1, 0, 0), vec3(0, 0, 1)), radtex_alpha(uv));
}
"""
COMPUTE = """#version 450
#extension GL_GOOGLE_include_directive : require
#define RADTEX_NO_DERIVATIVES
#include "radtex.glsl"
layout(local_size_x = 64) in;
layout(set = 0, binding = 0) uniform sampler2D atlas;
layout(set = 0, binding = 1) buffer Seen { vec4 light[]; };
void main() {
    vec3 I = radtex_incidence(vec3(0, 0, 1), vec3(0, 0, 1), vec3(1, 0, 0), 1.0);
    light[gl_GlobalInvocationID.x] = radtex_sample(atlas, ivec2(64), 8, vec2(0.5), I, RADTEX_QUADRILINEAR);
}
"""


def check(root: Root, arguments: list[str], folder: str) -> None:
    compiled = root.run(["glslangValidator", "-V", *arguments, "-o", "out.spv"], cwd=folder)
    assert compiled.returncode == 0, compiled.stdout
    checked = root.run(["spirv-val", "out.spv"], cwd=folder)
    assert checked.returncode == 0, checked.stderr


@pytest.mark.parametrize("way", WAYS)
def test_the_example_is_good_spirv(root: Root, way: str) -> None:
    _, inside = root.shared("example")
    check(root, [*WAYS[way], f"{EXAMPLES}/object.frag.glsl"], inside)


def test_so_is_its_vertex_stage(root: Root) -> None:
    _, inside = root.shared("vertex")
    check(root, [f"{EXAMPLES}/object.vert.glsl"], inside)


@pytest.mark.parametrize("hardware", [[], ["-DRADTEX_HARDWARE_LINEAR"]])
def test_includes_of_buckets_go_together(root: Root, hardware: list[str]) -> None:
    here, inside = root.shared("together")
    (here / "all.frag").write_text(TOGETHER, encoding="utf-8")
    check(root, ["-I/repository/shaders", *hardware, "all.frag"], inside)


@pytest.mark.parametrize("stage", ["frag", "vert"])
def test_the_layered_layout_is_declared_in_a_block(root: Root, stage: str) -> None:
    here, inside = root.shared("layered")
    code = LAYERED.replace(
        "#define RADTEX_DECLARED", "#define RADTEX_DECLARED\n#define RADTEX_NO_DERIVATIVES"
    )
    (here / f"all.{stage}").write_text(LAYERED if stage == "frag" else code, encoding="utf-8")
    check(root, ["-I/repository/shaders", f"all.{stage}"], inside)


def test_lookups_work_in_stages_without_derivatives(root: Root) -> None:
    here, inside = root.shared("compute")
    (here / "seen.comp").write_text(COMPUTE, encoding="utf-8")
    check(root, ["-I/repository/shaders", "seen.comp"], inside)
