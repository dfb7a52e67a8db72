# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""shaders/radtex_condensed.wgsl by wgpu, on a real Vulkan, against the shared layout's reference sampler."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.core.condensed import CondensedAtlas
from radtex_addon.core.frame import normalised
from radtex_addon.formats.containers.dds import DdsFormat, read_dds
from radtex_addon.formats.shared_files import read_condensed, write_condensed
from tests.condensed_textures import COLUMNS, Ranges, doubts, pixels, rows_of, uncompressed
from tests.lookups import SIDE, Lookups, relative_error
from tests.real.root import Root
from tests.real.webgpu import Resource, Sampler, Texture, blocks, drawn, fields, image
from tests.shared_atlases import facts_about, random_condensed_atlas
from tests.shared_lookups import by_ray, random_fragments, shared_answers, shared_hit_answers

SHADERS = [Path(__file__).parents[2] / "shaders" / f"radtex_{name}.wgsl" for name in ("shared", "condensed")]
WIDTH, HEIGHT = 7, 5
WORST = 2e-3  # as far off as radtex_shared.glsl may be
BC5_PRECISION = 2.01 / 255  # of Mesa's llvmpipe, which mixes levels in eight bits
BLOCKS = {
    DdsFormat.BC5_UNORM: "bc5-rg-unorm",
    DdsFormat.BC6H_UF16: "bc6h-rgb-ufloat",
    DdsFormat.BC7_UNORM: "bc7-rgba-unorm",
}
LAYERS = [
    *("colour", "irradiance", "surroundings"),
    *("mirror_weights", "mirror_ends_xy", "mirror_ends_zs", "mirror_gain", "mirror_rest"),
    *("through_weights", "through_ends_xy", "through_ends_zs", "through_gain", "through_rest"),
]
FRAGMENT = """
struct Settings { fine: vec2i, texels: vec2i, around: vec2i, columns: i32, n: i32 }
@group(0) @binding(0) var<uniform> s: Settings;
@group(0) @binding(1) var<uniform> falloff: RadtexFalloff;
@group(0) @binding(2) var<uniform> mirror_ranges: RadtexRanges;
@group(0) @binding(3) var<uniform> through_ranges: RadtexRanges;
@group(0) @binding(4) var filtering: sampler;
@group(0) @binding(5) var fields: texture_2d_array<f32>;
@fragment fn main(@builtin(position) at: vec4f) -> @location(0) vec4f {
    let here = vec2i(at.xy);
    let uv = textureLoad(fields, here, 0, 0).xy;
    let N = textureLoad(fields, here, 1, 0).xyz;
    let V = textureLoad(fields, here, 2, 0).xyz;
    return vec4f(LOOKUP, 1.0);
}
""" + "".join(f"@group(0) @binding({6 + k}) var {LAYERS[k]}: texture_2d<f32>;\n" for k in range(len(LAYERS)))
LOOKUP = """radtex_condensed(colour, s.fine, irradiance, s.texels, filtering, falloff,
        mirror_weights, mirror_ends_xy, mirror_ends_zs, mirror_gain, mirror_rest, mirror_ranges,
        through_weights, through_ends_xy, through_ends_zs, through_gain, through_rest, through_ranges,
        s.columns, s.n, surroundings, s.around, uv, N, V)"""
FETCH = """
@group(0) @binding(0) var picture: texture_2d<f32>;
@fragment fn main(@builtin(position) at: vec4f) -> @location(0) vec4f {
    return textureLoad(picture, vec2i(at.xy), 0);
}
"""


def run(
    root: Root,
    atlas: CondensedAtlas,
    images: Mapping[str, Floats | Texture],
    ranges: Ranges,
    columns: int,
    fragments: Lookups,
    *,
    hardware: bool = False,
    traced: bool = False,
) -> Floats:
    """The shader's answers, (K, 3) float32, by rays if `traced`; `ranges` are each lobe's (12, 4)."""
    normal, viewer = (normalised(vectors) for vectors in (fragments.normal, fragments.viewer))
    sizes = [*atlas.colour.shape[1::-1], *atlas.irradiance.shape[1::-1]]
    around = [len(atlas.surroundings[0]), len(atlas.surroundings)]
    resources: dict[int | str, Resource] = {
        "s": np.array([*sizes, *around, columns, atlas.lobes[0].ends.shape[2]], np.int32),
        "falloff": np.pad(atlas.falloff, ((0, 0), (0, 1))),
        "filtering": Sampler("linear"),
        "fields": fields(SIDE, fragments.uv, normal, viewer),
    }
    resources |= {f"{axis}_ranges": rows for axis, rows in ranges.items()}
    for name, values in images.items():
        resources[name] = values if isinstance(values, Texture) else image(values)
    code = "".join(path.read_text(encoding="utf-8") for path in SHADERS)
    code = code.replace("RADTEX_RANK: i32 = 2;", f"RADTEX_RANK: i32 = {atlas.lobes[0].rank};")
    constants = {"RADTEX_HARDWARE_LINEAR": float(hardware)}
    fragment = FRAGMENT.replace("LOOKUP", by_ray(LOOKUP) if traced else LOOKUP)
    return drawn(root, code + fragment, resources, SIDE, constants=constants)[:, :3]


