# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Faces that are seen from behind, their twins, and cells that nobody can see."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bmesh
import bpy
import numpy as np
import pytest

from radtex_addon.bake.plan import plan_capture
from radtex_addon.bake.progress import finished
from radtex_addon.core.arrays import Bools, Floats
from radtex_addon.core.islands import find_overlap
from radtex_addon.cycles.find_hidden import find_hidden
from radtex_addon.prepare.prepared import Prepared, prepare
from radtex_addon.report.gbuffer import BakedSurface, CameraRays, GBuffer
from radtex_addon.scene.mesh.backs import (
    TWIN,
    fronts,
    lift_twins,
    seen_from_behind,
    twin_numbers,
    with_twins,
    without_twins,
)
from radtex_addon.scene.nodes import open_material
from radtex_addon.scene.scratch import scratch_scene
from radtex_addon.settings.spec import BakeSpec
from tests.blender import stage
from tests.blender.lookup_stage import add_camera_above, render_exr, set_up_render
from tests.blender.stage import read

context: Any = bpy.context  # to the stubs, every pointer may be None


def seen() -> Bools:
    """Of the object that was made last."""
    return seen_from_behind(read(context.object))


def prepared(spec: BakeSpec, backs: bool = True) -> Prepared:
    """The object that was made last, on an atlas."""
    kept: list[bpy.types.ID] = []
    item = context.object
    with scratch_scene(context.scene, None, kept) as scratch:
        return finished(prepare(scratch, [item], spec, kept, backs=backs))


