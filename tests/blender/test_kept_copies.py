# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Copies that show a bake and are kept: known as such, not baked again, updated and deleted."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.job import bake_object
from radtex_addon.job.bake_fingerprint import read_now
from radtex_addon.job.left_out import find_bakeable
from radtex_addon.preview.kept_copies import original_of_copy, shown_by
from radtex_addon.preview.swap import is_on, switch_off, switch_on
from radtex_addon.ui.panel import panel_state
from radtex_addon.ui.panel.finished_panel import RADTEX_PT_afterwards
from radtex_addon.ui.panel.main_panel import RADTEX_PT_bake
from tests.blender import stage
from tests.blender.batch_process import QUICK, Batch
from tests.blender.fingerprint import differences
from tests.blender.recorded_layout import RecordedLayout
from tests.blender.test_swap import NAME, PLAIN, bake_of, ball, digest
from tests.blender.ui_stage import context, ops, registered

COPY = f"{NAME} (baked copy)"
HOME = "Radiance Textures"


@pytest.fixture(scope="module")
def baked(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The sidecar of a bake; not to be written to."""
    return bake_of(PLAIN, tmp_path_factory.mktemp("baked"))


@pytest.fixture
def bake(baked: Path, tmp_path: Path) -> Path:
    """The sidecar of a bake that may be changed."""
    return Path(shutil.copytree(baked.parent, tmp_path / "bake")) / baked.name


@pytest.fixture(autouse=True)
def _registered(bake: Path) -> Iterator[None]:
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    with registered():
        yield


@pytest.fixture
def copy(bake: Path) -> Any:
    """A copy of a ball, which is selected and active."""
    ball()
    context.scene.radtex.directory = str(bake.parent)
    assert ops.radtex.apply_to_copy() == {"FINISHED"}
    return bpy.data.objects[COPY]


def rebake(sidecar: Path) -> None:
    """What tells another bake from this one: its sidecar is another file."""
    sidecar.write_bytes(sidecar.read_bytes() + b"\n")


def drawn(panel: Any) -> RecordedLayout:
    """What a panel draws, once it has thought about the scene."""
    panel_state.refresh(context.scene, context.view_layer)
    layout = RecordedLayout()
    panel.draw(SimpleNamespace(layout=layout), context)
    return layout


def test_a_copy_is_known_renamed_duplicated_and_appended(copy: Any, tmp_path: Path) -> None:
    copy.name = "Vase for the shop"
    bpy.ops.object.duplicate()
    twin = context.object
    assert twin != copy
    for one in (copy, twin):
        shown = shown_by(one)
        assert shown is not None
        assert (shown.name, shown.shader) == (NAME, "NODES")
        assert original_of_copy(one, context.scene) == bpy.data.objects[NAME]
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "first.blend"))
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    libraries: Any = bpy.data.libraries
    with libraries.load(str(tmp_path / "first.blend")) as (_, into):
        into.objects = ["Vase for the shop"]
    (appended,) = into.objects
    context.scene.collection.objects.link(appended)
    assert [item.name for item in bpy.data.objects] == [
        "Vase for the shop"
    ]  # its original did not come along
    assert shown_by(appended) is not None
    ball()  # of the same name, and another one
    assert original_of_copy(appended, context.scene) is None


def test_an_original_is_found_after_it_was_renamed_and_duplicated(copy: Any) -> None:
    item = bpy.data.objects[NAME]
    twin = item.copy()
    context.scene.collection.objects.link(twin)
    assert original_of_copy(copy, context.scene) == item
    item.name = "Kugel"
    bpy.data.objects.remove(twin)
    assert original_of_copy(copy, context.scene) == item
    bpy.data.objects.remove(item)
    assert original_of_copy(copy, context.scene) is None


def test_copies_of_earlier_versions_are_known_and_others_are_not(copy: Any, bake: Path) -> None:
    for key in [key for key in dict(copy) if key.startswith("radtex")]:
        del copy[key]
    assert shown_by(copy) is None  # nothing says so any more but its mesh and material
    copy.name = f"{NAME} (baked).002"
    del bpy.data.objects[NAME]["radtex_number"]
    shown = shown_by(copy)
    assert shown is not None
    assert (shown.name, shown.sidecar, shown.shader) == (NAME, bake, "NODES")
    assert original_of_copy(copy, context.scene) == bpy.data.objects[NAME]
    assert ops.radtex.update_copy() == {"FINISHED"}
    other = ball("Stone (baked)")
    preview = switch_on(bpy.data.objects[NAME], bake).copy
    assert [shown_by(one) for one in (other, preview, bpy.data.objects[NAME])] == [None] * 3


def test_copies_have_one_collection_in_each_scene(copy: Any, bake: Path) -> None:
    (home,) = copy.users_collection
    assert home.name == HOME
    assert list(context.scene.collection.children) == [home]
    home.name = "For the shop"  # it stays theirs
    ops.radtex.apply_to_copy(object=NAME)
    assert [one.name for one in context.scene.collection.children] == ["For the shop"]
    assert len(home.objects) == 2
    other: Any = bpy.data.scenes.new("Other")
    other.collection.objects.link(bpy.data.objects[NAME])
    with context.temp_override(scene=other, view_layer=other.view_layers[0]):
        ops.radtex.apply_to_copy(object=NAME, bake=str(bake))
    assert [one.name for one in other.collection.children] == [HOME]
    assert len(home.objects) == 2


def test_the_panel_has_buttons_for_copies_and_none_that_bakes(copy: Any, bake: Path) -> None:
    layout = drawn(RADTEX_PT_bake)
    assert [name for name, _ in layout.buttons] == [
        "radtex.select_original",
        "radtex.update_copy",
        "radtex.delete_copy",
    ]
    told = " ".join(layout.texts)
    assert f"A copy that shows the bake of {NAME}" in told
    assert "It shows the latest bake" in told
    assert "select the original" in " ".join(drawn(RADTEX_PT_afterwards).texts)
    rebake(bake)
    assert "There is another bake by now: update it" in " ".join(drawn(RADTEX_PT_bake).texts)
    shutil.rmtree(bake.parent)
    assert "The files of its bake are not there" in " ".join(drawn(RADTEX_PT_bake).texts)
    bpy.data.objects.remove(bpy.data.objects[NAME])
    assert f"{NAME} is not in this scene" in " ".join(drawn(RADTEX_PT_bake).texts)
    ball("Other").select_set(True)  # now there is something to bake
    copy.select_set(True)
    layout = drawn(RADTEX_PT_bake)
    assert "radtex.update_copy" not in {name for name, _ in layout.buttons}
    assert any("is a copy that shows" in text for text in (" ".join(layout.texts),))


@pytest.mark.parametrize("source", ["selection", "collection", "list"])
def test_copies_are_left_out_and_a_line_says_why(copy: Any, source: str) -> None:
    other, chosen = ball("Other"), context.scene.radtex_chosen
    other.location.x = 5
    copy.select_set(True)
    home = bpy.data.collections.new("home")
    context.scene.collection.children.link(home)
    for item in (other, copy):
        home.objects.link(item)
    chosen.source, chosen.collection = source, home
    for item in (other, copy):
        chosen.listed.add().item = item
    found = panel_state.refresh(context.scene, context.view_layer)
    assert copy.name not in found.objects
    assert "Other" in found.objects
    assert [(one.name, str(one.why)) for one in found.left_out] == [
        (
            COPY,
            f"object '{COPY}' is a copy that shows the bake of '{NAME}': bake '{NAME}', then update the copy",
        )
    ]
    assert find_bakeable(context.scene, [COPY, "Other"], None, preview=False).kept == ("Other",)


def test_the_batch_leaves_copies_out_and_says_why(copy: Any, tmp_path: Path, batch: Batch) -> None:
    bpy.data.objects[NAME].location.x = 5
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    out = tmp_path / "out"
    ended = batch(tmp_path / "scene.blend", "--all", "--out", out, *QUICK)
    assert f"'{COPY}' is a copy that shows the bake of '{NAME}'" in ended.err
    assert sorted(path.name for path in out.rglob("*.json")) == [f"{NAME}.radiance.json"]


def test_a_bake_does_not_see_a_copy_in_the_place_of_its_original(bake: Path, tmp_path: Path) -> None:
    item: Any = ball()
    ball("Other").location.x = 2.5
    context.view_layer.update()
    context.scene.radtex.directory = str(bake.parent)
    alone = read_now(context.scene).whole
    ops.radtex.apply_to_copy(object=NAME)
    copy = bpy.data.objects[COPY]
    assert read_now(context.scene).whole == alone
    assert not copy.hide_render
    switch_on(item, bake)
    assert read_now(context.scene).whole == alone
    switch_off(item)
    item.hide_render = True  # the copy stands in for it
    context.view_layer.update()
    seen = read_now(context.scene).whole
    bpy.data.objects[COPY].hide_render = True
    assert read_now(context.scene).whole != seen
    bpy.data.objects[COPY].hide_render = item.hide_render = False
    copy.location.z = 4
    context.view_layer.update()
    assert read_now(context.scene).whole != alone


def test_a_second_bake_of_the_original_has_the_bits_of_the_first(bake: Path, tmp_path: Path) -> None:
    item = ball()
    item.data.materials[0] = stage.material("matt", "ShaderNodeBsdfDiffuse", Color=(0.8, 0.8, 0.8, 1))
    stage.hdri(stage.world())
    before = bake_object(context.scene, NAME, PLAIN, tmp_path / "before")
    context.scene.radtex.directory = str(bake.parent)
    ops.radtex.apply_to_copy(object=NAME)
    again = bake_object(context.scene, NAME, PLAIN, tmp_path / "again")
    first, second = ([path.read_bytes() for path in one.files.images] for one in (before, again))
    assert first == second


def test_the_original_is_selected_and_shown(copy: Any, bake: Path) -> None:
    item = bpy.data.objects[NAME]
    item.hide_set(True)
    assert ops.radtex.select_original() == {"FINISHED"}
    assert list(context.view_layer.objects.selected) == [item]
    assert context.view_layer.objects.active == item
    preview = switch_on(item, bake).copy
    context.view_layer.update()
    assert ops.radtex.select_original(object=COPY) == {"FINISHED"}
    assert context.view_layer.objects.active == preview
    assert is_on(item)
    with pytest.raises(RuntimeError, match="No copy that shows a bake is selected"):
        ops.radtex.select_original(object=NAME)
    ops.radtex.preview_toggle(object=NAME, action="OFF")
    bpy.data.objects.remove(item)
    with pytest.raises(RuntimeError, match=f"The original '{NAME}' is not in view layer"):
        ops.radtex.select_original(object=COPY)


def test_an_update_brings_the_mesh_of_the_new_bake_and_leaves_all_else(copy: Any, bake: Path) -> None:
    ops.radtex.apply_to_copy(object=NAME)
    twin = bpy.data.objects[f"{COPY}.001"]
    copy.location, copy.name = (1, 2, 3), "Moved"
    material = bpy.data.materials.new("the user's own")
    twin.data.materials[0] = material
    rebake(bake)
    before = {one: one.data.session_uid for one in (copy, twin)}
    count = len(bpy.data.meshes)
    assert ops.radtex.update_copy(object="Moved") == {"FINISHED"}
    context.view_layer.update()
    assert all(one.data.session_uid != before[one] for one in (copy, twin))  # they share the node group
    assert len(bpy.data.meshes) == count
    np.testing.assert_allclose(copy.matrix_world.translation, (1, 2, 3))
    assert twin.data.materials[0] == material
    assert copy.data.materials[0].name == f"{NAME}.radiance"
    assert [one.bake for one in select(copy, twin).copies] == ["same", "same"]


def select(*items: Any) -> Any:
    """What the panel finds with these alone selected."""
    bpy.ops.object.select_all(action="DESELECT")
    for item in items:
        item.select_set(True)
    return panel_state.refresh(context.scene, context.view_layer)


def test_an_update_keeps_what_a_stretched_parent_did(bake: Path) -> None:
    item, parent = ball(), ball("Other")
    context.scene.radtex.directory = str(bake.parent)
    item.parent, item.rotation_euler, parent.scale = parent, (0.5, 0.5, 0), (3, 1, 1)
    context.view_layer.update()
    ops.radtex.apply_to_copy(object=NAME)
    copy: Any = bpy.data.objects[COPY]
    before = np.array([vertex.co for vertex in copy.data.vertices])
    rebake(bake)
    ops.radtex.update_copy(object=COPY)
    np.testing.assert_allclose([vertex.co for vertex in copy.data.vertices], before, atol=1e-5)
    assert np.ptp(before[:, 0]) > 3  # it is stretched


def test_a_missing_bake_is_named_and_nothing_changes(copy: Any, bake: Path) -> None:
    shutil.rmtree(bake.parent)
    before = digest()
    with pytest.raises(RuntimeError, match=f"The bake of '{NAME}' that .* shows is not there"):
        ops.radtex.update_copy()
    assert differences(before, digest()) == {}


def test_deleting_copies_leaves_what_was_before_them(bake: Path) -> None:
    ball()
    context.scene.radtex.directory = str(bake.parent)
    ops.radtex.apply_to_copy()
    ops.radtex.apply_to_copy(object=NAME)
    assert ops.radtex.delete_copy(object=f"{COPY}.001") == {"FINISHED"}
    assert [item.name for item in bpy.data.collections[HOME].objects] == [COPY]
    assert ops.radtex.delete_copy(object=COPY) == {"FINISHED"}
    assert HOME not in bpy.data.collections
    assert [item.name for item in bpy.data.objects] == [NAME]
    assert len(bpy.data.meshes) == 1
    assert bake.is_file()


@pytest.mark.parametrize("operator", ["update_copy", "delete_copy", "select_original"])
def test_one_undo_takes_it_back(copy: Any, bake: Path, operator: str) -> None:
    rebake(bake)
    bpy.ops.ed.undo_push(message="before")
    before = digest()
    getattr(ops.radtex, operator)(object=COPY)
    assert differences(before, digest()) != {}
    bpy.ops.ed.undo()
    assert differences(before, digest()) == {}


def test_copies_of_a_linked_file_are_known_and_left_as_they_are(
    copy: Any, bake: Path, tmp_path: Path
) -> None:
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "library.blend"))
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    libraries: Any = bpy.data.libraries
    with libraries.load(str(tmp_path / "library.blend"), link=True) as (_, into):
        into.objects = [NAME, COPY]
    for item in into.objects:
        context.scene.collection.objects.link(item)
    linked = bpy.data.objects[COPY]
    assert original_of_copy(linked, context.scene) == bpy.data.objects[NAME]
    assert find_bakeable(context.scene, [COPY], None, preview=False).kept == ()
    read_now(context.scene)
    rebake(bake)
    before = digest()
    for operator in (ops.radtex.update_copy, ops.radtex.delete_copy):
        with pytest.raises(RuntimeError, match="is of a linked file"):
            operator(object=COPY)
    assert differences(before, digest()) == {}
