# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Unwraps fit the atlas and keep islands apart; a UV layer of the user's own is taken or refused."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.core.arrays import Bools
from radtex_addon.core.errors import InputError
from radtex_addon.core.islands import find_overlap, signed_areas, surface_areas, uv_islands
from radtex_addon.core.surface import SurfaceMesh
from radtex_addon.core.texel_map import rasterise
from radtex_addon.scene.mesh.evaluated import EvaluatedMesh
from radtex_addon.scene.uv.unwrap import estimate_seconds
from radtex_addon.scene.uv.unwrap_options import AtlasUnwrap, UnwrapOptions
from radtex_addon.scene.uv.uv_layer import user_uv
from radtex_addon.settings.spec import Unwrap as Method
from tests.blender.stage import read, unwrapped

context: Any = bpy.context  # to the stubs, every pointer may be None
METHODS = (Method.UVUNWRAP, Method.XATLAS, Method.BLENDER)
Unwrap = Callable[[EvaluatedMesh, int, UnwrapOptions], AtlasUnwrap]
ALL = pytest.mark.parametrize(
    "unwrap", [partial(unwrapped, method=method) for method in METHODS], ids=METHODS
)


def head() -> EvaluatedMesh:
    bpy.ops.mesh.primitive_monkey_add()
    context.object.data.shade_smooth()
    return read(context.object)


def cube() -> EvaluatedMesh:
    bpy.ops.mesh.primitive_cube_add()
    return read(context.object)


def coverage(evaluated: EvaluatedMesh, done: AtlasUnwrap, reach: float) -> Bools:
    """For every island on its own, the texels that lie within `reach` of it: (islands, H, W)."""
    island = uv_islands(evaluated.triangles, done.uv)
    blank = np.zeros((len(evaluated.triangles), 3, 3))
    covered = []
    for number in range(int(island.max()) + 1):
        part = island == number
        surface = SurfaceMesh(
            position=evaluated.world_position,
            triangles=evaluated.triangles[part],
            normal=blank[part] + (0, 0, 1),
            tangent=blank[part] + (1, 0, 0),
            sign=np.ones((np.count_nonzero(part), 3)),
            uv=done.uv[part],
        )
        covered.append(rasterise(surface, done.width, done.height, reach).covered)
    return np.array(covered)


@ALL
@pytest.mark.parametrize("texels", [72, pytest.param(301, marks=pytest.mark.one_blender)])
def test_the_longer_side_is_what_was_asked_for(unwrap: Unwrap, texels: int) -> None:
    evaluated = head()
    done = unwrap(evaluated, texels, UnwrapOptions())
    assert max(done.width, done.height) == texels
    assert done.uv.shape == (len(evaluated.triangles), 3, 2)
    assert 0 <= done.uv.min() < done.uv.max() <= 1
    assert done.overlap == find_overlap(done.uv).fraction < 0.01  # Smart UV Project may fold an island
    assert done.islands == int(uv_islands(evaluated.triangles, done.uv).max()) + 1
    assert done.utilisation <= 1
    area = np.abs(signed_areas(done.uv * [done.width, done.height])).sum()
    nominal = evaluated_area(evaluated) * done.density**2
    assert nominal * (0.93 if texels > 300 else 0.6) < area < 1.01 * nominal  # sides lie on texels' centres
    assert done.utilisation == pytest.approx(area / (done.width * done.height))


def evaluated_area(evaluated: EvaluatedMesh) -> float:
    return float(surface_areas(evaluated.world_position[evaluated.triangles]).sum())


@pytest.mark.one_blender
@ALL
@pytest.mark.parametrize("padding", [0, 2])
def test_padding_lies_free_between_islands(unwrap: Unwrap, padding: int) -> None:
    """No texel is within `padding` of two islands; at 0, still no bilinear lookup reads two of them."""
    evaluated = head()
    done = unwrap(evaluated, 160, UnwrapOptions(padding=padding))
    touched = coverage(evaluated, done, reach=0.5)
    assert touched.sum(axis=0).max() == 1
    # xatlas lays borders through the centres of texels: exactly 1 away, a texel's weight is 0.
    read = coverage(evaluated, done, reach=0.999)
    assert read.sum(axis=0).max() == 1
    grown = touched.copy()
    for _ in range(padding):
        wide = np.pad(grown, ((0, 0), (1, 1), (1, 1)))
        grown = np.any(
            [wide[:, y : y + done.height, x : x + done.width] for y in range(3) for x in range(3)], axis=0
        )
    reached_by_others = grown.sum(axis=0)[None] - grown
    assert not (touched & (reached_by_others > 0)).any()


