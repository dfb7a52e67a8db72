# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rooms: their planes, what stands in them, and what bakes of their floors and walls mirror."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.bake.progress import finished
from radtex_addon.forms.layered.capture.capturing import capture_layered
from radtex_addon.forms.layered.capture.panoramas import pictures_shared
from radtex_addon.forms.layered.capture.room import Room, find_room
from radtex_addon.forms.layered.files.layered_files import read_layered_sidecar
from radtex_addon.forms.layered.lookup.environment import Shell
from radtex_addon.forms.layered.samples import LayeredSamples
from radtex_addon.job import bake_object
from radtex_addon.prepare.prepared import prepare
from radtex_addon.scene.objects import find_object
from radtex_addon.scene.scratch import scratch_scene
from radtex_addon.settings.rays import ROOM_SAMPLES
from radtex_addon.settings.spec import BakeSpec, Layout
from tests.blender import stage

pytestmark = [pytest.mark.one_blender, pytest.mark.usefixtures("temporary")]
context: Any = bpy.context  # to the stubs, every pointer may be None

SIZE = np.array([5.0, 4.0, 2.7])
SIDES = ("WallW", "WallE", "WallS", "WallN", "Floor", "Ceiling")
SPEC = BakeSpec(layout=Layout.LAYERED, texels=64, samples=1, half=False)


def box(name: str, low: Any, high: Any, colour: tuple[float, float, float], roughness: float = 0.9) -> Any:
    bpy.ops.mesh.primitive_cube_add(size=1, location=((np.array(low) + high) / 2).tolist())
    item = context.object
    item.name, item.scale = name, (np.array(high) - low).tolist()
    shiny = stage.material(
        name, "ShaderNodeBsdfPrincipled", **{"Base Color": (*colour, 1), "Roughness": roughness}
    )
    item.data.materials.append(shiny)
    return item


@pytest.fixture
def room(empty_file: None) -> None:
    """Six thick walls, the western one glowing, a cupboard before the south, and a picture in the east."""
    for number, name in enumerate(SIDES):
        low, high = np.full(3, -0.2), SIZE + 0.2
        axis, far = divmod(number, 2)
        if axis == 2:
            far = number - 4
        (low if far else high)[axis] = SIZE[axis] if far else 0
        side = box(name, low, high, (0.6, 0.6, 0.6), 0.1 if name == "Floor" else 0.9)
        if name == "WallW":
            side.data.materials[0] = stage.material("Glow", "ShaderNodeEmission", Strength=2.0)
    box("Cupboard", (1.5, 0.1, 0), (2.5, 0.7, 1.8), (0.2, 0.6, 0.2))
    box("Picture", (4.97, 1, 1), (5, 2, 1.8), (0.8, 0.1, 0.1))
    stage.world((0.0, 0.0, 5.0))


def found(*names: str) -> Room | None:
    """The room around some objects, from all over the inside of whose boxes rays start."""
    rng = np.random.default_rng(2)
    points, facets = [], []
    for name in names:
        corners = np.array(
            [bpy.data.objects[name].matrix_world @ v.co for v in bpy.data.objects[name].data.vertices]
        )
        low, high = corners.min(axis=0), corners.max(axis=0)
        at = rng.uniform(low, high, (400, 3))
        normal = np.zeros_like(at)
        for row in range(len(at)):
            axis, far = rng.integers(3), rng.integers(2)
            at[row, axis], normal[row, axis] = (high if far else low)[axis], 2 * far - 1
        points.append(at)
        facets.append(normal)
    with scratch_scene(context.scene) as scratch:
        items = [find_object(scratch, name) for name in names]
        return find_room(scratch, items, np.concatenate(points), np.concatenate(facets), 0)


@pytest.mark.parametrize("names", [("Floor",), ("Cupboard",), (*SIDES, "Cupboard", "Picture")])
def test_a_room_is_found_from_all_that_is_in_it(room: None, names: tuple[str, ...]) -> None:
    there = found(*names)
    assert there is not None
    order = np.lexsort(np.round(there.normals.T))
    planes = np.column_stack([there.normals, there.heights])[order]
    expected = np.column_stack([np.concatenate([np.eye(3), -np.eye(3)]), [0, 0, 0, *-SIZE]])
    np.testing.assert_allclose(planes, expected[np.lexsort(np.round(expected[:, :3].T))], atol=0.03)
    assert {item.name for item in there.furniture} == {"Cupboard"}, "a picture lies on its wall"
    assert ((there.eye > 0.5) & (there.eye < SIZE - 0.5)).all()
    assert there.holds(np.array([[1.0, 1.0, 1.0], [1.0, 1.0, 3.5]])).tolist() == [True, False]
    assert (there.furniture_eye is None) == (names == ("Cupboard",))


