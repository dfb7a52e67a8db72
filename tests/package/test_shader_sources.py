# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The lookups in shaders/ are what shaders/source makes of them. tests/real runs them."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest

pytestmark = pytest.mark.one_blender

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def build() -> ModuleType:
    spec = importlib.util.spec_from_file_location("build_shaders", ROOT / ".ci/build_shaders.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # where dataclasses look up types
    spec.loader.exec_module(module)
    return module


def test_the_lookups_are_what_their_sources_make(build: ModuleType) -> None:
    texts = build.rendered()
    stale = {path.name for path, text in texts.items() if path.read_text(encoding="utf-8") != text}
    assert stale == set(), "uv run .ci/build_shaders.py writes them anew"
    by_hand = {path for path in (ROOT / "shaders").glob("*.*") if path.suffix not in (".md", ".osl")}
    assert by_hand == set(texts)


@pytest.mark.parametrize(
    ("statement", "wgsl"),
    [
        ("vec2 a = b, c;", "let a = b;\nvar c: vec2f;"),
        ("d.x = d.x < 0.0 ? -1.0 : 1.0;", "d.x = select(1.0, -1.0, d.x < 0.0);"),
        (
            "return (flipped ? mix(a, b, 1.0 - f) : a.yx) * 0.5;",
            "return select(a.yx, mix(a, b, 1.0 - f), flipped) * 0.5;",
        ),
        ("if (kept > 0.0) sum += ivec2(1, 2);", "if kept > 0.0 { sum += vec2i(1, 2); }"),
        ("[unroll] for (int k = 0; k < n; k++) {", "for (var k = 0; k < n; k++) {"),
        ("vec4 taps[16];", "var taps: array<vec4f, 16>;"),
        ("int last = (size - 1) >> level;  // why", "let last = (size - 1) >> u32(level);  // why"),
        (
            "vec3 radtex_x(sampler2D image, vec2 uv) {",
            "fn radtex_x(image: texture_2d<f32>, uv: vec2f) -> vec3f {",
        ),
    ],
)
def test_statements_become_those_of_wgsl(build: ModuleType, statement: str, wgsl: str) -> None:
    assert build.Wgsl(build.WORDS["wgsl"]).written(statement) == wgsl


def test_a_condition_in_a_function_is_an_if_of_wgsl(build: ModuleType) -> None:
    lines = [
        "float f() {",
        "#ifdef RADTEX_TINT",
        "    return 1.0;",
        "#else",
        "    return 0.0;",
        "#endif",
        "}",
    ]
    writer = build.Wgsl(build.WORDS["wgsl"])
    assert list(build.written([(line, False) for line in lines], writer)) == [
        "fn f() -> f32 {",
        "    if RADTEX_TINT {",
        "        return 1.0;",
        "    } else {",
        "        return 0.0;",
        "    }",
        "}",
    ]


def test_godot_is_told_how_textures_are_filtered(build: ModuleType) -> None:
    writer = build.CLike("godot", {})
    assert writer.written("uniform mipmapped sampler2D a, b;  // two").splitlines() == [
        "uniform sampler2D a : filter_linear_mipmap, repeat_disable;",
        "uniform sampler2D b : filter_linear_mipmap, repeat_disable;  // two",
    ]