@pytest.mark.one_blender
@ALL
def test_density_sets_the_size(unwrap: Unwrap) -> None:
    evaluated = cube()  # six faces of 2 x 2 units
    done = unwrap(evaluated, 64, UnwrapOptions(density=30))
    assert (done.width % 4, done.height % 4, done.needed) == (0, 0, 0)
    areas = np.abs(signed_areas(done.uv * [done.width, done.height]))
    assert areas == pytest.approx(np.full(12, 60 * 60 / 2), rel=0.04)
    assert done.width * done.height > 6 * 60 * 60


@pytest.mark.one_blender
@ALL
def test_texels_are_as_dense_everywhere_in_the_world(unwrap: Unwrap) -> None:
    """Scale, also uneven and negative, counts."""
    bpy.ops.mesh.primitive_cube_add()
    context.object.scale = (0.5, -2, 4)
    evaluated = read(context.object)
    done = unwrap(evaluated, 256, UnwrapOptions())
    texels = np.abs(signed_areas(done.uv * [done.width, done.height]))
    units = surface_areas(evaluated.world_position[evaluated.triangles])
    assert texels / units == pytest.approx(np.full(12, done.density**2), rel=0.05)


@pytest.mark.one_blender
@ALL
def test_size_in_the_scene_does_not_matter(unwrap: Unwrap) -> None:
    """xatlas by itself takes small triangles for nothing."""
    expected = unwrap(head(), 96, UnwrapOptions()).density
    for size in (1e-4, 1e5):
        bpy.ops.mesh.primitive_monkey_add(size=2 * size, location=(3 * size, 0, 0))
        context.object.data.shade_smooth()
        density = unwrap(read(context.object), 96, UnwrapOptions()).density
        assert density * size == pytest.approx(expected, rel=0.25), size


@pytest.mark.one_blender
def test_a_smooth_surface_is_few_islands_and_a_cube_is_six() -> None:
    bpy.ops.mesh.primitive_uv_sphere_add()
    context.object.data.shade_smooth()
    assert unwrapped(read(context.object), 128).islands <= 8
    assert unwrapped(cube(), 128).islands == 6
    assert unwrapped(head(), 128).islands <= 70


@pytest.mark.one_blender
def test_sharp_edges_part_islands_and_soft_ones_do_not() -> None:
    bpy.ops.mesh.primitive_cylinder_add(
        vertices=8
    )  # flat faces that meet at 45 degrees, a quarter circle fits
    flat = read(context.object)
    assert unwrapped(flat, 64, UnwrapOptions(seam_angle=60)).islands < 10
    assert unwrapped(flat, 64, UnwrapOptions(seam_angle=30)).islands == 10


@pytest.mark.one_blender
def test_doubled_vertices_do_not_tear_islands() -> None:
    bpy.ops.mesh.primitive_uv_sphere_add(segments=16, ring_count=8)
    item = context.object
    item.data.shade_smooth()
    whole = unwrapped(read(item), 64)
    item.modifiers.new("split", "EDGE_SPLIT").split_angle = 0
    torn = read(item)
    assert len(torn.position) > 3 * 100
    assert unwrapped(torn, 64, UnwrapOptions(seam_angle=180)).islands == whole.islands


def awkward() -> EvaluatedMesh:
    """Triangles without area, a doubled face, an edge of three faces, a loose part far away, a needle."""
    mesh = bpy.data.meshes.new("awkward")
    points = [(0.0, 0.0, 0.0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0.5, 0, 0), (1, 0, 1)]
    points += [(90, 0, 0), (91, 0, 0), (90, 1, 0), (1, 1, 0), (5, 5, 5), (5, 5, 5), (5, 5, 5), (0, 0, 1e-7)]
    faces = [
        (0, 1, 2),
        (0, 2, 3),
        (0, 4, 1),
        (0, 1, 5),
        (6, 7, 8),
        (0, 2, 9),
        (10, 11, 12),
        (3, 2, 0),
        (0, 1, 13),
    ]
    mesh.from_pydata(points, [], faces)
    item = bpy.data.objects.new("awkward", mesh)
    context.scene.collection.objects.link(item)
    return read(item)


