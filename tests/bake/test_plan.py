# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The plan packs every covered texel once, in the atlas's order, into an image that Blender can render."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from radtex_addon.bake import plan as module
from radtex_addon.bake.plan import CapturePlan, Tile, plan_capture, sheet_seed
from radtex_addon.core.arrays import Bools, Floats
from radtex_addon.core.errors import InputError
from radtex_addon.core.texel_map import TexelMap


def texel_map(covered: Bools, seed: int = 0) -> TexelMap:
    """Random points and frames on the `covered` (H, W) texels, zeros elsewhere."""
    rng = np.random.default_rng(seed)
    height, width = covered.shape

    def unit() -> Floats:
        vectors = rng.normal(size=(height, width, 3))
        vectors /= np.linalg.norm(vectors, axis=-1, keepdims=True)
        return np.where(covered[..., None], vectors, 0).astype(np.float32)

    normal, facet = unit(), unit()
    tangent = np.cross(unit(), normal)
    tangent /= np.maximum(np.linalg.norm(tangent, axis=-1, keepdims=True), 1e-30)
    sign = np.where(covered, rng.choice([-1, 1], size=covered.shape), 0).astype(np.float32)
    triangle = np.where(covered, 7, -1).astype(np.int32)
    position = np.where(covered[..., None], rng.normal(size=(height, width, 3)), 0).astype(np.float32)
    return TexelMap(position, normal, tangent.astype(np.float32), sign, facet, triangle, covered)


def some_covered(height: int = 9, width: int = 14) -> Bools:
    covered = np.random.default_rng(3).random((height, width)) < 0.4
    covered[-1, -1] = True
    return covered


def flat(plan: CapturePlan, name: str) -> Floats:
    """One of the plan's fields, without the padding of the last row."""
    field: Floats = getattr(plan, name).reshape(-1, 3)[: len(plan.texel)]
    return field


def test_every_covered_texel_is_captured_once_from_its_own_point_and_frame() -> None:
    covered = some_covered()
    texels = texel_map(covered)
    plan = plan_capture(texels, 4)
    assert plan.texel.tolist() == [int(k) for k in np.flatnonzero(covered)]
    assert (plan.layout.width, plan.layout.height, plan.layout.bucket) == (14, 9, 4)
    for name in ("position", "tangent", "bitangent", "normal", "facet"):  # which Cycles reads as images
        assert getattr(plan, name).dtype == np.float32
        assert getattr(plan, name).shape == (plan.rows, plan.columns, 3)
    np.testing.assert_array_equal(flat(plan, "position"), texels.position[covered])
    np.testing.assert_array_equal(flat(plan, "facet"), texels.facet[covered])
    np.testing.assert_allclose(flat(plan, "normal"), texels.normal[covered], atol=1e-6)
    np.testing.assert_allclose(flat(plan, "tangent"), texels.tangent[covered], atol=1e-6)
    bitangent = texels.sign[..., None] * np.cross(texels.normal, texels.tangent)
    np.testing.assert_allclose(flat(plan, "bitangent"), bitangent[covered], atol=1e-6)
    with pytest.raises(InputError, match="covers no texel"):
        plan_capture(texel_map(np.zeros((4, 4), dtype=bool)), 4)


def test_the_last_row_is_padded_with_the_last_texel_and_tiles_are_without_it() -> None:
    covered = np.zeros((8, 8), dtype=bool)
    covered.ravel()[:53] = True  # a prime number has no grid of its own
    plan = plan_capture(texel_map(covered), 2)
    spare = plan.rows * plan.columns - 53
    assert 0 < spare < plan.columns
    padding = plan.position.reshape(-1, 3)[53:]
    np.testing.assert_array_equal(padding, np.broadcast_to(flat(plan, "position")[-1], (spare, 3)))
    rows = [plan.texels_of(Tile(row, 1)) for row in range(plan.rows)]
    assert all(len(row) == plan.columns for row in rows[:-1])
    assert np.concatenate(rows).tolist() == plan.texel.tolist()
    assert plan.texels_of(Tile(0, plan.rows)).tolist() == plan.texel.tolist()


