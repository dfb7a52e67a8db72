# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects that share one mesh: each is baked in its own light, and shown by its own bake."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest
from mathutils import Matrix

from radtex_addon.cli import main as batch_module
from radtex_addon.core.arrays import Floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.sampler import Filter, sample
from radtex_addon.formats.containers.exr import read_atlas
from radtex_addon.preview.swap import is_on, switch_off, switch_on
from radtex_addon.scene.mesh.copy import UV_LAYER
from radtex_addon.scene.preview_file import baked_copy, surface_of
from tests.blender import stage
from tests.blender.batch_process import Batch, refusal
from tests.blender.fingerprint import differences, fingerprint
from tests.blender.lookup_stage import add_camera_above, render_exr, set_up_render

context: Any = bpy.context  # to the stubs, every pointer may be None

SHAPE = "Shape"
ALBEDO, POWER = 0.8, 1000.0
LAMP = np.array([2.5, -1.0, 2.0])  # from each object's middle
APART = 20.0  # so that neighbours' lamps bring less than 1 % of the light
# Of each object: its lamp's colour, and how it stands.
TWINS = {
    "Plain": ((1.0, 0.2, 0.1), Matrix.Translation((-APART, 0, 0))),
    "Mirrored": (
        (0.1, 1.0, 0.2),
        Matrix.Rotation(0.6, 4, "Z") @ Matrix.Diagonal((-1, 1, 1, 1)),
    ),
    "Modified": ((0.2, 0.1, 1.0), Matrix.Translation((APART, 0, 0)) @ Matrix.Diagonal((1, 0.7, 1.2, 1))),
}
QUALITY = ("--layout", "buckets", "--texels", "32", "--bucket", "3", "--samples", "16", "--capture", "portal")


def twins() -> None:
    """An egg with a blunt end, three times: as it is, mirrored, and with modifiers and stretched."""
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3)
    first = context.object
    shape = first.data
    shape.name = SHAPE
    for vertex in shape.vertices:
        vertex.co.x *= 1.5 if vertex.co.x > 0 else 0.8
    bpy.ops.object.shade_smooth()
    shape.materials.append(
        stage.material("matt", "ShaderNodeBsdfDiffuse", Color=(ALBEDO, ALBEDO, ALBEDO, 1), Roughness=0)
    )
    for name, (colour, matrix) in TWINS.items():
        item = first if name == "Plain" else first.copy()
        item.name, item.matrix_world = name, matrix
        if item is not first:
            context.scene.collection.objects.link(item)
        lamp: Any = bpy.data.lights.new(name, "POINT")
        lamp.energy, lamp.color, lamp.shadow_soft_size = POWER, colour, 0.0
        home = bpy.data.objects.new(f"{name}'s lamp", lamp)
        home.location = np.array(matrix.to_translation()) + LAMP
        context.scene.collection.objects.link(home)
    rounder: Any = bpy.data.objects["Modified"].modifiers.new("rounder", "SUBSURF")
    rounder.render_levels = 1
    stage.world((0, 0, 0))
    stage.clamps_off()


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> Path:
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    twins()
    path = tmp_path_factory.mktemp("room") / "room.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


@pytest.fixture(scope="module")
def baked(room: Path) -> Path:
    """The folder of a run of the batch that names all three."""
    out = room.parent / "baked"
    named = [word for name in TWINS for word in ("--object", name)]
    arguments = (room, *named, "--out", out, *QUALITY, "--save-preview", "--progress", "none")
    assert batch_module.main([str(argument) for argument in arguments], False) == 0
    return out


def irradiance(name: str, points: Floats, normals: Floats) -> Floats:
    """What a twin's own lamp gives to points (K, 3) with unit normals (K, 3), (K, 3): P cos / (4 pi r^2)."""
    colour, matrix = TWINS[name]
    away = np.array(matrix.to_translation()) + LAMP - points
    distance = np.linalg.norm(away, axis=1)
    cosine = np.maximum(np.einsum("ij,ij->i", away, normals), 0) / distance
    return np.outer(POWER * cosine / (4 * np.pi * distance**2), colour)


def test_each_shows_its_own_light(baked: Path) -> None:
    for name, (_, matrix) in TWINS.items():
        pixels, sidecar = read_atlas(baked / f"{name}.radiance.exr")
        with baked_copy(baked / f"{name}.preview.blend", (name,), UV_LAYER) as (_, copy):
            np.testing.assert_allclose(np.array(copy.matrix_world), np.array(matrix), atol=1e-6)
            surface = surface_of(copy, UV_LAYER)
        corner = surface.corner_position
        normals = surface.normal.mean(axis=1)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        seen = np.tile([[0.0, 0.0, 1.0]], (len(corner), 1))
        light = sample(
            pixels,
            AtlasLayout(sidecar.width, sidecar.height, sidecar.bucket),
            surface.uv.mean(axis=1),
            seen,
            Filter.QUADRILINEAR,
        )[:, :3]
        expected = ALBEDO / np.pi * irradiance(name, corner.mean(axis=1), normals)
        off = np.sqrt(np.mean((light - expected) ** 2)) / expected.max()
        assert off < 0.02, name