@pytest.mark.parametrize(("clusters", "rank", "bucket"), [(4, 2, 14), (1, 2, 2), (9, 6, 6), (1000, 2, 2)])
def test_wgsl_agrees_with_the_reference(root: Root, clusters: int, rank: int, bucket: int) -> None:
    atlas = random_condensed_atlas(WIDTH, HEIGHT, clusters, rank, bucket)
    fragments = random_fragments(WIDTH, HEIGHT)
    result = run(root, atlas, *uncompressed(atlas), COLUMNS, fragments)
    error = relative_error(result, shared_answers(atlas.expanded(), fragments))
    doubt = doubts(atlas, fragments)
    sure = doubt <= WORST
    print(
        f"{clusters} clusters of rank {rank}, n {bucket}: worst error {error[sure].max():.1e};"
        f" at {np.sum(~sure)} lookups that rounding moves further than {WORST}, {error.max():.1e}"
    )
    assert np.median(error) <= 5e-6
    assert np.quantile(error, 0.99) <= 1e-4
    assert (error <= np.maximum(doubt, WORST)).all()
    assert np.mean(sure) >= 0.99


def test_rays_find_what_the_reference_does(root: Root) -> None:
    atlas, fragments = random_condensed_atlas(WIDTH, HEIGHT), random_fragments(WIDTH, HEIGHT)
    result = run(root, atlas, *uncompressed(atlas), COLUMNS, fragments, traced=True)
    error = relative_error(result, shared_hit_answers(atlas.expanded(), fragments))
    print(f"rays: worst error {error.max():.1e}, median {np.median(error):.1e}")
    assert np.median(error) <= 5e-6
    assert (error <= np.maximum(doubts(atlas, fragments), WORST)).all()


def test_one_hardware_lookup_is_as_good_as_its_weights(root: Root) -> None:
    atlas, fragments = random_condensed_atlas(WIDTH, HEIGHT), random_fragments(WIDTH, HEIGHT)
    result = run(root, atlas, *uncompressed(atlas), COLUMNS, fragments, hardware=True)
    error = relative_error(result, shared_answers(atlas.expanded(), fragments))
    print(f"hardware: median error {np.median(error):.1e}, worst {error.max():.1e}")
    assert np.median(error) <= 5e-3
    assert np.quantile(error, 0.99) <= 5e-2


def test_wgsl_shows_the_files(root: Root, tmp_path: Path) -> None:
    """The files' blocks, which the driver decodes as the reader does; BC5's levels to its own precision."""
    path, fragments = tmp_path / "Vase.radiance.json", random_fragments(WIDTH, HEIGHT)
    wanted = random_condensed_atlas(WIDTH, HEIGHT)
    write_condensed(path, wanted, facts_about(wanted))
    atlas, sidecar = read_condensed(path)
    facts = sidecar.condensed
    assert facts is not None
    ranges = {axis: rows_of(tiles.ranges) for axis, tiles in facts.lobes.items()}
    decoded: dict[str, Floats] = {}
    textures: dict[str, Texture] = {}
    for layer in sidecar.shapes:
        kind, data, *size = read_dds(path.with_name(f"Vase.radiance.{layer}.dds"))
        decoded[layer] = pixels(kind, data)
        width, height = size
        textures[layer] = (
            blocks(BLOCKS[kind], (width, height), data.tobytes()) if kind in BLOCKS else image(data)
        )
        if kind is DdsFormat.BC5_UNORM:
            levels = drawn(root, FETCH, {"picture": textures[layer]}, max(size)).reshape(*[max(size)] * 2, 4)
            levels = levels[:height, :width, :2]
            np.testing.assert_allclose(levels, decoded[layer], atol=BC5_PRECISION)
            decoded[layer] = levels
    read = run(root, atlas, decoded, ranges, facts.columns, fragments)
    shown = run(root, atlas, textures, ranges, facts.columns, fragments)
    apart = relative_error(shown, read)
    print(f"driver and reader {apart.max():.1e} apart")
    assert apart.max() <= 1e-4