def test_texels_that_nobody_sees_are_left_out() -> None:
    covered = some_covered()
    texels = texel_map(covered)
    buried = np.flatnonzero(covered)[[0, 5, 6]]
    plan = plan_capture(texels, 4, without=buried)
    seen = np.setdiff1d(np.flatnonzero(covered), buried)
    assert plan.texel.tolist() == seen.tolist()
    np.testing.assert_array_equal(flat(plan, "position"), texels.position.reshape(-1, 3)[seen])


def test_values_lie_where_their_texels_lie() -> None:
    covered = some_covered()
    texels = texel_map(covered)
    plan = plan_capture(texels, 4)
    np.testing.assert_array_equal(plan.covered, covered)
    np.testing.assert_array_equal(plan.points, texels.position[covered])
    placed = plan.placed(plan.points)
    assert placed.dtype == np.float32
    np.testing.assert_array_equal(placed, texels.position)


def test_a_gutters_texel_has_what_the_nearest_one_has() -> None:
    covered = np.zeros((3, 5), dtype=bool)
    covered[1, 0] = covered[1, 4] = True
    plan = plan_capture(texel_map(covered), 4)
    marks = np.array([[True, False], [False, True]])
    placed = plan.placed(marks, gutter=True)
    assert placed.dtype == bool
    np.testing.assert_array_equal(placed, np.repeat(marks[[0, 0, 0, 1, 1]][None], 3, axis=0))


def test_sheets_are_as_large_as_was_asked_and_cut_tiles_and_fields() -> None:
    texels = texel_map(np.ones((40, 50), dtype=bool))
    plan = plan_capture(texels, 4, sheet=64)  # 16 x 16 buckets
    height = plan.sheet_rows
    assert plan.columns * 4 <= 64
    assert plan.columns * height <= 16 * 16
    assert plan.sheets == -(-plan.rows // height) == 8
    assert plan_capture(texels, 4).sheets == 1
    found = list(plan.in_sheets(Tile(height - 2, height + 3)))
    assert found == [(0, Tile(height - 2, 2)), (1, Tile(0, height)), (2, Tile(0, 1))]
    windows = np.concatenate([plan.window(plan.position, sheet) for sheet in range(plan.sheets)])
    np.testing.assert_array_equal(windows[: plan.rows], plan.position)
    behind = windows[plan.rows :]  # repeats the plan's last row
    np.testing.assert_array_equal(behind, np.broadcast_to(plan.position[-1], behind.shape))


def test_sheets_have_seeds_of_their_own() -> None:
    assert sheet_seed(7, 0) == 7
    seeds = {sheet_seed(seed, sheet) for seed in range(10) for sheet in range(1000)}
    assert len(seeds) == 10_000
    assert min(seeds) >= 0
    assert all(np.floor(np.float32(seed) + np.float32(0.5)) == seed for seed in seeds)  # as keyframes do


@given(count=st.integers(1, 20_000), bucket=st.integers(2, 256), sheet=st.integers(4, 4096))
def test_the_packed_image_wastes_little_and_a_single_sheet_is_near_square(
    count: int, bucket: int, sheet: int
) -> None:
    least = -(-module.MIN_IMAGE_SIDE // bucket)
    rows, columns = module._shape(count, bucket, sheet)
    assert columns <= max(least, sheet // bucket)
    assert rows * columns >= count
    assert rows == least or (rows - 1) * columns < count
    rows, columns = module._shape(count, bucket, module.MAX_IMAGE_SIDE)
    assert max(rows, columns) <= 5 * max(least, min(rows, columns))
    assert rows * columns - count <= 0.02 * count + 2 or rows == least