def test_things_in_the_open_stand_in_no_room(room: None) -> None:
    for name in SIDES[:4]:
        bpy.data.objects.remove(bpy.data.objects[name])
    bpy.data.objects.remove(bpy.data.objects["Ceiling"])
    assert found("Cupboard") is None


@pytest.mark.parametrize("names", [("Cupboard", "Lamp", "Rug"), ("Rug",), ("Floor", "Lamp")])
def test_what_rises_from_a_broad_foot_is_furniture(room: None, names: tuple[str, ...]) -> None:
    """Most of a lamp's area is its foot's; on the planes' picture its pole would be a stain on the floor."""
    bpy.ops.mesh.primitive_cylinder_add(radius=0.2, depth=0.02, location=(3.5, 2, 0.01))
    lamp = context.object
    bpy.ops.mesh.primitive_cylinder_add(radius=0.01, depth=1.5, location=(3.5, 2, 0.75))
    lamp.select_set(True)
    bpy.ops.object.join()
    context.object.name = "Lamp"
    box("Rug", (3, 2.5, 0), (4.5, 3.5, 0.01), (0.3, 0.1, 0.1))
    there = found(*names)
    assert there is not None
    assert {item.name for item in there.furniture} == {"Cupboard", "Lamp"}
    assert {item.name for item in there.shown} == (set() if "Cupboard" in names else {*names})


def test_an_angled_room_is_seen_from_where_both_its_wings_are(empty_file: None) -> None:
    """The middle of its box lies outside, behind an inner wall."""
    plan = [(0, 0), (6, 0), (6, 3), (3, 3), (3, 7), (0, 7)]
    walls = [[(*a, 0), (*b, 0), (*b, 2.6), (*a, 2.6)] for a, b in pairwise([*plan, plan[0]])]
    flat = {"Floor": [[(*at, 0.0) for at in plan]], "Ceiling": [[(*at, 2.6) for at in plan[::-1]]]}
    for name, faces in ({"Walls": walls} | flat).items():
        corners = [corner for face in faces for corner in face]
        sides = np.arange(len(corners)).reshape(len(faces), -1).tolist()
        mesh: Any = bpy.data.meshes.new(name)
        mesh.from_pydata(corners, [], sides)
        context.scene.collection.objects.link(bpy.data.objects.new(name, mesh))
    box("Here", (4.1, 1.1, 0), (4.9, 1.9, 0.8), (0.5, 0.5, 0.5))
    box("There", (0.6, 5.6, 0), (1.4, 6.4, 0.8), (0.5, 0.5, 0.5))
    rooms = [found("Here"), found("There")]
    for there in rooms:
        assert there is not None
        np.testing.assert_allclose(there.eye, (1.5, 1.75, 1.3), atol=0.01)


def captured(folder: Path, *names: str) -> LayeredSamples:
    folder.mkdir()
    kept: list[bpy.types.ID] = []
    with scratch_scene(context.scene, None, kept) as scratch:
        items = [find_object(scratch, name) for name in names]
        prepared = finished(prepare(scratch, items, SPEC, kept, backs=False))
        return finished(capture_layered(scratch, prepared, SPEC, folder, surroundings=0.25)).capture


def test_what_walls_show_each_other_is_in_the_picture_of_the_room(room: None, tmp_path: Path) -> None:
    """Its rays leave the baked walls free; and lobes are found, though nothing can leave the room.

    It does not matter that no ray tells where a volume is.
    """
    bpy.ops.object.volume_add(location=(1, 3, 1))
    sample = captured(tmp_path / "capture", *SIDES)
    shell = sample.around.layers[0].shape
    assert isinstance(shell, Shell)
    inside = _inside(sample)
    assert sample.own.hit[inside].mean() < 0.15
    axis = np.array([[-1, 0, 0], [1, 0, 0]], np.float32)
    offset = np.tile(SIZE / 2, (2, 1)).astype(np.float32) - sample.around.middle
    glowing, dark = sample.around.look(offset, axis, np.full(2, 1e-4, np.float32)).T
    np.testing.assert_allclose(glowing, 2, rtol=0.02)
    assert dark.max() < 1.5
    assert sample.alone is not None
    assert np.isfinite(sample.alone.mirrored_weight).all()
    assert (sample.alone.mirrored_weight[inside].max(axis=(1, 2)) > 0.02).mean() > 0.5