def test_each_preview_file_holds_its_own_copy(baked: Path) -> None:
    for name in TWINS:
        bpy.ops.wm.open_mainfile(filepath=str(baked / f"{name}.preview.blend"))
        meshes = {twin: bpy.data.objects[twin].data for twin in TWINS}
        assert [twin for twin in TWINS if UV_LAYER in meshes[twin].uv_layers] == [name]
        others = {mesh for twin, mesh in meshes.items() if twin != name}
        assert [mesh.name for mesh in others] == [SHAPE]


def test_previews_are_on_together_and_the_mesh_is_as_it_was(room: Path, baked: Path, tmp_path: Path) -> None:
    bpy.ops.wm.open_mainfile(filepath=str(room))
    scene, shape = context.scene, bpy.data.meshes[SHAPE]
    set_up_render(scene, "CYCLES")
    scene.cycles.samples, scene.cycles.filter_width = 16, 1.0
    add_camera_above(scene, (0, 0), (int(2 * APART) + 4, 4), 8)
    traced = render_exr(scene, tmp_path / "traced.exr")
    before = fingerprint()
    for name in TWINS:
        switch_on(bpy.data.objects[name], baked / f"{name}.radiance.json")
    shown = render_exr(scene, tmp_path / "shown.exr")
    originals = [bpy.data.objects[name] for name in TWINS]
    assert all(is_on(item) and item.data == shape for item in originals)
    assert len({bpy.data.objects[f"{name} (baked)"].data for name in TWINS}) == len(TWINS)
    assert np.sqrt(np.mean((shown - traced) ** 2)) < 0.02 * traced.max()
    switch_off(originals[0])  # and the others stay
    assert [is_on(item) for item in originals] == [False, True, True]
    for item in originals[1:]:
        switch_off(item)
    found = differences(before, fingerprint())
    assert {path for path in found if "render.filepath" not in path and "Render Result" not in path} == set()


def collection_instance(room: Path) -> tuple[Path, str]:
    bpy.ops.wm.open_mainfile(filepath=str(room))
    group = bpy.data.collections.new("Group")
    group.objects.link(bpy.data.objects["Plain"])
    bpy.ops.object.collection_instance_add(collection="Group", location=(0, 9, 0))
    context.object.name = "Placed"
    return room.with_name("placed.blend"), "instances a collection: join its instances"


def nodes_instance(room: Path) -> tuple[Path, str]:
    bpy.ops.wm.open_mainfile(filepath=str(room))
    tree: Any = bpy.data.node_groups.new("Scatter", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    source = tree.nodes.new("GeometryNodeObjectInfo")
    source.inputs["Object"].default_value = bpy.data.objects["Plain"]
    source.inputs["As Instance"].default_value = True
    tree.links.new(source.outputs["Geometry"], tree.nodes.new("NodeGroupOutput").inputs[0])
    placed = bpy.data.objects["Plain"].copy()
    placed.name = "Placed"
    context.scene.collection.objects.link(placed)
    scatter: Any = placed.modifiers.new("scatter", "NODES")
    scatter.node_group = tree
    return room.with_name("scattered.blend"), "join its instances, or add Realize Instances to its modifiers"


@pytest.mark.parametrize("make", [collection_instance, nodes_instance])
def test_instances_are_baked_but_of_several_frames(make: Any, room: Path, out: Path, batch: Batch) -> None:
    path, remedy = make(room)
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    asked = (path, "--object", "Placed", "--out", out, *QUALITY, "--progress", "none")
    line = refusal(batch(*asked, "--frames", "1,2"))
    assert "object 'Placed'" in line
    assert remedy in line
    ended = batch(*asked, "--save-preview")
    assert ended.code == 0, ended.err
    assert "'Placed' shows an instance: it is baked as one mesh" in ended.err
    bpy.ops.wm.open_mainfile(filepath=str(out / "Placed.preview.blend"))
    placed = bpy.data.objects["Placed"]
    assert (placed.type, placed.hide_render) == ("MESH", False)
    assert placed.location.y == (9 if make is collection_instance else bpy.data.objects["Plain"].location.y)
