# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""shaders/radtex_shared.glsl on a real OpenGL, over EGL, against the shared layout's reference sampler."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import moderngl
import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.core.frame import normalised
from radtex_addon.core.shared import SharedAtlas
from radtex_addon.formats.containers.exr import read_pixels
from radtex_addon.formats.image_files import layer_path
from radtex_addon.formats.packing import pack
from radtex_addon.formats.shared_files import read_shared, write_shared
from tests.lookups import SIDE, Lookups, relative_error
from tests.real.opengl import VERSIONS, compiled, drawn
from tests.shared_atlases import facts_about, random_shared_atlas
from tests.shared_lookups import random_fragments, shared_answers, shared_hit_answers

SHADER = Path(__file__).parents[2] / "shaders" / "radtex_shared.glsl"
WIDTH, HEIGHT = 7, 5
WORST = 2e-3  # between cells that differ 400-fold: the reference in float32 is as far off, 7e-4
FRAGMENT = """
uniform sampler2D colour, irradiance, surroundings, uvs, normals, viewers;
uniform sampler2D mirror_ends, mirror_gain, mirror_rest, through_ends, through_gain, through_rest;
uniform vec3 falloff[RADTEX_FALLOFF];
uniform ivec2 around;
uniform int n;
uniform bool traced;
out vec4 result;
void main() {
    ivec2 here = ivec2(gl_FragCoord.xy);
    vec2 uv = texelFetch(uvs, here, 0).xy;
    vec3 N = texelFetch(normals, here, 0).xyz, V = texelFetch(viewers, here, 0).xyz;
    vec3 light = traced
        ? radtex_shared_hit(colour, irradiance, falloff, mirror_ends, mirror_gain, mirror_rest,
            through_ends, through_gain, through_rest, n, surroundings, around, uv, N, -V)
        : radtex_shared(colour, irradiance, falloff, mirror_ends, mirror_gain, mirror_rest,
            through_ends, through_gain, through_rest, n, surroundings, around, uv, N, V);
    result = vec4(light, 1.0);
}
"""


def run(
    context: moderngl.Context,
    head: str,
    atlas: SharedAtlas,
    images: Mapping[str, Floats],
    fragments: Lookups,
    traced: bool = False,
) -> Floats:
    """The shader's answers, (K, 3) float32; `head` is a version and defines; by rays if `traced`."""
    program = compiled(context, head, SHADER.read_text(encoding="utf-8") + FRAGMENT)
    program["traced"] = traced
    program["n"] = atlas.lobes[0].ends.shape[2]
    program["around"] = (len(atlas.surroundings[0]), len(atlas.surroundings))
    program["falloff"] = [tuple(point) for point in atlas.falloff.tolist()]
    normal, viewer = (normalised(vectors) for vectors in (fragments.normal, fragments.viewer))
    inputs = {"uvs": fragments.uv, "normals": normal, "viewers": viewer}
    fields = {name: values.reshape(SIDE, SIDE, -1) for name, values in inputs.items()}
    return drawn(context, program, dict(images) | fields, SIDE)[:, :3]


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize(
    ("bucket", "surroundings", "levels"), [(6, 48, 5), (1, 8, 1), (3, 50, 2), (8, 192, 6)]
)
def test_glsl_agrees_with_the_reference(
    context: moderngl.Context, version: str, bucket: int, surroundings: int, levels: int
) -> None:
    atlas = random_shared_atlas(WIDTH, HEIGHT, bucket=bucket, surroundings=surroundings, levels=levels)
    fragments = random_fragments(WIDTH, HEIGHT)
    result = run(context, VERSIONS[version], atlas, pack(atlas), fragments)
    error = relative_error(result, shared_answers(atlas, fragments))
    print(f"{version}, n {bucket}, {levels} levels from {surroundings}: worst error {error.max():.1e}")
    assert np.median(error) <= 5e-6
    assert np.quantile(error, 0.999) <= 5e-5
    assert error.max() <= WORST


@pytest.mark.parametrize("version", VERSIONS)
def test_rays_find_what_the_reference_does(context: moderngl.Context, version: str) -> None:
    atlas, fragments = random_shared_atlas(WIDTH, HEIGHT), random_fragments(WIDTH, HEIGHT)
    result = run(context, VERSIONS[version], atlas, pack(atlas), fragments, traced=True)
    error = relative_error(result, shared_hit_answers(atlas, fragments))
    print(f"{version} rays: worst error {error.max():.1e}, median {np.median(error):.1e}")
    assert np.median(error) <= 5e-6
    assert error.max() <= WORST


def test_glsl_shows_the_files(context: moderngl.Context, tmp_path: Path) -> None:
    """Half floats as they are stored, uploaded as they are read."""
    path, fragments = tmp_path / "Vase.radiance.json", random_fragments(WIDTH, HEIGHT)
    wanted = random_shared_atlas(WIDTH, HEIGHT)
    sidecar = write_shared(path, wanted, facts_about(wanted))
    images = {
        layer: read_pixels(layer_path(path, layer), width, height, [channels])
        for layer, (width, height, channels) in sidecar.shapes.items()
    }
    stored, _ = read_shared(path)
    result = run(context, VERSIONS["GLSL 330"], stored, images, fragments)
    assert relative_error(result, shared_answers(stored, fragments)).max() <= WORST
    assert np.median(relative_error(result, shared_answers(wanted, fragments))) <= 2e-3


def test_one_hardware_lookup_is_as_good_as_its_weights(context: moderngl.Context) -> None:
    """The reference with its weights rounded to 1/256 has a median of 0.2 %; 1 % are beyond 1.7 %."""
    atlas, fragments = random_shared_atlas(WIDTH, HEIGHT), random_fragments(WIDTH, HEIGHT)
    head = VERSIONS["GLSL 330"] + "#define RADTEX_HARDWARE_LINEAR\n"
    result = run(context, head, atlas, pack(atlas), fragments)
    error = relative_error(result, shared_answers(atlas, fragments))
    print(f"hardware: median error {np.median(error):.1e}, worst {error.max():.1e}")
    assert np.median(error) <= 5e-3
    assert np.quantile(error, 0.99) <= 5e-2
