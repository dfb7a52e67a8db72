# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""shaders/radtex_condensed.glsl on a real OpenGL, over EGL, against the shared layout's reference sampler."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import moderngl
import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.core.condensed import CondensedAtlas
from radtex_addon.core.frame import normalised
from radtex_addon.formats.codecs.bc7 import Blocks
from radtex_addon.formats.containers.dds import DdsFormat, read_dds
from radtex_addon.formats.shared_files import read_condensed, write_condensed
from tests.condensed_textures import COLUMNS, Ranges, pixels, rows_of, uncompressed
from tests.lookups import SIDE, Lookups, relative_error
from tests.real.opengl import BC5_UNORM, BC6H_UF16, BC7_UNORM, VERSIONS, compiled, compressed, drawn, fetched
from tests.shared_atlases import facts_about, random_condensed_atlas
from tests.shared_lookups import random_fragments, shared_answers, shared_hit_answers

SHADERS = [Path(__file__).parents[2] / "shaders" / f"radtex_{name}.glsl" for name in ("shared", "condensed")]
WIDTH, HEIGHT = 7, 5
WORST = 2e-3  # as far off as radtex_shared.glsl may be
BC5_PRECISION = 2.01 / 255  # of Mesa's llvmpipe, which mixes levels in eight bits
FRAGMENT = """
uniform sampler2D colour, irradiance, surroundings, uvs, normals, viewers;
uniform sampler2D mirror_weights, mirror_ends_xy, mirror_ends_zs, mirror_gain, mirror_rest;
uniform sampler2D through_weights, through_ends_xy, through_ends_zs, through_gain, through_rest;
uniform vec4 mirror_ranges[12], through_ranges[12];
uniform vec3 falloff[RADTEX_FALLOFF];
uniform ivec2 fine, texels, around;
uniform int columns, n;
uniform bool traced;
out vec4 result;
void main() {
    ivec2 here = ivec2(gl_FragCoord.xy);
    vec2 uv = texelFetch(uvs, here, 0).xy;
    vec3 N = texelFetch(normals, here, 0).xyz, V = texelFetch(viewers, here, 0).xyz;
    vec3 light = traced
        ? radtex_condensed_hit(colour, fine, irradiance, texels, falloff,
            mirror_weights, mirror_ends_xy, mirror_ends_zs, mirror_gain, mirror_rest, mirror_ranges,
            through_weights, through_ends_xy, through_ends_zs, through_gain, through_rest, through_ranges,
            columns, n, surroundings, around, uv, N, -V)
        : radtex_condensed(colour, fine, irradiance, texels, falloff,
            mirror_weights, mirror_ends_xy, mirror_ends_zs, mirror_gain, mirror_rest, mirror_ranges,
            through_weights, through_ends_xy, through_ends_zs, through_gain, through_rest, through_ranges,
            columns, n, surroundings, around, uv, N, V);
    result = vec4(light, 1.0);
}
"""


def run(
    context: moderngl.Context,
    head: str,
    atlas: CondensedAtlas,
    images: Mapping[str, Floats | moderngl.Texture],
    ranges: Ranges,
    columns: int,
    fragments: Lookups,
    traced: bool = False,
) -> Floats:
    """The shader's answers, (K, 3) float32; by rays if `traced`.

    `head` is a version and defines, `ranges` each lobe's (12, 4).
    """
    code = "".join(path.read_text(encoding="utf-8") for path in SHADERS)
    program = compiled(context, head + f"#define RADTEX_RANK {atlas.lobes[0].rank}\n", code + FRAGMENT)
    program["traced"] = traced
    program["n"], program["columns"] = atlas.lobes[0].ends.shape[2], columns
    program["fine"], program["texels"] = (image.shape[1::-1] for image in (atlas.colour, atlas.irradiance))
    program["around"] = (len(atlas.surroundings[0]), len(atlas.surroundings))
    program["falloff"] = [tuple(point) for point in atlas.falloff.tolist()]
    for axis, rows in ranges.items():
        program[f"{axis}_ranges"] = [tuple(row) for row in rows.tolist()]
    normal, viewer = (normalised(vectors) for vectors in (fragments.normal, fragments.viewer))
    inputs = {"uvs": fragments.uv, "normals": normal, "viewers": viewer}
    fields = {name: values.reshape(SIDE, SIDE, -1) for name, values in inputs.items()}
    return drawn(context, program, {**images, **fields}, SIDE)[:, :3]


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize(("clusters", "rank", "bucket"), [(4, 2, 14), (1, 2, 2), (9, 6, 6), (1000, 2, 2)])
def test_glsl_agrees_with_the_reference(
    context: moderngl.Context, version: str, clusters: int, rank: int, bucket: int
) -> None:
    atlas = random_condensed_atlas(WIDTH, HEIGHT, clusters, rank, bucket)
    fragments = random_fragments(WIDTH, HEIGHT)
    result = run(context, VERSIONS[version], atlas, *uncompressed(atlas), COLUMNS, fragments)
    error = relative_error(result, shared_answers(atlas.expanded(), fragments))
    print(f"{version}, {clusters} clusters of rank {rank}, n {bucket}: worst error {error.max():.1e}")
    assert np.median(error) <= 5e-6
    assert np.quantile(error, 0.99) <= 1e-4
    assert error.max() <= WORST


