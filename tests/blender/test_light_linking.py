# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Light linking: previews and applied copies are lit and shadow as their objects, and all else as before."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.bake import progress
from radtex_addon.core.sampler import Filter
from radtex_addon.job import bake_object
from radtex_addon.preview.apply_copy import apply_to_copies
from radtex_addon.preview.swap import previews_not_rendered, previews_off, switch_off, switch_on
from radtex_addon.report.side_by_side import ComparisonSpec, compare_steps
from radtex_addon.report.viewpoint import Viewpoint
from radtex_addon.settings.spec import BakeSpec, Layout
from tests.blender import stage
from tests.blender.fingerprint import differences, fingerprint
from tests.blender.test_swap import PLAIN, bake_of, ball

context: Any = bpy.context  # to the stubs, every pointer may be None

IN, OUT = "INCLUDE", "EXCLUDE"
Members = dict[str, dict[str, str]]  # the state of each object, or child, of each collection for linking


@pytest.fixture(scope="module")
def bake(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The sidecar of a ball's bake; not to be written to."""
    return bake_of(PLAIN, tmp_path_factory.mktemp("bake"))


@pytest.fixture
def sidecar(bake: Path) -> Path:
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    return bake


def lamp(name: str) -> Any:
    bpy.ops.object.light_add(type="SUN", location=(0, 0, 5))
    context.object.name = name
    return context.object


def collection(name: str, *members: tuple[Any, str]) -> Any:
    """A collection in no scene, with objects and collections, each included or excluded."""
    made: Any = bpy.data.collections.new(name)
    for item, state in members:
        home, entries = (
            (made.children, made.collection_children)
            if isinstance(item, bpy.types.Collection)
            else (made.objects, made.collection_objects)
        )
        home.link(item)
        entries[-1].light_linking.link_state = state
    return made


def linked_scene() -> Any:
    """Every way in which light linking may be about the ball, which is returned."""
    item, other = ball(), ball("Other")
    furniture = collection("Furniture", (item, OUT), (other, IN))
    context.scene.collection.children.link(furniture)
    shelf = collection("Shelf", (item, IN))
    context.scene.collection.children.link(shelf)
    for number, (receivers, blockers) in enumerate(
        (
            (collection("Dark", (item, OUT)), collection("Blocks", (item, IN), (other, OUT))),
            (collection("Lit", (other, IN)), collection("No Shadow", (item, OUT))),
            (furniture, collection("Nested", (shelf, OUT), (other, IN))),
            (collection("Both", (shelf, OUT), (item, IN)), None),
        )
    ):
        light = lamp(f"Lamp {number}")
        light.light_linking.receiver_collection = receivers
        light.light_linking.blocker_collection = blockers
    glows = item.light_linking  # it emits light itself
    glows.receiver_collection = bpy.data.collections["Lit"]
    return item


def members() -> Members:
    found: Members = {}
    for home in bpy.data.collections:
        every: Any = home
        found[home.name] = {
            one.name: entry.light_linking.link_state
            for ones, entries in (
                (every.objects, every.collection_objects),
                (every.children, every.collection_children),
            )
            for one, entry in zip(ones, entries, strict=True)
        }
    return found


def alike(before: Members, name: str, copy: str) -> Members:
    """The members where the copy is wherever the object is."""
    return {
        home: {**states, **({copy: states[name]} if name in states else {})}
        for home, states in before.items()
    }


def test_a_preview_is_linked_as_its_object_and_leaves_no_trace(sidecar: Path) -> None:
    item = linked_scene()
    before, whole = members(), fingerprint()
    shown: Any = switch_on(item, sidecar).copy
    assert members() == alike(before, item.name, shown.name)
    assert shown.light_linking.receiver_collection == bpy.data.collections["Lit"]
    switch_on(item, sidecar)  # which is replaced
    assert members() == alike(before, item.name, "Ball (baked)")
    with previews_off(context.scene), previews_not_rendered(context.scene):
        assert members() == alike(before, item.name, "Ball (baked)")
    switch_off(item)
    assert members() == before
    assert differences(whole, fingerprint()) == {}


def test_an_applied_copy_is_linked_as_its_object(sidecar: Path) -> None:
    item = linked_scene()
    before = members()
    (made,) = apply_to_copies([item], sidecar, context.view_layer)
    copy = made.copy.name
    wanted = alike(before, item.name, copy) | {"Shelf": before["Shelf"], "Radiance Textures": {copy: IN}}
    wanted["Nested"] = before["Nested"] | {copy: OUT}  # which leaves out the original's shelf
    assert members() == wanted


def test_a_preview_elsewhere_than_its_object_is_linked_alike(sidecar: Path, tmp_path: Path) -> None:
    """An object of a linked collection: the copy cannot go there, and the lamp is this file's."""
    home = collection("Home", (ball(), IN))
    context.scene.collection.objects.unlink(bpy.data.objects["Ball"])
    context.scene.collection.children.link(home)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "library.blend"))
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    libraries: Any = bpy.data.libraries
    with libraries.load(str(tmp_path / "library.blend"), link=True) as (_, wanted):
        wanted.collections = ["Home"]
    (home,) = wanted.collections
    context.scene.collection.children.link(home)
    other = ball("Other")
    light = lamp("Lamp")
    light.light_linking.receiver_collection = collection("Receivers", (home, OUT), (other, IN))
    before = members()
    (made,) = apply_to_copies([home.objects[0]], sidecar, context.view_layer)
    assert set(made.copy.users_collection) == {
        bpy.data.collections["Radiance Textures"],
        bpy.data.collections["Receivers"],
    }
    name = made.copy.name
    expected = {**before, "Receivers": before["Receivers"] | {name: OUT}, "Radiance Textures": {name: IN}}
    assert members() == expected