@ALL
def test_awkward_meshes_are_unwrapped_too(unwrap: Unwrap, caplog: pytest.LogCaptureFixture) -> None:
    evaluated = awkward()
    assert len(evaluated.triangles) == 9
    done = unwrap(evaluated, 200, UnwrapOptions())
    assert np.isfinite(done.uv).all()
    assert 0 <= done.uv.min() < done.uv.max() <= 1
    thin = surface_areas(evaluated.world_position[evaluated.triangles]) < 1e-6
    assert thin.sum() == 4
    assert np.abs(signed_areas(done.uv[thin])).max() < 1e-9
    assert np.ptp(done.uv[thin], axis=1).max() < 1e-9
    assert np.abs(signed_areas(done.uv[~thin])).min() > 1e-4


@pytest.mark.one_blender
@ALL
def test_a_surface_without_area_is_refused(unwrap: Unwrap) -> None:
    bpy.ops.mesh.primitive_cube_add()
    for vertex in context.object.data.vertices:
        vertex.co = (1, 2, 3)
    with pytest.raises(InputError, match=r"object 'Cube' has faces, but no area to unwrap: give it a size"):
        unwrap(read(context.object), 64, UnwrapOptions())


@pytest.mark.one_blender
@ALL
def test_too_few_texels_for_the_islands_are_refused(unwrap: Unwrap) -> None:
    evaluated = head()
    with pytest.raises(InputError, match=r"8 texels are too few for the \d+ islands .* at least \d+ texels"):
        unwrap(evaluated, 8, UnwrapOptions())


@pytest.mark.one_blender
@pytest.mark.parametrize(
    "wrong", [{"padding": -1}, {"density": 0.0}, {"density": float("nan")}, {"iterations": (0,)}]
)
def test_impossible_options_are_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(InputError, match=r"must be .*, not"):
        UnwrapOptions(**wrong)


@pytest.mark.one_blender
def test_estimates_grow_with_the_mesh_and_follow_the_options() -> None:
    counts = [10, 1_000, 16_000, 70_000, 1_000_000]
    seconds = [estimate_seconds(count) for count in counts]
    assert seconds == sorted(seconds)
    assert seconds[0] < 1
    assert estimate_seconds(16_000, UnwrapOptions(iterations=(8,))) > estimate_seconds(
        16_000, UnwrapOptions(iterations=(1,))
    )


@pytest.mark.one_blender
def test_a_long_unwrap_is_announced(
    caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("radtex_addon.scene.uv.unwrap._LONG", 0.0)
    unwrapped(cube(), 32)
    assert "for the 12 triangles of 'Cube'; Blender's own unwrap takes seconds" in caplog.text


def test_blender_leaves_mode_and_selection_alone() -> None:
    bpy.ops.mesh.primitive_monkey_add()
    first = context.object
    evaluated = cube()
    second = context.object
    context.view_layer.objects.active = first
    first.select_set(True)
    bpy.ops.object.mode_set(mode="EDIT")
    before = [item.name for item in bpy.data.objects], first.mode, second.mode, context.selected_objects
    unwrapped(evaluated, 64, method=Method.BLENDER)
    assert before == (
        [item.name for item in bpy.data.objects],
        first.mode,
        second.mode,
        context.selected_objects,
    )
    assert context.mode == "EDIT_MESH"
    assert len(bpy.data.scenes) == 1
    assert len(bpy.data.meshes) == 2


def grid() -> Any:
    """Sixteen squares over the unit square of the layer 'UVMap'."""
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=4, y_subdivisions=4)
    return context.object


