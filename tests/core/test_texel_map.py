# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The texel raster against per-texel loops, and the promises that the bake and the shaders lean on."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from radtex_addon.core.arrays import Floats, Ints
from radtex_addon.core.errors import ShapeError
from radtex_addon.core.moved_points import moved_points
from radtex_addon.core.surface import SurfaceMesh
from radtex_addon.core.texel_map import TexelMap, rasterise

CLOSE = 1e-5  # texels: wider than the raster's own slack


def surface_of(uv: Floats, position: Floats | None = None, normal: Floats | None = None) -> SurfaceMesh:
    """Loose triangles with `uv` (F, 3, 2); without positions the mesh lies in its UV plane, z = 0."""
    count = len(uv)
    corner = np.concatenate([uv, np.zeros((count, 3, 1))], axis=-1) if position is None else position
    up = np.broadcast_to([0.0, 0.0, 1.0], (count, 3, 3)) if normal is None else normal
    return SurfaceMesh(
        position=corner.reshape(-1, 3),
        triangles=np.arange(3 * count).reshape(count, 3),
        normal=up,
        tangent=np.broadcast_to([1.0, 0.0, 0.0], (count, 3, 3)),
        sign=np.ones((count, 3)),
        uv=uv,
    )


def grid(
    columns: int, rows: int, x0: float = 0.0, y0: float = 0.0, x1: float = 1.0, y1: float = 1.0
) -> Floats:
    """UVs (F, 3, 2) of a grid of squares, cut along their rising diagonals."""
    x, y = np.linspace(x0, x1, columns + 1), np.linspace(y0, y1, rows + 1)
    point = np.stack(np.meshgrid(x, y), axis=-1)
    a, b, c, d = point[:-1, :-1], point[:-1, 1:], point[1:, 1:], point[1:, :-1]
    return np.stack([np.stack([a, b, c], axis=-2), np.stack([a, c, d], axis=-2)], axis=2).reshape(-1, 3, 2)


def touches(corners: Floats, centre: Floats, reach: float) -> bool:
    """Whether a triangle (3, 2) and an axis-aligned square have a point in common: no axis parts them."""
    edges = np.roll(corners, -1, axis=0) - corners
    axes = np.concatenate([np.eye(2), edges[:, ::-1] * (1, -1)])
    along, middle, half = corners @ axes.T, axes @ centre, reach * np.abs(axes).sum(axis=1)
    return bool(((along.min(axis=0) <= middle + half) & (along.max(axis=0) >= middle - half)).all())


def nearest_in_triangle(corners: Floats, point: Floats) -> tuple[float, Floats]:
    """Distance to the nearest point of a triangle (3, 2), and that point."""
    edges = np.roll(corners, -1, axis=0) - corners
    to_point = point - corners
    cross = edges[:, 0] * to_point[:, 1] - edges[:, 1] * to_point[:, 0]
    if (cross >= 0).all() or (cross <= 0).all():
        return 0.0, point
    along = np.clip((to_point * edges).sum(axis=1) / (edges**2).sum(axis=1), 0, 1)
    candidates = corners + along[:, None] * edges
    distances = np.hypot(*(candidates - point).T)
    return float(distances.min()), candidates[distances.argmin()]


def reference(uv: Floats, width: int, height: int, reach: float, slack: float) -> tuple[Floats, Floats]:
    """Nearest distance (H, W), infinite where nothing touches, and the triangle's nearest point (H, W, 2)."""
    distance, point = np.full((height, width), np.inf), np.zeros((height, width, 2))
    corners = uv * (width, height)
    for j in range(height):
        for i in range(width):
            centre = np.array([i + 0.5, j + 0.5])
            for triangle in corners:
                if not touches(triangle, centre, reach + slack):
                    continue
                here, nearest = nearest_in_triangle(triangle, centre)
                if here < distance[j, i]:
                    distance[j, i], point[j, i] = here, nearest
    return distance, point


def assert_same(one: TexelMap, other: TexelMap) -> None:
    for field in fields(TexelMap):
        np.testing.assert_array_equal(
            getattr(one, field.name), getattr(other, field.name), err_msg=field.name
        )