def bowl() -> Any:
    """The lower half of a ball, smooth, its inside without faces of its own."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=32, ring_count=16)
    item = context.object
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.bisect(plane_co=(0, 0, 0.01), plane_no=(0, 0, 1), clear_outer=True)
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.ops.object.shade_smooth()
    return item


def looking(surface: BakedSurface, place: Floats, turn: Floats) -> GBuffer:
    """From a camera at `place` whose axes are the columns of `turn`."""
    rays = CameraRays.of_camera(place, turn, 0.15, 8, 1)
    return surface.gbuffer(rays, np.full(len(rays.away), np.inf))


@pytest.mark.one_blender
def test_open_meshes_are_seen_from_behind_and_closed_ones_are_not() -> None:
    bpy.ops.mesh.primitive_plane_add()
    assert seen().all()
    context.object.modifiers.new("Solid", "SOLIDIFY").thickness = 0.001
    assert not seen().any(), "a closed box of thin walls"
    bowl()
    assert seen().all()
    bpy.ops.mesh.primitive_uv_sphere_add()
    assert not seen().any()


@pytest.mark.one_blender
def test_a_crack_in_a_ball_shows_nothing() -> None:
    ball = bmesh.new()
    bmesh.ops.create_uvsphere(ball, u_segments=64, v_segments=32, radius=1)
    ball.faces.ensure_lookup_table()
    bmesh.ops.delete(ball, geom=[ball.faces[700]], context="FACES")
    mesh = bpy.data.meshes.new("Ball")
    ball.to_mesh(mesh)
    ball.free()
    item = bpy.data.objects.new("Ball", mesh)
    context.scene.collection.objects.link(item)
    assert not seen_from_behind(read(item)).any()


def test_what_has_both_sides_already_gets_no_more() -> None:
    mesh = bpy.data.meshes.new("Card")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)] * 2, [], [(0, 1, 2), (5, 4, 3)])
    item = bpy.data.objects.new("Card", mesh)
    context.scene.collection.objects.link(item)
    assert not seen_from_behind(read(item)).any()


def test_backface_culling_takes_no_back_away() -> None:
    """Cycles ignores the flag, which the glTF importer sets on every material that is not double-sided."""
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=4, y_subdivisions=4)
    mesh = context.object.data
    for index in range(2):
        mesh.materials.append(stage.material(f"{index}", "ShaderNodeBsdfDiffuse"))
        mesh.materials[index].use_backface_culling = index == 1
    mesh.polygons.foreach_set("material_index", np.arange(16) // 8)
    assert seen().all()
    found = prepared(BakeSpec(texels=32))
    number = twin_numbers(found.mesh)
    assert number is not None
    assert (~fronts(number)).sum() == fronts(number).sum()


@pytest.mark.parametrize(("side", "counts"), [(0.1, False), (0.3, True)])
def test_crumbs_that_are_seen_from_behind_get_no_texels(side: float, counts: bool) -> None:
    """A sheet beside a box of 24 square units: 0.01 of them count for nothing, 0.09 do."""
    bpy.ops.mesh.primitive_plane_add(size=side, location=(3, 0, 0))
    bpy.ops.mesh.primitive_cube_add()
    bpy.ops.object.select_all(action="SELECT")
    bpy.ops.object.join()
    assert seen().sum() == (2 if counts else 0)


@pytest.mark.one_blender
def test_what_is_inside_out_is_seen_from_behind_also_beside_a_closed_surface() -> None:
    """A turned cube of 0.24 square units beside a cube of 24: nothing has an open edge."""
    bpy.ops.mesh.primitive_cube_add(size=0.2, location=(3, 0, 0))
    context.object.data.flip_normals()
    bpy.ops.mesh.primitive_cube_add()
    bpy.ops.object.select_all(action="SELECT")
    bpy.ops.object.join()
    assert seen().sum() == 12


@pytest.mark.one_blender
def test_a_twin_faces_the_other_way() -> None:
    mesh = read(bowl())
    faces = np.arange(len(mesh.triangles)) % 3 == 0
    both = with_twins(mesh, faces)
    number = {attribute.name: attribute.values for attribute in both.attributes}[TWIN][:, 0]
    assert fronts(number).sum() == len(mesh.triangles)
    old, own = np.flatnonzero(faces), len(mesh.triangles)
    np.testing.assert_array_equal(number[number >= 0], np.arange(own, own + len(old)))
    np.testing.assert_array_equal(np.flatnonzero(number >= 0), old)
    front, back = both.position[both.triangles[old]], both.position[both.triangles[own:]]
    np.testing.assert_array_equal(front, back[:, ::-1])
    np.testing.assert_array_equal(both.normal[old], -both.normal[own:][:, ::-1])
    for attribute in mesh.attributes:
        if attribute.domain == "CORNER":
            twice = next(each.values for each in both.attributes if each.name == attribute.name)
            np.testing.assert_array_equal(twice[old], twice[own:][:, ::-1])
    alone = without_twins(both)
    np.testing.assert_array_equal(alone.triangles, mesh.triangles)
    np.testing.assert_array_equal(alone.normal, mesh.normal)


@pytest.mark.parametrize("mirrored", [False, True])
def test_rays_meet_the_side_that_faces_them(mirrored: bool) -> None:
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=5, y_subdivisions=5)
    context.object.scale = (-1 if mirrored else 1, 1, 1)
    found = prepared(BakeSpec(texels=32))
    number = twin_numbers(found.mesh)
    assert number is not None
    surface = BakedSurface(found.mesh, found.matrix_world, found.uv_layer)
    above = looking(surface, np.array([0.05, 0.07, 5]), np.eye(3))
    below = looking(surface, np.array([0.05, 0.07, -5]), np.diag([1.0, -1.0, -1.0]))
    assert above.hit.all()
    assert below.hit.all()
    for buffer, up in ((above, 1), (below, -1)):
        np.testing.assert_allclose(buffer.normal, np.broadcast_to((0, 0, up), (64, 3)), atol=1e-6)
        assert (fronts(number)[buffer.triangle] == (up > 0)).all()
        texels = found.texels()
        column, row = (buffer.uv * (found.width, found.height)).astype(int).T
        np.testing.assert_allclose(texels.position[row, column], buffer.position, atol=0.2)
        assert (texels.normal[row, column][:, 2] * up > 0.9).all()


@pytest.mark.one_blender
def test_both_sides_have_places_of_their_own_in_the_atlas() -> None:
    bowl()
    found = prepared(BakeSpec(texels=64))
    assert find_overlap(found.surface.uv).fraction < 1e-3
    texels = found.texels()
    outwards = (texels.position * texels.normal).sum(axis=-1)[texels.covered]
    assert (outwards > 0.8).any()
    assert (outwards < -0.8).any()
    assert (np.abs(outwards) > 0.8).all()
    rendered = found.pieces[0].rendered
    assert len(rendered.polygons) * 2 == len(found.mesh.polygons)


def test_nothing_changes_unless_it_is_asked_for() -> None:
    bowl()
    found = prepared(BakeSpec(texels=64), backs=False)
    assert found.pieces[0].rendered == found.mesh
    assert TWIN not in found.mesh.attributes


def test_a_layer_of_ones_own_is_kept(caplog: pytest.LogCaptureFixture) -> None:
    bpy.ops.mesh.primitive_plane_add()
    found = prepared(BakeSpec(texels=16, uv_layer="UVMap"))
    assert len(found.mesh.polygons) == 2
    assert "from behind" in caplog.text


@pytest.mark.one_blender
def test_the_inside_of_an_open_bowl_is_not_hidden(tmp_path: Path) -> None:
    bowl()
    for backs in (False, True):
        found = prepared(BakeSpec(texels=32), backs=backs)
        plan = plan_capture(found.texels(), 4)
        hidden = finished(find_hidden(found.seen, plan, tmp_path))
        assert not hidden.cells.any()


@pytest.mark.one_blender
def test_the_back_of_a_card_above_hides_nothing_where_it_is_drawn(tmp_path: Path) -> None:
    bpy.ops.mesh.primitive_plane_add(size=0.5)
    card = context.object
    bpy.ops.mesh.primitive_plane_add(size=8, location=(0, 0, 0.5))
    card.select_set(True)
    bpy.ops.object.join()
    at, up = np.zeros((2, 3)), np.array([[0, 0, 1.0], [0, 0, -1.0]])
    plan = stage.plan_of(at + 0.01 * up, up, 4)
    for backs in (False, True):
        found = prepared(BakeSpec(texels=32), backs=backs)
        hidden = finished(find_hidden(found.seen, plan, tmp_path)).cells
        assert hidden[0].any() == (not backs)
        assert not hidden[1].any()


@pytest.mark.one_blender
def test_lifted_twins_are_off_their_faces_and_no_others_move() -> None:
    bowl()
    mesh: Any = prepared(BakeSpec(texels=64)).mesh
    number = twin_numbers(mesh)
    assert number is not None
    corners = np.array([tuple(face.vertices) for face in mesh.polygons])
    before = np.array([vertex.co[:] for vertex in mesh.vertices])
    lift_twins(mesh)
    moved = np.array([vertex.co[:] for vertex in mesh.vertices]) - before
    assert (moved[np.unique(corners[fronts(number)])] == 0).all()
    size = float(np.linalg.norm(np.ptp(before, axis=0)))
    away = np.linalg.norm(moved[np.unique(corners[~fronts(number)])], axis=1) / size
    assert away.min() > 4e-6
    assert away.max() < 6e-6, "the report takes the mesh for the same up to 1e-5"
    inwards = (moved * before).sum(axis=1)[np.unique(corners[~fronts(number)])]
    assert (inwards < 0).all(), "towards the bowl's inside, which the twins face"


@pytest.mark.parametrize("away", [3.0, 60.0])
def test_cycles_shows_a_sheet_whose_back_faces_are_transparent(away: float, tmp_path: Path) -> None:
    """Of two triangles in one place it met only one, and of some the transparent one."""
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=9, y_subdivisions=9)
    sheet = context.object
    sheet.rotation_euler = (0.4, 0.3, 0.2)
    mesh = prepared(BakeSpec(texels=64)).mesh
    lift_twins(mesh)
    sheet.data = mesh
    material, build = open_material("Fronts")
    behind = build.geometry("Backfacing")
    light = build.node("ShaderNodeEmission", (1, 1, 1, 1), build.math("SUBTRACT", 1.0, behind)).outputs[0]
    clear = build.node("ShaderNodeBsdfTransparent", behind).outputs[0]
    build.node("ShaderNodeOutputMaterial", build.node("ShaderNodeAddShader", light, clear).outputs[0])
    mesh.materials.clear()
    mesh.materials.append(material)
    set_up_render(context.scene, "CYCLES")
    camera: Any = add_camera_above(context.scene, (0, 0), (1, 1), 32)
    camera.location.z = away
    camera.data.type, camera.data.angle = "PERSP", 1 / away
    image = render_exr(context.scene, tmp_path / "sheet.exr")
    assert (image > 0.999).all(axis=2).mean() > 0.995, "but for a pixel on an edge, from afar"


def active_mesh() -> bpy.types.Mesh:
    """The mesh of the object that was made last."""
    mesh = bpy.context.object.data
    assert isinstance(mesh, bpy.types.Mesh)
    return mesh


@pytest.mark.one_blender
@pytest.mark.parametrize("mirrored", [False, True])
def test_a_sheared_convex_mesh_hides_nothing(tmp_path: Path, mirrored: bool) -> None:
    bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32)
    mesh = active_mesh()
    matrix = np.eye(4)
    matrix[0, 2], matrix[1, 1] = 2.0, -1.0 if mirrored else 1.0
    turn = np.linalg.inv(matrix[:3, :3])
    point, normal = np.empty((2, len(mesh.polygons), 3))
    mesh.polygons.foreach_get("center", point.ravel())
    mesh.polygons.foreach_get("normal", normal.ravel())
    point, normal = point[::40], normal[::40] @ turn
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    plan = stage.plan_of(point @ matrix[:3, :3].T, normal, 4)
    assert not finished(find_hidden([(mesh, matrix)], plan, tmp_path)).cells.any()


def test_the_inside_of_another_part_is_hidden(tmp_path: Path) -> None:
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=4, radius=1)
    plan = stage.plan_of(np.array([[0, 0, 0], [0, 0, 2.0]]), np.array([[0, 0, 1.0], [0, 0, 1.0]]), 4)
    hidden = finished(find_hidden([(active_mesh(), np.eye(4))], plan, tmp_path)).cells
    assert hidden[0].all()
    assert not hidden[1].any()
