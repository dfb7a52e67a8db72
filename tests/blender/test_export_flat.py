# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The flat lightmap: means that are known."""

from __future__ import annotations

import io
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from radtex_addon.bake.progress import finished
from radtex_addon.core.arrays import Floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.hemisphere import cell_centres, cell_solid_angles_sr, square_to_direction
from radtex_addon.core.surface import SurfaceMesh
from radtex_addon.core.texel_map import TexelMap, rasterise
from radtex_addon.formats.codecs.srgb import to_srgb
from radtex_addon.forms.layered.capture.panoramas import panorama_directions
from radtex_addon.forms.layered.lookup.atlas import LayeredAtlas
from radtex_addon.forms.layered.lookup.environment import Around, Pictures
from radtex_addon.forms.layered.textures import mean_of_layered
from radtex_addon.textures.flat_lightmap import even_directions, flat_png, mean_of_buckets
from tests.layered.made_up import made_up_atlas

pytestmark = pytest.mark.one_blender


def one_cell(bucket: int, q: int, p: int) -> Floats:
    """An atlas of 2 x 1 texels whose first has one bright cell."""
    layout = AtlasLayout(2, 1, bucket)
    buckets = np.zeros((1, 2, bucket, bucket, 4), dtype=np.float16)
    buckets[0, 0, q, p] = (1, 2, 4, 1)
    return layout.from_buckets(buckets)


@pytest.mark.parametrize("bucket", [1, 4, 5])
def test_a_cell_weighs_its_solid_angle(bucket: int) -> None:
    solid_angle = cell_solid_angles_sr(bucket)
    for q, p in np.ndindex(bucket, bucket):
        light = mean_of_buckets(one_cell(bucket, q, p), AtlasLayout(2, 1, bucket))
        share = solid_angle[q, p] / (2 * np.pi)
        np.testing.assert_allclose(light[0, 0], share * np.array([1, 2, 4, 1]), rtol=1e-5)
        assert not light[0, 1].any()


def test_the_mean_of_the_cosine_is_a_half() -> None:
    layout = AtlasLayout(1, 1, 32)
    cosine = square_to_direction(cell_centres(32))[..., 2:]
    image = layout.from_buckets(np.broadcast_to(cosine, (1, 1, 32, 32, 1)).astype(np.float32))
    light = mean_of_buckets(image, layout)
    assert light.shape == (1, 1, 3)
    np.testing.assert_allclose(light, 0.5, atol=2e-3)


def test_directions_share_the_hemisphere_evenly() -> None:
    directions = even_directions(64)
    np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1, atol=1e-12)
    np.testing.assert_allclose(directions.mean(axis=0), [0, 0, 0.5], atol=1e-2)
    second = directions.T @ directions / 64
    np.testing.assert_allclose(second, np.eye(3) / 3, atol=1e-2)


def square(normal: tuple[float, float, float] = (0, 0, 1)) -> TexelMap:
    """A square from (0, 0) to (1, 1) in the lower left quarter of 8 x 8 texels."""
    corner = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], dtype=np.float64)
    triangles = np.array([[0, 1, 2], [0, 2, 3]])
    surface = SurfaceMesh(
        position=np.column_stack([corner, np.zeros(4)]),
        triangles=triangles,
        normal=np.broadcast_to(np.array(normal, dtype=np.float64), (2, 3, 3)),
        tangent=np.broadcast_to(np.array([1.0, 0, 0]), (2, 3, 3)),
        sign=np.ones((2, 3)),
        uv=(corner / 2)[triangles].astype(np.float32),
    )
    return rasterise(surface, 8, 8)


def lit_from_above() -> LayeredAtlas:
    """Light from above, white, that a mirror shows; and no other light."""
    atlas = made_up_atlas(8, 48)
    direction = panorama_directions(96)
    up = np.broadcast_to(direction[..., 2:] > 0, direction.shape).astype(np.float32)
    around = Around(atlas.around.middle, Pictures.of(direction, up, 48), (), ())
    steps = atlas.materials[0]
    sharp, weight = np.full_like(steps.variance, 1e-6), np.full_like(steps.weight, 0.5)
    mirror = replace(steps, weight=weight, variance=sharp, bend=np.zeros_like(steps.bend))
    own = np.zeros_like(atlas.own)
    own[..., 3] = 1
    return replace(
        atlas,
        colour=np.zeros_like(atlas.colour),
        around=around,
        materials=(mirror,),
        own=own,
        rest=np.zeros_like(atlas.rest),
    )


def mean_on(atlas: LayeredAtlas, texels: TexelMap) -> Floats:
    """The mean light of texels that are all of the first material."""
    material = np.zeros(np.count_nonzero(texels.covered), dtype=np.intp)
    return finished(mean_of_layered(atlas, texels, material))


def test_the_layered_layout_is_seen_from_all_around() -> None:
    atlas = lit_from_above()
    seen = mean_on(atlas, square())
    np.testing.assert_allclose(seen, 1, atol=0.03)  # mirrored views go up, and the gutter is filled
    below = mean_on(atlas, square((0, 0, -1)))
    np.testing.assert_allclose(below, 0, atol=0.02)
    tilted = mean_on(atlas, square((0, -1, 1e-9)))
    np.testing.assert_allclose(tilted, 0.5, atol=0.03)


def test_diffuse_light_is_colour_times_irradiance() -> None:
    atlas = lit_from_above()
    dark = replace(atlas.materials[0], weight=np.zeros_like(atlas.materials[0].weight))
    even = replace(
        atlas,
        colour=np.full_like(atlas.colour, 0.5),
        irradiance=np.full_like(atlas.irradiance, 3),
        falloff=np.full_like(atlas.falloff, 0.25),
        materials=(dark,),
    )
    np.testing.assert_allclose(mean_on(even, square()), 0.375, rtol=1e-5)


def test_the_picture_is_srgb_and_its_top_row_is_v_1() -> None:
    light = np.zeros((2, 3, 3), dtype=np.float32)
    light[0, 0] = (0.5, 0.2140, 1)  # v = 0: the bottom
    data, scale = flat_png(light)
    assert scale == 1
    shown = np.asarray(Image.open(io.BytesIO(data)))
    assert shown[1, 0].tolist() == [188, 127, 255]
    assert shown.sum() == 188 + 127 + 255


def test_what_is_clear_keeps_its_alpha_and_its_colour() -> None:
    light = np.zeros((1, 3, 4), dtype=np.float32)
    light[0, 0] = (0.25, 0.107, 0.5, 0.5)  # premultiplied: half of what is above
    light[0, 1] = (0.5, 0.2140, 1, 1)
    data, scale = flat_png(light)
    assert scale == 1
    shown = np.asarray(Image.open(io.BytesIO(data)))
    assert shown[0].tolist() == [[188, 127, 255, 128], [188, 127, 255, 255], [0, 0, 0, 0]]


def test_light_beyond_white_is_scaled_but_for_a_few_texels() -> None:
    light = np.full((20, 20, 3), 4.0, dtype=np.float32)
    light[0, 0] = 1000
    data, scale = flat_png(light)
    assert scale == pytest.approx(0.25)
    assert np.asarray(Image.open(io.BytesIO(data))).min() == 255
    np.testing.assert_allclose(
        to_srgb(np.array([0.0, 0.002, 0.18, 1, 3])), [0, 0.02584, 0.46136, 1, 1], atol=1e-5
    )