@pytest.mark.parametrize("reach", [0.5, 1.0])
@pytest.mark.parametrize("seed", range(12))
def test_random_triangles_agree_with_a_loop_over_all_texels(seed: int, reach: float) -> None:
    rng = np.random.default_rng(seed)
    width, height = int(rng.integers(1, 14)), int(rng.integers(1, 14))
    size = rng.choice([0.05, 0.3, 1.5])
    uv = rng.uniform(-0.2, 1.2, (6, 1, 2)) + size * rng.uniform(-1, 1, (6, 3, 2))
    texels = rasterise(surface_of(uv), width, height, reach)
    surely, _ = reference(uv, width, height, reach, -CLOSE)
    perhaps, _ = reference(uv, width, height, reach, CLOSE)
    assert texels.covered[np.isfinite(surely)].all()
    assert not texels.covered[np.isinf(perhaps)].any()
    same = texels.covered & (np.isfinite(surely) == np.isfinite(perhaps)) & (surely == perhaps)
    assert same.sum() >= 0.95 * texels.covered.sum()
    np.testing.assert_array_equal(texels.inside[same], surely[same] == 0)
    centre = np.stack(np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5), axis=-1)
    away = np.linalg.norm(texels.position[..., :2] * (width, height) - centre, axis=-1)
    np.testing.assert_allclose(away[same], surely[same], atol=2e-5)


@pytest.mark.parametrize("seed", range(6))
def test_the_position_is_the_nearest_point_of_the_chosen_triangle(seed: int) -> None:
    rng = np.random.default_rng(100 + seed)
    uv = rng.uniform(0, 1, (8, 3, 2))
    texels = rasterise(surface_of(uv), 16, 9)
    for j, i in np.argwhere(texels.covered):
        centre = np.array([i + 0.5, j + 0.5])
        _, nearest = nearest_in_triangle(uv[texels.triangle[j, i]] * (16, 9), centre)
        np.testing.assert_allclose(texels.position[j, i, :2] * (16, 9), nearest, atol=1e-5)


coordinate = st.one_of(
    st.floats(0, 1),
    st.sampled_from([5e-324, 2.2e-313, 1e-170, 1e-20, 1 - 2**-53]),
    st.integers(0, 16).map(lambda k: k / 16),
    st.integers(0, 40).map(lambda k: float(np.float32(k / 40))),
)


@settings(max_examples=300, deadline=None)
@given(
    st.lists(st.lists(st.tuples(coordinate, coordinate), min_size=3, max_size=3), min_size=1, max_size=5),
    st.integers(1, 40),
    st.integers(1, 40),
    st.integers(0, 2**32 - 1),
)
def test_every_point_of_every_triangle_looks_up_a_covered_texel(
    corners: list[list[tuple[float, float]]], width: int, height: int, seed: int
) -> None:
    uv = np.array(corners)
    edges = uv[:, 1:] - uv[:, :1]
    uv = uv[np.abs(edges[:, 0, 0] * edges[:, 1, 1] - edges[:, 0, 1] * edges[:, 1, 0]) > 1e-12]
    covered = rasterise(surface_of(uv), width, height).covered
    weight = np.random.default_rng(seed).dirichlet([0.5, 0.5, 0.5], (max(len(uv), 1), 50))
    weight = np.concatenate([np.broadcast_to(np.eye(3), (len(weight), 3, 3)), weight], axis=1)[: len(uv)]
    point = np.einsum("fkc,fcx->fkx", weight, uv).reshape(-1, 2)
    i = np.minimum((point[:, 0] * width).astype(int), width - 1)
    j = np.minimum((point[:, 1] * height).astype(int), height - 1)
    assert covered[j, i].all()


@pytest.mark.parametrize("chunk", [1, 2, 7, 64, 1000])
def test_chunks_change_no_bit(chunk: int) -> None:
    rng = np.random.default_rng(3)
    uv = np.concatenate([rng.uniform(-0.1, 1.1, (20, 3, 2)), grid(4, 4), grid(4, 4)])
    surface = surface_of(uv, rng.normal(size=(len(uv), 3, 3)), rng.normal(size=(len(uv), 3, 3)))
    assert_same(rasterise(surface, 19, 23, chunk=chunk), rasterise(surface, 19, 23))


def test_the_order_of_a_triangles_corners_changes_nothing_that_is_seen() -> None:
    rng = np.random.default_rng(4)
    uv = rng.uniform(0, 1, (30, 3, 2))
    surface = surface_of(uv)
    turned = replace(surface, uv=uv[:, [2, 0, 1]], triangles=surface.triangles[:, [2, 0, 1]])
    mirrored = replace(surface, uv=uv[:, [1, 0, 2]], triangles=surface.triangles[:, [1, 0, 2]])
    expected = rasterise(surface, 20, 20)
    for other in (turned, mirrored):
        actual = rasterise(other, 20, 20)
        np.testing.assert_array_equal(actual.triangle, expected.triangle)
        np.testing.assert_array_equal(actual.inside, expected.inside)
        np.testing.assert_allclose(actual.position, expected.position, atol=1e-6)
        np.testing.assert_array_equal(actual.facet, expected.facet)