def test_a_mirror_on_a_wall_shows_what_it_shows_the_baked_object(room: None, tmp_path: Path) -> None:
    """From the room's eye it has the dark wall in the south there, from the cupboard the glowing one."""
    bpy.data.objects.remove(bpy.data.objects["Picture"])
    mirror = box("Mirror", (4.98, 0.3, 0.4), (5, 3.2, 2.0), (1, 1, 1), 0.0)
    for item, of, value in ((mirror, "Metallic", 1.0), (bpy.data.objects["Cupboard"], "Roughness", 0.1)):
        item.data.materials[0].node_tree.nodes["Principled BSDF"].inputs[of].default_value = value
    around = captured(tmp_path / "capture", "Cupboard").around
    axis = np.array([[5, 1, 1]], np.float32) - around.middle
    axis /= np.linalg.norm(axis)
    (shown,) = around.look(np.zeros((1, 3), np.float32), axis, np.full(1, 1e-4, np.float32)).T
    assert shown.min() > 1.7


def _inside(sample: LayeredSamples) -> Any:
    points = sample.light.plan.points
    return ((points > -0.01) & (points < SIZE + 0.01)).all(axis=1)


def test_a_lamp_in_the_room_is_mirrored_and_the_sun_outside_is_not(room: None, tmp_path: Path) -> None:
    kinds: Any = (("SUN", (0, 0, 9), 5.0), ("POINT", (2.5, 2, 2), 50.0))
    for kind, place, power in kinds:
        data: Any = bpy.data.lights.new(kind, kind)
        data.energy = power
        item = bpy.data.objects.new(kind, data)
        item.location = place
        context.scene.collection.objects.link(item)
    sample = captured(tmp_path / "capture", *SIDES)
    (lamp,) = sample.around.lamps
    np.testing.assert_allclose(lamp.place + sample.around.middle, (2.5, 2, 2), atol=0.05)


def test_more_light_goes_on_in_the_same_room(room: None, out: Path) -> None:
    spec = BakeSpec(layout=Layout.LAYERED, texels=64, samples=1, objects=SIDES)
    first = bake_object(context.scene, "Room", spec, out).files.sidecar
    planes = _planes(first)
    more = BakeSpec(layout=Layout.LAYERED, texels=64, samples=1, objects=SIDES, accumulate=True)
    assert _planes(bake_object(context.scene, "Room", more, out).files.sidecar) == planes
    assert len(planes) == 6


def test_bakes_of_one_room_share_its_picture_and_have_the_bits_of_bakes_alone(
    room: None, tmp_path: Path
) -> None:
    def baked(folder: str, *names: str) -> tuple[int, list[bytes]]:
        spec = BakeSpec(layout=Layout.LAYERED, texels=32, samples=1, objects=names if len(names) > 1 else ())
        made = bake_object(context.scene, names[0], spec, tmp_path / folder)
        return made.paths, [
            path.read_bytes() for path in sorted(made.files.sidecar.parent.glob(f"{names[0]}.*"))
        ]

    gloss = bpy.data.objects["Cupboard"].data.materials[0].node_tree.nodes[0].inputs["Roughness"]
    gloss.default_value = 0.2  # as sharp a picture as for the floor
    alone, files = baked("alone", "Cupboard")
    with pictures_shared():
        gloss.default_value = 0.1
        assert baked("changed", "Cupboard")[0] == alone
        gloss.default_value = 0.2
        assert baked("another", "Cupboard")[0] == alone, "of another scene, no picture is taken"
    with pictures_shared():
        baked("together", *SIDES, "Picture")
        after, same = baked("together", "Cupboard")
    assert after == alone - ROOM_SAMPLES * 224 * 112, "a view of the room less than alone"
    assert same == files


def _planes(path: Path) -> list[Any]:
    plane = read_layered_sidecar(path).plane
    assert isinstance(plane, Shell)
    return [*map(tuple, plane.normals.tolist())]
