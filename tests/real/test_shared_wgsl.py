# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""shaders/radtex_shared.wgsl by wgpu, on a real Vulkan, against the shared layout's reference sampler."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

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
from tests.real.root import Root
from tests.real.webgpu import Resource, Sampler, drawn, fields, image
from tests.shared_atlases import facts_about, random_shared_atlas
from tests.shared_lookups import by_ray, random_fragments, shared_answers, shared_hit_answers

SHADER = Path(__file__).parents[2] / "shaders" / "radtex_shared.wgsl"
WIDTH, HEIGHT = 7, 5
WORST = 2e-3  # as far off as radtex_shared.glsl may be
FRAGMENT = """
struct Settings { around: vec2i, n: i32 }
@group(0) @binding(0) var<uniform> s: Settings;
@group(0) @binding(1) var<uniform> falloff: RadtexFalloff;
@group(0) @binding(2) var filtering: sampler;
@group(0) @binding(3) var fields: texture_2d_array<f32>;
@group(0) @binding(4) var colour: texture_2d<f32>;
@group(0) @binding(5) var irradiance: texture_2d<f32>;
@group(0) @binding(6) var surroundings: texture_2d<f32>;
@group(0) @binding(7) var mirror_ends: texture_2d<f32>;
@group(0) @binding(8) var mirror_gain: texture_2d<f32>;
@group(0) @binding(9) var mirror_rest: texture_2d<f32>;
@group(0) @binding(10) var through_ends: texture_2d<f32>;
@group(0) @binding(11) var through_gain: texture_2d<f32>;
@group(0) @binding(12) var through_rest: texture_2d<f32>;
@fragment fn main(@builtin(position) at: vec4f) -> @location(0) vec4f {
    let here = vec2i(at.xy);
    let uv = textureLoad(fields, here, 0, 0).xy;
    let N = textureLoad(fields, here, 1, 0).xyz;
    let V = textureLoad(fields, here, 2, 0).xyz;
    return vec4f(%s, 1.0);
}
"""
LOOKUP = """radtex_shared(colour, irradiance, filtering, falloff, mirror_ends, mirror_gain, mirror_rest,
        through_ends, through_gain, through_rest, s.n, surroundings, s.around, uv, N, V)"""


def run(
    root: Root,
    atlas: SharedAtlas,
    images: Mapping[str, Floats],
    fragments: Lookups,
    *,
    hardware: bool = False,
    traced: bool = False,
) -> Floats:
    """The shader's answers, (K, 3) float32, by rays if `traced`."""
    normal, viewer = (normalised(vectors) for vectors in (fragments.normal, fragments.viewer))
    settings = [len(atlas.surroundings[0]), len(atlas.surroundings), atlas.lobes[0].ends.shape[2], 0]
    resources: dict[int | str, Resource] = {
        "s": np.array(settings, np.int32),
        "falloff": np.pad(atlas.falloff, ((0, 0), (0, 1))),
        "filtering": Sampler("linear"),
        "fields": fields(SIDE, fragments.uv, normal, viewer),
    }
    resources |= {name: image(values) for name, values in images.items()}
    constants = {"RADTEX_HARDWARE_LINEAR": float(hardware)}
    code = SHADER.read_text(encoding="utf-8") + FRAGMENT % (by_ray(LOOKUP) if traced else LOOKUP)
    return drawn(root, code, resources, SIDE, constants=constants)[:, :3]


@pytest.mark.parametrize(
    ("bucket", "surroundings", "levels"), [(6, 48, 5), (1, 8, 1), (3, 50, 2), (8, 192, 6)]
)
def test_wgsl_agrees_with_the_reference(root: Root, bucket: int, surroundings: int, levels: int) -> None:
    atlas = random_shared_atlas(WIDTH, HEIGHT, bucket=bucket, surroundings=surroundings, levels=levels)
    fragments = random_fragments(WIDTH, HEIGHT)
    error = relative_error(run(root, atlas, pack(atlas), fragments), shared_answers(atlas, fragments))
    print(f"n {bucket}, {levels} levels from {surroundings}: worst error {error.max():.1e}")
    assert np.median(error) <= 5e-6
    assert np.quantile(error, 0.999) <= 5e-5
    assert error.max() <= WORST


def test_rays_find_what_the_reference_does(root: Root) -> None:
    atlas, fragments = random_shared_atlas(WIDTH, HEIGHT), random_fragments(WIDTH, HEIGHT)
    result = run(root, atlas, pack(atlas), fragments, traced=True)
    error = relative_error(result, shared_hit_answers(atlas, fragments))
    print(f"rays: worst error {error.max():.1e}, median {np.median(error):.1e}")
    assert np.median(error) <= 5e-6
    assert error.max() <= WORST


def test_wgsl_shows_the_files(root: Root, tmp_path: Path) -> None:
    """Half floats as they are stored, uploaded as they are read."""
    path, fragments = tmp_path / "Vase.radiance.json", random_fragments(WIDTH, HEIGHT)
    wanted = random_shared_atlas(WIDTH, HEIGHT)
    sidecar = write_shared(path, wanted, facts_about(wanted))
    images = {
        layer: read_pixels(layer_path(path, layer), width, height, [channels])
        for layer, (width, height, channels) in sidecar.shapes.items()
    }
    stored, _ = read_shared(path)
    error = relative_error(run(root, stored, images, fragments), shared_answers(stored, fragments))
    print(f"files: worst error {error.max():.1e}")
    assert error.max() <= WORST


def test_one_hardware_lookup_is_as_good_as_its_weights(root: Root) -> None:
    """The reference with its weights rounded to 1/256 has a median of 0.2 %; 1 % are beyond 1.7 %."""
    atlas, fragments = random_shared_atlas(WIDTH, HEIGHT), random_fragments(WIDTH, HEIGHT)
    result = run(root, atlas, pack(atlas), fragments, hardware=True)
    error = relative_error(result, shared_answers(atlas, fragments))
    print(f"hardware: median error {np.median(error):.1e}, worst {error.max():.1e}")
    assert np.median(error) <= 5e-3
    assert np.quantile(error, 0.99) <= 5e-2