def test_centres_on_shared_edges_belong_to_one_triangle_and_none_falls_between() -> None:
    """Sheared float32 grids put texel centres on edges that rounding could open."""
    shear = np.array([[1.0, 0.3], [-0.2, 1.0]])
    uv = (grid(17, 13) @ shear * 0.6 + 0.1).astype(np.float32)
    texels = rasterise(surface_of(uv), 64, 64)
    outline = np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) @ shear * 0.6 + 0.1
    x, y = np.meshgrid((np.arange(64) + 0.5) / 64, (np.arange(64) + 0.5) / 64)
    edges = np.roll(outline, -1, axis=0) - outline
    margin = np.min(
        [(e[0] * (y - a[1]) - e[1] * (x - a[0])) / np.hypot(*e) for a, e in zip(outline, edges, strict=True)],
        axis=0,
    )
    assert texels.inside[margin > 1e-6].all()
    assert not texels.inside[margin < -1e-6].any()


def test_a_triangle_around_the_centre_comes_first_and_then_the_order() -> None:
    uv = np.array([[[0, 0], [0.2, 0], [0, 0.2]], [[0.25, 0.25], [1, 0.3], [0.3, 1]]])
    texels = rasterise(surface_of(uv), 1, 1)
    assert texels.triangle[0, 0] == 1
    assert texels.inside[0, 0]
    twice = rasterise(surface_of(np.concatenate([grid(1, 1), grid(1, 1)])), 8, 8)
    assert set(np.unique(twice.triangle)) <= {0, 1}


def test_long_thin_diagonals_cost_only_what_they_touch() -> None:
    """Their bounding boxes hold a thousand million texels, they touch three million."""
    shift = np.linspace(0, 1e-3, 1000)[:, None]
    low, high = shift * (0, 1), 1 - shift * (1, 0)
    uv = np.stack([low, high, high + np.array([0, 1e-7])], axis=1)
    texels = rasterise(surface_of(uv), 1024, 1024)
    assert 1024 <= texels.covered.sum() < 8 * 1024
    offset = np.abs(np.subtract(*np.nonzero(texels.covered)))
    assert offset.max() <= 2


def test_what_lies_outside_the_unit_square_is_clipped_away() -> None:
    uv = np.array(
        [[[-5, -5], [9, -5], [-5, 9.0]], [[1.5, 0.5], [2, 0.5], [2, 1]], [[-1e30, 0], [1e30, 0], [0, 1e30]]]
    )
    texels = rasterise(surface_of(uv[:2]), 8, 8)
    assert texels.inside.all()
    assert (texels.triangle == 0).all()
    assert rasterise(surface_of(uv[1:2]), 8, 8).covered.sum() == 0
    assert rasterise(surface_of(uv[2:]), 8, 8).covered.all()


def test_triangles_without_area_or_with_broken_uvs_are_skipped() -> None:
    uv = np.array(
        [
            [[0.1, 0.1], [0.5, 0.5], [0.9, 0.9]],
            [[0.3, 0.3], [0.3, 0.3], [0.3, 0.3]],
            [[np.nan, 0], [1, 0], [1, 1]],
            [[np.inf, 0], [1, 0], [1, 1]],
            [[1e200, 0], [0, 1e200], [1, 1]],
        ]
    )
    texels = rasterise(surface_of(uv, np.zeros((5, 3, 3))), 8, 8)
    assert not texels.covered.any()
    assert not texels.inside.any()
    assert rasterise(surface_of(np.zeros((0, 3, 2))), 8, 8).covered.sum() == 0


def frame_surface(normal: Floats, tangent: Floats, position: Floats | None = None) -> SurfaceMesh:
    flat = surface_of(grid(1, 1), position)
    return replace(
        flat, normal=np.broadcast_to(normal, (2, 3, 3)), tangent=np.broadcast_to(tangent, (2, 3, 3))
    )