@pytest.mark.parametrize("version", VERSIONS)
def test_rays_find_what_the_reference_does(context: moderngl.Context, version: str) -> None:
    atlas, fragments = random_condensed_atlas(WIDTH, HEIGHT), random_fragments(WIDTH, HEIGHT)
    result = run(context, VERSIONS[version], atlas, *uncompressed(atlas), COLUMNS, fragments, traced=True)
    error = relative_error(result, shared_hit_answers(atlas.expanded(), fragments))
    print(f"{version} rays: worst error {error.max():.1e}, median {np.median(error):.1e}")
    assert np.median(error) <= 5e-6
    assert error.max() <= WORST


def test_one_hardware_lookup_is_as_good_as_its_weights(context: moderngl.Context) -> None:
    atlas, fragments = random_condensed_atlas(WIDTH, HEIGHT), random_fragments(WIDTH, HEIGHT)
    head = VERSIONS["GLSL 330"] + "#define RADTEX_HARDWARE_LINEAR\n"
    result = run(context, head, atlas, *uncompressed(atlas), COLUMNS, fragments)
    error = relative_error(result, shared_answers(atlas.expanded(), fragments))
    print(f"hardware: median error {np.median(error):.1e}, worst {error.max():.1e}")
    assert np.median(error) <= 5e-3
    assert np.quantile(error, 0.99) <= 5e-2


@pytest.mark.parametrize("version", VERSIONS)
def test_glsl_shows_the_files(context: moderngl.Context, tmp_path: Path, version: str) -> None:
    """The files' blocks, which the driver decodes as the reader does; BC5's levels to its own precision.

    Where an octahedron's border is looked up the reader knows better: blocks change a border's pixels and the
    cells that these repeat, each in its own way.
    """
    path, fragments = tmp_path / "Vase.radiance.json", random_fragments(WIDTH, HEIGHT)
    wanted = random_condensed_atlas(WIDTH, HEIGHT)
    write_condensed(path, wanted, facts_about(wanted))
    atlas, sidecar = read_condensed(path)
    expected = shared_answers(atlas.expanded(), fragments)
    same = run(context, VERSIONS[version], atlas, *uncompressed(atlas), COLUMNS, fragments)
    assert relative_error(same, expected).max() <= WORST

    facts = sidecar.condensed
    assert facts is not None
    ranges = {axis: rows_of(tiles.ranges) for axis, tiles in facts.lobes.items()}
    files = {layer: read_dds(path.with_name(f"Vase.radiance.{layer}.dds")) for layer in sidecar.shapes}
    decoded = {layer: pixels(kind, blocks) for layer, (kind, blocks, *_) in files.items()}
    textures = {layer: uploaded(context, *file) for layer, file in files.items()}
    read = run(context, VERSIONS[version], atlas, decoded, ranges, facts.columns, fragments)
    error = relative_error(read, expected)
    for layer, (kind, _, *size) in files.items():
        if kind is DdsFormat.BC5_UNORM:
            levels = fetched(context, textures[layer], *size)[..., :2]
            np.testing.assert_allclose(levels, decoded[layer], atol=BC5_PRECISION)
            decoded[layer] = levels
    read = run(context, VERSIONS[version], atlas, decoded, ranges, facts.columns, fragments)
    shown = run(context, VERSIONS[version], atlas, textures, ranges, facts.columns, fragments)
    apart = relative_error(shown, read).max()
    print(f"{version}: driver and reader {apart:.1e} apart, {np.mean(error > WORST):.1%} meet borders")
    assert apart <= 1e-4
    assert np.quantile(error, 0.6) <= WORST


def uploaded(
    context: moderngl.Context, kind: DdsFormat, blocks: Blocks, width: int, height: int
) -> moderngl.Texture:
    """What a file holds as a texture, as a game would upload it."""
    if kind is DdsFormat.R8G8B8A8_UNORM:
        return context.texture((width, height), 4, blocks.tobytes())
    kinds = {
        DdsFormat.BC5_UNORM: BC5_UNORM,
        DdsFormat.BC6H_UF16: BC6H_UF16,
        DdsFormat.BC7_UNORM: BC7_UNORM,
    }
    return compressed(context, kinds[kind], (width, height), blocks.tobytes())
