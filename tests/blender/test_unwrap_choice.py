# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Whose UVs a bake gets: the artist's own where they are fit, else few islands, none of two materials."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.bake.piece_store import NO_STORE
from radtex_addon.bake.progress import finished
from radtex_addon.core.arrays import Floats, Ints
from radtex_addon.core.islands import find_overlap, signed_areas, surface_areas, uv_islands, weld
from radtex_addon.formats.sidecar import read_sidecar
from radtex_addon.job import bake_object
from radtex_addon.prepare.unwrapping import Unwrapped, unwrap_surfaces
from radtex_addon.scene.mesh.evaluated import EvaluatedMesh, evaluate
from radtex_addon.scene.scratch import scratch_scene
from radtex_addon.scene.uv.unwrap import unwrap_steps
from radtex_addon.scene.uv.uv_layer import why_unfit
from radtex_addon.settings.spec import BakeSpec, Unwrap

pytestmark = pytest.mark.one_blender

context: Any = bpy.context  # to the stubs, every pointer may be None
TEXELS, PADDING = 64, 2


def quads(*places: tuple[float, float, float]) -> Any:
    """An object of upright squares, each with its lower left corner (u, v) and side in the UV layer."""
    mesh = bpy.data.meshes.new("Quads")
    square = np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
    points = [(x + 3 * k, 0.0, z) for k in range(len(places)) for x, z in square.tolist()]
    mesh.from_pydata(points, [], [tuple(range(4 * k, 4 * k + 4)) for k in range(len(places))])
    layer: Any = mesh.uv_layers.new(name="Mine")
    uv = np.concatenate([np.array([u, v]) + side * square for u, v, side in places])
    layer.data.foreach_set("uv", uv.ravel())
    item = bpy.data.objects.new("Quads", mesh)
    context.scene.collection.objects.link(item)
    return item


def read(item: Any) -> EvaluatedMesh:
    with scratch_scene(context.scene) as scratch:
        return evaluate(scratch, item)


@pytest.mark.parametrize(
    ("places", "why"),
    [
        ([(0, 0, 0.95)], None),
        ([(0, 0, 0.48), (0.52, 0, 0.48), (0, 0.52, 0.48)], None),
        ([(0, 0, 0.6)], "covers only 36%"),
        ([(0, 0, 0.9), (0.5, 0.5, 0.4)], "overlaps"),
        ([(0, 0, 0.75), (0.77, 0, 0.2)], "less than 2 of 64 texels apart"),
        ([(0.2, 0, 0.9)], "reaches outside"),
    ],
    ids=["whole", "apart", "mostly empty", "twice", "too close", "outside"],
)
def test_a_layer_is_fit_or_not_for_a_reason(
    places: list[tuple[float, float, float]], why: str | None
) -> None:
    found = why_unfit(read(quads(*places)), "Mine", TEXELS, PADDING)
    assert found is None if why is None else why in str(found)


def test_the_default_bakes_on_a_layer_that_is_fit_and_says_so(tmp_path: Path) -> None:
    quads((0, 0, 0.48), (0.52, 0, 0.48), (0, 0.52, 0.48))
    spec = BakeSpec(texels=TEXELS, bucket=2, samples=1)
    sidecar = read_sidecar(bake_object(context.scene, "Quads", spec, tmp_path / "fit").files.sidecar)
    assert (sidecar.uv_map, sidecar.islands) == ("Mine", 3)
    assert sidecar.coverage == pytest.approx(3 * 0.48**2, abs=1e-3)


def test_a_layer_that_is_not_fit_is_left_alone(tmp_path: Path) -> None:
    item = quads((0, 0, 0.3), (0, 0, 0.3))
    before = [tuple(corner.uv) for corner in item.data.uv_layers["Mine"].data]
    spec = BakeSpec(texels=TEXELS, bucket=2, samples=1)
    sidecar = read_sidecar(bake_object(context.scene, "Quads", spec, tmp_path / "new").files.sidecar)
    assert (sidecar.uv_map, sidecar.islands) == ("RadTex", 2)
    assert sidecar.coverage is not None
    assert sidecar.coverage > 0.6
    assert [tuple(corner.uv) for corner in item.data.uv_layers["Mine"].data] == before