def test_frames_are_orthonormal_and_the_facet_stands_on_the_normals_side() -> None:
    rng = np.random.default_rng(6)
    uv = grid(6, 6)
    surface = replace(
        surface_of(uv, rng.normal(size=(len(uv), 3, 3)), rng.normal(size=(len(uv), 3, 3))),
        tangent=rng.normal(size=(len(uv), 3, 3)),
        sign=np.repeat(rng.choice([-1.0, 1.0], (len(uv), 1)), 3, axis=1),
    )
    texels = rasterise(surface, 40, 30)
    for field in (texels.normal, texels.tangent, texels.facet):
        np.testing.assert_allclose(np.linalg.norm(field, axis=-1), 1, atol=1e-6)
        assert field.dtype == np.float32
    np.testing.assert_allclose(np.sum(texels.normal * texels.tangent, axis=-1), 0, atol=1e-6)
    assert np.sum(texels.normal * texels.facet, axis=-1).min() >= -1e-6
    np.testing.assert_array_equal(texels.sign, surface.sign[texels.triangle, 0])
    corner = surface.corner_position[texels.triangle]
    offset = texels.position - corner[..., 0, :]
    np.testing.assert_allclose(np.sum(offset * texels.facet, axis=-1), 0, atol=1e-5)


def test_normals_are_interpolated_then_normalised() -> None:
    surface = surface_of(np.array([[[0, 0], [1, 0], [0, 1.0]]]), normal=np.eye(3)[None])
    texels = rasterise(surface, 3, 3)
    u, v = 0.5, 1 / 6  # of texel (1, 0)'s centre
    weight = np.array([1 - u - v, u, v])
    np.testing.assert_allclose(texels.normal[0, 1], weight / np.linalg.norm(weight), atol=1e-6)


def test_opposite_normals_that_cancel_give_way_to_the_facet() -> None:
    normal = np.array([[[0, 0, 1], [0, 0, -1], [0, 0, 1.0]]])
    uv = np.array([[[0, 0.5], [1, 0.5], [0.5, 2.5]]])
    texels = rasterise(surface_of(uv, normal=normal), 1, 1)
    np.testing.assert_allclose(np.abs(texels.normal[0, 0]), [0, 0, 1], atol=1e-6)
    assert np.isfinite(texels.tangent).all()


def test_facets_and_tangents_where_there_is_none_or_another() -> None:
    along, shaded = np.array([0, 0, 1.0]), np.array([0, 0.6, 0.8])
    texels = rasterise(frame_surface(along, along), 2, 2)
    np.testing.assert_allclose(texels.tangent, np.broadcast_to([0, -1.0, 0], (2, 2, 3)), atol=1e-7)
    line = np.broadcast_to(np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0.0]]), (2, 3, 3))
    texels = rasterise(frame_surface(shaded, np.array([1.0, 0, 0]), line), 4, 4)
    np.testing.assert_allclose(texels.facet, texels.normal)
    texels = rasterise(frame_surface(-along, np.array([1.0, 0, 0])), 2, 2)  # shaded as the front
    np.testing.assert_allclose(texels.facet, np.broadcast_to([0, 0, -1.0], (2, 2, 3)))


def test_arrays_that_do_not_fit_are_refused() -> None:
    surface = surface_of(grid(1, 1))
    wrong: Ints = surface.triangles[:1]
    with pytest.raises(ShapeError, match=r"normal.*\(1, 3, 3\)"):
        rasterise(replace(surface, triangles=wrong), 4, 4)
    with pytest.raises(ShapeError, match="0 x 4"):
        rasterise(surface, 0, 4)


def test_points_move_by_a_step_in_uv_but_stay_in_their_triangles() -> None:
    uv = grid(5, 5)
    turn = np.array([[0, 0, 1.0], [2, 0, 0]])  # u upwards, v along x and twice as long
    surface = surface_of(uv, position=uv @ turn)
    texels = rasterise(surface, 32, 32)
    triangle, point = texels.triangle.ravel(), texels.position.reshape(-1, 3).astype(np.float64)
    step = (0.3 / 32, -0.2 / 32)
    moved = moved_points(surface, triangle, point, step)
    middle = np.stack(np.meshgrid(*[(np.arange(32) + 0.5) / 32] * 2), axis=-1).reshape(-1, 2)
    corners = uv[triangle]
    aim = middle + step
    sides = np.roll(corners, -1, axis=1) - corners
    away = aim[:, None] - corners
    inside = (sides[..., 0] * away[..., 1] - sides[..., 1] * away[..., 0] > 0).all(axis=1)
    assert 0.7 < inside.mean() < 1
    np.testing.assert_allclose(moved[inside], (aim @ turn)[inside], atol=1e-5)
    back = np.stack([moved[:, 2], moved[:, 0] / 2], axis=1)
    around = back[:, None] - corners
    area = sides[..., 0] * around[..., 1] - sides[..., 1] * around[..., 0]
    assert area.min() > -1e-6
    flat = surface_of(np.zeros((1, 3, 2)))
    kept = moved_points(flat, np.zeros(3, np.int32), np.ones((3, 3)), step)
    np.testing.assert_array_equal(kept, 1)
