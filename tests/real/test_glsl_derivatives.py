# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What shaders/radtex.glsl leaves to the hardware, on a real OpenGL: the level by derivatives, and slices."""

from __future__ import annotations

from pathlib import Path

import moderngl
import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.core.slices import to_slices
from tests.lookups import LAYOUT, SIDE, random_atlas, random_lookups, relative_error
from tests.real.opengl import VERSIONS, compiled, drawn, mipmapped
from tests.reference.slices import mip_chain, sample_slices

SHADER = Path(__file__).parents[2] / "shaders" / "radtex.glsl"
FRAGMENT = """
uniform highp sampler2DArray slices;
uniform sampler2D uvs, incidences;
uniform ivec2 texels;
uniform int n, mode;
out vec4 result;
void main() {
    ivec2 here = ivec2(gl_FragCoord.xy);
    vec2 uv = texelFetch(uvs, here, 0).xy;
    if (mode == 1) result = vec4(radtex_level(uv, texels, 4));
#if __VERSION__ >= 400
    else if (mode == 2) result = vec4(textureQueryLod(slices, uv).x);
#endif
    else result = radtex_slices(slices, n, uv, texelFetch(incidences, here, 0).xyz);
}
"""
SLICES, LEVEL, LEVEL_OF_HARDWARE = range(3)
QUERIES = "#version 400\n"
WORST = 2e-3
WIDEST = 5  # log2 of the widest pixel, in texels


def uvs_of_quads(axis: bool, whole: bool, seed: int = 4) -> tuple[Floats, Floats]:
    """Texture coordinates (SIDE, SIDE, 2) float32 and the level (SIDE, SIDE) of their derivatives.

    Hardware takes the derivatives from each quad of 2 x 2 pixels: each has its own. `axis`: along the axes
    of the texture, so that every measure of length agrees; `whole`: so that the levels are whole numbers.
    """
    rng = np.random.default_rng(seed)
    count, size = SIDE // 2, np.array([LAYOUT.width, LAYOUT.height])
    level = rng.uniform(-2, WIDEST, (count, count))
    level = np.round(level) if whole else level
    turn = (
        rng.integers(0, 4, (count, count)) * np.pi / 2 if axis else rng.uniform(0, 2 * np.pi, (count, count))
    )
    longer = np.exp2(level)[..., None] * np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    shorter = longer[..., ::-1] * [-1, 1] * rng.uniform(0, 0.9, (count, count, 1))
    swapped = rng.random((count, count, 1)) < 0.5
    across, up = np.where(swapped, shorter, longer), np.where(swapped, longer, shorter)
    base = rng.uniform(0, 1, (count, count, 2))
    base[:9] = (np.round(base[:9] * size) + rng.uniform(-2e-3, 2e-3, base[:9].shape)) / size  # seams, borders
    y, x = np.indices((SIDE, SIDE))
    grown = [np.repeat(np.repeat(values, 2, axis=0), 2, axis=1) for values in (base, across, up, level)]
    uv = grown[0] + ((x % 2)[..., None] * grown[1] + (y % 2)[..., None] * grown[2]) / size
    return uv.astype(np.float32), np.maximum(grown[3], 0)


def run(
    context: moderngl.Context, version: str, chain: list[Floats], uv: Floats, mode: int = SLICES
) -> Floats:
    """The shader's answers, (SIDE², 4) float32."""
    program = compiled(context, VERSIONS.get(version, version), SHADER.read_text(encoding="utf-8") + FRAGMENT)
    program["texels"], program["n"] = (LAYOUT.width, LAYOUT.height), LAYOUT.bucket
    program["mode"] = mode
    incidence = random_lookups().incidence.astype(np.float32).reshape(SIDE, SIDE, 3)
    slices = mipmapped(context, chain, moderngl.LINEAR_MIPMAP_LINEAR)
    return drawn(context, program, {"slices": slices, "uvs": uv, "incidences": incidence}, SIDE)


def half_slices() -> list[Floats]:
    return [level.astype(np.float16) for level in mip_chain(to_slices(random_atlas(), LAYOUT))]


def reference(chain: list[Floats], uv: Floats, level: Floats) -> Floats:
    exact = [values.astype(float) for values in chain]
    incidence = random_lookups().incidence.astype(np.float32).astype(float)
    return sample_slices(exact, uv.reshape(-1, 2).astype(float), incidence, level.ravel())


@pytest.mark.parametrize("version", VERSIONS)
def test_the_level_is_where_a_texel_is_as_wide_as_a_pixel(context: moderngl.Context, version: str) -> None:
    uv, level = uvs_of_quads(axis=False, whole=False)
    found = run(context, version, half_slices(), uv, LEVEL)[:, 0]
    np.testing.assert_allclose(found, np.minimum(level, 3).ravel(), atol=1e-4)


@pytest.mark.parametrize("version", VERSIONS)
def test_slices_agree_with_the_reference(context: moderngl.Context, version: str) -> None:
    uv, level = uvs_of_quads(axis=True, whole=True)
    chain = half_slices()
    error = relative_error(run(context, version, chain, uv), reference(chain, uv, level))
    print(f"{version} slices: worst error {error.max():.1e}, median {np.median(error):.1e}")
    assert error.max() <= WORST


def test_between_levels_slices_agree_at_the_level_that_the_hardware_takes(context: moderngl.Context) -> None:
    """Drivers are free to measure how wide a pixel is; this one says what it found."""
    uv, level = uvs_of_quads(axis=True, whole=False)
    chain = half_slices()
    result = run(context, QUERIES, chain, uv)
    taken = run(context, QUERIES, chain, uv, mode=LEVEL_OF_HARDWARE)[:, 0]
    off = np.abs(taken - np.clip(level, 0, len(chain) - 1).ravel())
    error = relative_error(result, reference(chain, uv, taken.astype(float)))
    print(f"worst error {error.max():.1e}; the hardware's level is off by {off.max():.3f} at most")
    assert error.max() <= WORST
    assert off.max() <= 0.1