def painted_ball() -> Any:
    """A ball in three colours, whose borders run through smooth faces."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=12)
    item = context.object
    for name in ("red", "green", "blue"):
        item.data.materials.append(bpy.data.materials.new(name))
    for face in item.data.polygons:
        face.material_index = 0 if face.center.z > 0.3 else 1 if face.center.x > 0 else 2
    item.data.shade_smooth()
    return item


@pytest.mark.parametrize("method", [Unwrap.UVUNWRAP, Unwrap.XATLAS, Unwrap.BLENDER])
def test_no_island_has_two_materials(method: Unwrap) -> None:
    mesh = read(painted_ball())
    made = finished(unwrap_steps(mesh, TEXELS, method))
    island = uv_islands(weld(mesh.position)[mesh.triangles], made.uv)
    pairs = np.unique(np.stack([island, mesh.material_index], axis=1), axis=0)
    assert len(pairs) == len(np.unique(island))


def bent_sheet() -> Any:
    """A sheet that is rolled up nearly all round: it can be flattened as it is, or in a few pieces."""
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=40, y_subdivisions=8, size=2)
    item = context.object
    for vertex in item.data.vertices:
        turn = 2.9 * vertex.co.x
        vertex.co.x, vertex.co.z = np.sin(turn), np.cos(turn)
    item.data.shade_smooth()
    return item


def long_strip() -> Any:
    """A narrow strip in a wide arc: as one island, it would leave most of its box empty."""
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=120, y_subdivisions=2, size=2)
    item = context.object
    for vertex in item.data.vertices:
        turn, radius = 2.8 * vertex.co.x, 5 + 0.2 * vertex.co.y
        vertex.co.x, vertex.co.y = radius * np.cos(turn), radius * np.sin(turn)
    return item


@pytest.mark.parametrize(("build", "islands"), [(bent_sheet, range(1, 4)), (long_strip, range(2, 30))])
def test_islands_are_merged_and_cut_where_that_helps(build: Callable[[], Any], islands: range) -> None:
    made = finished(unwrap_steps(read(build()), 128, Unwrap.UVUNWRAP))
    assert made.islands in islands
    assert made.overlap == 0


def test_an_unwrap_that_is_no_longer_wanted_ends() -> None:
    steps = unwrap_steps(read(painted_ball()), 128, Unwrap.UVUNWRAP)
    next(steps)
    steps.close()
    assert not [mesh for mesh in bpy.data.meshes if "unwrap" in mesh.name]


def ball(radius: float = 0.3) -> Any:
    bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=12, radius=radius)
    item = context.object
    item.data.shade_smooth()
    return item


def unwrapped(*items: Any, texels: int = 128, **spec: Any) -> tuple[list[EvaluatedMesh], Unwrapped]:
    meshes = [read(item) for item in items]
    return meshes, finished(
        unwrap_surfaces(meshes, BakeSpec(texels=texels, **spec), metres=1.0, store=NO_STORE, known={})
    )


def with_small_islands(item: Any) -> Any:
    """The object, whose UV layer covers too little to be baked on as it is."""
    for corner in item.data.uv_layers.active.data:
        corner.uv *= 0.3
    return item


def share_of(mesh: EvaluatedMesh, uv: Floats) -> float:
    """How much of the atlas a square unit of the surface has."""
    surface = surface_areas(mesh.world_position[mesh.triangles]).sum()
    return float(np.abs(signed_areas(uv.astype(np.float64))).sum() / surface)


def islands_in(mesh: EvaluatedMesh, uv: Floats) -> Ints:
    return uv_islands(weld(mesh.position)[mesh.triangles], uv)


def test_objects_in_one_atlas_keep_their_own_islands() -> None:
    meshes, made = unwrapped(*(bent_sheet() for _ in range(4)))
    assert made.parts[0].islands == 4
    for mesh, uv in zip(meshes, made.uvs, strict=True):
        assert mesh.active_uv is not None
        own = np.abs(signed_areas(mesh.uv(mesh.active_uv).astype(np.float64)))
        share = np.abs(signed_areas(uv.astype(np.float64))) / own
        assert share.std() < 0.05 * share.mean()  # the same shape, but for sides on whole texels


def test_islands_are_kept_where_all_others_have_no_area() -> None:
    """As of a thin plate in a model that was made for another program."""
    item = quads((0, 0, 0.3), (0.5, 0, 0.3))
    for vertex, z in zip(item.data.vertices[4:], (0, 0, 0, 1e-9), strict=True):
        vertex.co.z = z
    for corner in item.data.uv_layers.active.data[4:]:
        corner.uv.y = 0
    ((mesh,), made) = unwrapped(item)
    assert made.parts[0].islands == 1
    assert np.isfinite(made.uvs[0]).all()
    assert share_of(mesh, made.uvs[0]) > 0.5


def test_an_island_that_lies_over_itself_is_not_kept() -> None:
    item = ball()
    layer = item.data.uv_layers.active
    for corner in layer.data:
        corner.uv.x = abs(corner.uv.x - 0.5)  # folded in the middle
    ((mesh,), made) = unwrapped(item)
    assert len(np.unique(islands_in(mesh, made.uvs[0]))) > 1
    assert find_overlap(made.uvs[0]).fraction < 1e-3


def test_islands_of_the_artist_end_where_materials_meet_and_at_sharp_edges() -> None:
    ((mesh,), made) = unwrapped(with_small_islands(painted_ball()))
    pairs = np.stack([islands_in(mesh, made.uvs[0]), mesh.material_index], axis=1)
    assert len(np.unique(pairs, axis=0)) == len(np.unique(pairs[:, 0])) >= 3
    bpy.ops.mesh.primitive_cylinder_add(vertices=16, radius=0.2, depth=0.4)
    ((mesh,), made) = unwrapped(with_small_islands(context.object))
    normal = mesh.normal.mean(axis=1)
    cap = np.abs(normal[:, 2]) > 0.9
    of_caps = np.unique(islands_in(mesh, made.uvs[0])[cap])
    assert not np.isin(islands_in(mesh, made.uvs[0])[~cap], of_caps).any()


@pytest.mark.parametrize(
    ("outer", "clear", "few"), [(0.4, False, True), (0.4, True, False), (4.0, False, False)]
)
def test_what_no_camera_can_see_gets_few_texels(outer: float, clear: bool, few: bool) -> None:
    """Inside an opaque ball it does; inside a clear one, or one that is as large as a room, it does not."""
    shell = ball(outer)
    glass = bpy.data.materials.new("shell")
    glass.node_tree.nodes["Principled BSDF"].inputs["Alpha"].default_value = 0.3 if clear else 1.0
    shell.data.materials.append(glass)
    (core, other), made = unwrapped(ball(0.2), shell)
    inner, whole = (share_of(mesh, uv) for mesh, uv in zip((core, other), made.uvs, strict=True))
    assert (inner < 0.15 * whole) == few
    even = unwrapped(ball(0.2), shell, density=200.0)[1]  # a density is kept everywhere
    inner, whole = (share_of(mesh, uv) for mesh, uv in zip((core, other), even.uvs, strict=True))
    assert inner == pytest.approx(whole, rel=0.2)


def test_flat_things_get_fewer_texels_than_curved_ones() -> None:
    bpy.ops.mesh.primitive_cube_add(size=0.5)
    both = context.object, ball()
    for density, least, most in ((None, 0.3, 0.7), (200.0, 0.9, 1.1)):
        meshes, made = unwrapped(*both, density=density)
        flat, curved = (share_of(mesh, uv) for mesh, uv in zip(meshes, made.uvs, strict=True))
        assert least * curved < flat < most * curved


def walls(opening: bool = False) -> list[Any]:
    """A room of 4 x 4 x 2.4 metres, of slabs with a thickness; one may be missing."""
    made = []
    for axis in range(3):
        for sign in (-1, 1):
            if opening and (axis, sign) == (0, 1):
                continue
            size, place = np.array([4.4, 4.4, 2.8]), np.zeros(3)
            size[axis], place[axis] = 0.2, sign * (1.3 if axis == 2 else 2.1)
            bpy.ops.mesh.primitive_cube_add(size=1, location=place.tolist())
            context.object.scale = size
            bpy.ops.object.transform_apply(location=False, rotation=False)
            made.append(context.object)
    return made


def outer_share(meshes: list[EvaluatedMesh], found: Unwrapped) -> float:
    """Texels for the same area of outsides as of insides."""
    shares = []
    for outside in (True, False):
        area = covered = 0.0
        for mesh, uv in zip(meshes, found.uvs, strict=True):
            corners = mesh.world_position[mesh.triangles]
            normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            middle = corners.mean(axis=1)
            away = (normal * middle).sum(axis=1) * (surface_areas(corners) > 4)  # of large faces alone
            some = away > 0 if outside else away < 0
            area += float(surface_areas(corners[some]).sum())
            covered += float(np.abs(signed_areas(uv[some].astype(np.float64))).sum())
        shares.append(covered / area)
    return shares[0] / shares[1]


@pytest.mark.parametrize(
    ("cameras", "opening", "share"),
    [
        ([(0, 0, 0), (1.5, -1, 0.4)], False, 1 / 16),
        ([(0, 0, 0)], True, 1 / 16),  # a room that is open on one side
        ([(0, 0, 0), (9, 2, 1)], False, 1),  # somebody looks from outside
        ([], False, 1),
    ],
)
def test_the_outside_of_a_room_whose_cameras_are_all_inside_has_few_texels(
    cameras: list[tuple[float, float, float]], opening: bool, share: float
) -> None:
    meshes, places = [read(item) for item in walls(opening)], np.array(cameras, dtype=float).reshape(-1, 3)
    steps = unwrap_surfaces(meshes, BakeSpec(texels=128), 1.0, NO_STORE, {}, places)
    assert outer_share(meshes, finished(steps)) == pytest.approx(share, rel=0.25)


def test_a_density_is_the_same_inside_and_outside() -> None:
    meshes = [read(item) for item in walls()]
    steps = unwrap_surfaces(meshes, BakeSpec(density=10.0), 1.0, NO_STORE, {}, np.zeros((1, 3)))
    assert outer_share(meshes, finished(steps)) == pytest.approx(1, rel=0.25)


def test_a_second_room_behind_a_door_counts_as_inside() -> None:
    """The camera stands beside the door's wall, and sees nothing of the other room's near corners."""
    items = walls()
    for size, place in (((0.1, 2.4, 2.4), (0, -0.8, 0)), ((0.1, 0.8, 2.4), (0, 1.6, 0))):
        bpy.ops.mesh.primitive_cube_add(size=1, location=place)
        context.object.scale = size
        bpy.ops.object.transform_apply(location=False, rotation=False)
        items.append(context.object)
    meshes = [read(item) for item in items]
    steps = unwrap_surfaces(meshes, BakeSpec(texels=128), 1.0, NO_STORE, {}, np.array([[1.9, -1.9, 0.0]]))
    made = finished(steps)
    partition, uv = meshes[6], made.uvs[6]
    corners = partition.world_position[partition.triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 0]
    here, there = (
        np.abs(signed_areas(uv[side].astype(np.float64))).sum() for side in (normal > 1, normal < -1)
    )
    assert there == pytest.approx(here, rel=0.1)
    assert outer_share(meshes, made) < 0.1