def floor(name: str, x: float) -> Any:
    bpy.ops.mesh.primitive_plane_add(size=2, location=(x, 0, 0))
    context.object.name = name
    context.object.data.materials.append(
        stage.material(name, "ShaderNodeBsdfDiffuse", Color=(0.8, 0.8, 0.8, 1))
    )
    return context.object


@pytest.mark.one_blender
@pytest.mark.parametrize("is_on", [False, True], ids=["preview off", "preview on"])
def test_both_sides_of_a_comparison_have_the_scenes_light(tmp_path: Path, is_on: bool) -> None:
    """A lamp leaves out the left floor, and so lights all else; the left floor's bake is black."""
    stage.world((0, 0, 0))
    left, _ = floor("Left", -1), floor("Right", 1)
    light = lamp("Sun")
    light.data.energy = 3
    light.light_linking.receiver_collection = collection("Receivers", (left, OUT))
    spec = BakeSpec(texels=8, bucket=2, samples=1, layout=Layout.BUCKETS)
    made = bake_object(context.scene, "Left", spec, tmp_path, preview=Filter.NEAREST)
    bpy.ops.object.camera_add(location=(0, 0, 5))
    scene = context.scene
    scene.camera = context.object
    scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", 4
    scene.render.resolution_x = scene.render.resolution_y = 32
    before, sidecar = members(), made.files.sidecar
    if is_on:
        switch_on(left, sidecar)
    eye = Viewpoint.of_camera(scene, context.view_layer)
    found = progress.finished(
        compare_steps(scene, {left: None if is_on else sidecar}, eye, ComparisonSpec(32, 4))
    )
    if is_on:
        switch_off(left)
    assert members() == before
    for side in (found.traced, found.baked):
        assert np.abs(side[12:20, 4:12]).max() < 1e-3
        np.testing.assert_allclose(side[12:20, 20:28], 0.8 * 3 / np.pi, rtol=0.05)


def test_the_saved_previews_scene_is_linked_as_the_users(tmp_path: Path) -> None:
    stage.world((0, 0, 0))
    item = linked_scene()
    before, whole = members(), fingerprint()
    made = bake_object(context.scene, item.name, PLAIN, tmp_path, preview=Filter.NEAREST)
    assert differences(whole, fingerprint()) == {}
    bpy.ops.wm.open_mainfile(filepath=str(made.files.preview))
    assert members() == before
    light: Any = bpy.data.objects["Lamp 2"]
    assert light.light_linking.receiver_collection == bpy.data.collections["Furniture"]
    assert bpy.data.collections["Furniture"] in context.scene.collection.children_recursive