def move(item: Any, loops: slice, scale: float = 1, shift: tuple[float, float] = (0, 0)) -> None:
    layer = item.data.uv_layers[0].uv
    flat = np.empty(2 * len(layer), dtype=np.float32)
    layer.foreach_get("vector", flat)
    uv = flat.reshape(-1, 2)
    uv[loops] = uv[loops] * scale + np.array(shift, dtype=np.float32)
    layer.foreach_set("vector", flat)


def test_a_good_layer_is_taken_as_it_is(caplog: pytest.LogCaptureFixture) -> None:
    evaluated = read(grid())
    assert np.array_equal(user_uv(evaluated, "UVMap"), evaluated.uv("UVMap"))
    assert caplog.text == ""


def test_modifiers_are_seen() -> None:
    """Mirror lays one half over the other."""
    item = grid()
    item.modifiers.new("mirror", "MIRROR").use_axis = (False, False, True)
    for vertex in item.data.vertices:
        vertex.co.z = 1
    with pytest.raises(
        InputError, match=r"UV layer 'UVMap' of object 'Grid' overlaps in 100\.00% of its area"
    ):
        user_uv(read(item), "UVMap")


def test_a_missing_layer_is_answered_with_those_there_are() -> None:
    item = grid()
    item.data.uv_layers.new(name="lightmap")
    with pytest.raises(
        InputError, match=r"object 'Grid' has no UV layer 'Lightmap' .* choose 'UVMap' or 'lightmap'"
    ):
        user_uv(read(item), "Lightmap")
    for layer in list(item.data.uv_layers):
        item.data.uv_layers.remove(layer)
    with pytest.raises(InputError, match=r"leave the UV layer out to have one made"):
        user_uv(read(item), "Lightmap")


def test_a_sliver_without_area_passes_with_a_warning(caplog: pytest.LogCaptureFixture) -> None:
    item = grid()
    corners = item.data.polygons[0].vertices
    for index in corners:
        item.data.vertices[index].co = item.data.vertices[corners[0]].co
    move(item, slice(0, 4), scale=0)
    user_uv(read(item), "UVMap")
    assert "gives no area to 2 of 32 triangles" in caplog.text


def test_a_little_overlap_passes_with_a_warning(caplog: pytest.LogCaptureFixture) -> None:
    item = grid()
    move(item, slice(0, 4), shift=(0.003, 0))
    user_uv(read(item), "UVMap")
    assert "those texels show one of the places" in caplog.text


def test_rounding_beyond_the_border_is_clipped() -> None:
    item = grid()
    move(item, slice(None), shift=(2e-6, -2e-6))
    uv = user_uv(read(item), "UVMap")
    assert uv.min() == 0
    assert uv.max() == 1


def test_coordinates_that_are_not_finite() -> None:
    item = grid()
    item.data.uv_layers[0].uv[3].vector = (float("nan"), 0)
    with pytest.raises(
        InputError, match=r"UV layer 'UVMap' of object 'Grid' has coordinates that are not finite"
    ):
        user_uv(read(item), "UVMap")


@pytest.mark.parametrize(
    ("moves", "words"),
    [
        ([(slice(None), 0, (0, 0))], r"of object 'Grid' is empty \(no triangle has area\)"),
        (
            [(slice(0, 4), 0, (0, 0))],
            r"gives no area to 2 of 32 triangles, 6\.\d% of the surface: unwrap those",
        ),
        (  # the first square on top of that at (0.25, 0.25) .. (0.375, 0.375)
            [(slice(None), 0.5, (0, 0)), (slice(0, 4), 1, (0.25, 0.25))],
            r"overlaps in 6\.6\d% of its area, worst at uv \(0\.(2[5-9]|3).*\), 2 tri",
        ),
        *(
            ([(slice(None), 1, shift)], r"reaches outside 0\.\.1, from \(.*\) to \(.*\): pack its islands")
            for shift in ((0.3, 0), (0, -0.01), (1, 0))
        ),
    ],
)
def test_a_layer_that_cannot_be_used_says_why(moves: list[Any], words: str) -> None:
    item = grid()
    for loops, scale, shift in moves:
        move(item, loops, scale, shift)
    with pytest.raises(InputError, match=rf"UV layer 'UVMap' .*{words}"):
        user_uv(read(item), "UVMap")
