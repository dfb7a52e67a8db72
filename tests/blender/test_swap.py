# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The preview in the user's scene: in the object's place, and gone without a trace."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.core.errors import FormatError, InputError, RadTexError
from radtex_addon.core.sampler import Filter
from radtex_addon.job import bake_object
from radtex_addon.preview.swap import Preview, is_on, original_of, originals_rendered, switch_off, switch_on
from radtex_addon.settings.spec import BakeSpec, Layout
from tests.blender import stage
from tests.blender.fingerprint import differences, fingerprint
from tests.blender.lived_in import lived_in_scene
from tests.blender.lookup_stage import render_exr, set_up_render
from tests.finished_bakes import finished_bake

context: Any = bpy.context  # to the stubs, every pointer may be None

PLAIN = BakeSpec(texels=16, bucket=2, samples=1)
LAYERED = BakeSpec(texels=16, samples=1, layout=Layout.LAYERED)
GLOW = (0.5, 0.25, 0.125)
NAME = "Ball"


def ball(name: str = NAME) -> Any:
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=2)
    made = context.object
    made.name = name
    made.data.materials.append(stage.material(name, "ShaderNodeEmission", Color=(*GLOW, 1)))
    return made


def bake_of(spec: BakeSpec, folder: Path) -> Path:
    """The sidecar of a finished bake of the ball, to read."""
    return finished_bake(folder, _bake, spec) / f"{NAME}.radiance.json"


def _bake(folder: Path, spec: BakeSpec) -> None:
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    ball()
    stage.hdri(stage.world())
    bake_object(context.scene, NAME, spec, folder, preview=Filter.QUADRILINEAR)


@pytest.fixture(scope="module")
def bakes(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Sidecars of bakes of one ball; not to be written to."""
    specs = {"plain": PLAIN, "layered": LAYERED}
    return {name: bake_of(spec, tmp_path_factory.mktemp(name)) for name, spec in specs.items()}


@pytest.fixture
def sidecar(bakes: dict[str, Path]) -> Path:
    # Of a module's first test the bakes are in the file.
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    return bakes["plain"]


@pytest.fixture
def spoilt(bakes: dict[str, Path], tmp_path: Path) -> Path:
    """The same, to be spoilt."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    shutil.copytree(bakes["plain"].parent, tmp_path / "bake")
    return tmp_path / "bake" / bakes["plain"].name


# What Blender finds out anew at some later time, after an undo, or when the same file is appended again.
DERIVED = (
    "particle_edit.object",
    "is_runtime_data",
    "node_tree.users",
    "library_weak_reference",
)


def digest() -> dict[str, object]:
    """The fingerprint of a file with a preview in it."""
    return {
        path: value
        for path, value in fingerprint().items()
        if not path.startswith("handlers") and not any(word in path for word in DERIVED)
    }


def object_called(name: str) -> Any:
    return bpy.data.objects[name]


def images() -> set[str]:
    return {Path(bpy.path.abspath(image.filepath)).name for image in bpy.data.images}


# in the file of another object's bake


def test_another_objects_preview_shows_the_object_itself(sidecar: Path, tmp_path: Path) -> None:
    original, other = ball(), ball("Other")
    other.location.x = 3
    context.view_layer.update()
    switch_on(original, sidecar)
    before = digest()
    made = bake_object(context.scene, "Other", PLAIN, tmp_path, preview=Filter.NEAREST)
    assert differences(before, digest()) == {}
    assert made.files.preview is not None
    bpy.ops.wm.open_mainfile(filepath=str(made.files.preview))
    assert sorted(item.name for item in bpy.data.objects) == ["Ball", "Other"]
    assert not object_called("Ball").hide_render
    assert not is_on(object_called("Ball"))
    assert images() == {"Other.radiance.exr"}


# on


def test_the_copy_stands_in_the_objects_place(sidecar: Path) -> None:
    original, other = ball(), ball("Other")
    home = bpy.data.collections.new("home")
    context.scene.collection.children.link(home)
    home.objects.link(original)
    original.parent, original.location = other, (1, 2, 3)
    original.visible_shadow, original["mine"] = False, 3
    original.select_set(True)
    context.view_layer.objects.active = original
    context.view_layer.update()
    place = np.array(original.matrix_world)
    copy: Any = switch_on(original, sidecar).copy
    context.view_layer.update()
    assert copy.name == "Ball (baked)"
    assert set(copy.users_collection) == set(original.users_collection)
    assert (copy.parent, copy.visible_shadow, copy["mine"]) == (other, False, 3)
    assert place[0, 3] == 1
    np.testing.assert_array_equal(copy.matrix_world, place)
    assert copy.select_get()
    assert context.view_layer.objects.active == copy
    assert not copy.hide_render
    assert copy.visible_get()
    assert original.hide_render
    assert not original.visible_get()
    assert not original.select_get()
    assert [slot.material.name for slot in copy.material_slots] == ["RadTex Ball"]
    assert images() == {"Ball.radiance.exr"}
    assert len(bpy.data.meshes) == 3
    assert len(bpy.data.materials) == 3
    assert is_on(original)
    assert is_on(copy)
    assert not is_on(other)
    assert original_of(copy) == original
    assert original_of(other) == other


@pytest.mark.parametrize(("layout", "saved"), [("plain", True), ("layered", False)])
def test_a_picture_of_the_preview_is_that_of_its_file(
    bakes: dict[str, Path], layout: str, saved: bool, tmp_path: Path
) -> None:
    bpy.ops.wm.open_mainfile(filepath=str(bakes[layout].with_name("Ball.preview.blend")))
    there = picture(tmp_path / "there.exr")
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    if saved:
        bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "user.blend"))
    original = ball()
    original.data.materials[0] = stage.material("red", "ShaderNodeEmission", Color=(1, 0, 0, 1))
    switch_on(original, bakes[layout])
    here = picture(tmp_path / "here.exr")
    np.testing.assert_array_equal(here, there)
    if layout == "plain":
        np.testing.assert_allclose(here[..., :3], np.broadcast_to(GLOW, (8, 8, 3)), rtol=1e-3)


def picture(path: Path) -> Any:
    """The ball from above, so near that nothing else is seen."""
    bpy.ops.object.camera_add(location=(0, 0, 5))
    scene = context.scene
    scene.camera = context.object
    scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", 0.5
    set_up_render(scene, "CYCLES")
    scene.render.resolution_x = scene.render.resolution_y = 8
    return render_exr(scene, path)


def test_on_once_more_shows_the_bake_anew(sidecar: Path) -> None:
    original = ball()
    before = fingerprint()
    switch_off(original)  # which does nothing
    assert differences(before, fingerprint()) == {}
    assert not switch_on(original, sidecar).moved
    switch_on(original, sidecar)
    assert [item.name for item in bpy.data.objects] == ["Ball", "Ball (baked)"]
    assert len(bpy.data.images) == 1
    switch_off(original)
    assert differences(before, fingerprint()) == {}
    original.location.x = 2
    context.view_layer.update()
    assert switch_on(original, sidecar).moved


# off


@pytest.mark.parametrize(("layout", "by_copy"), [("plain", True), ("layered", False)])
def test_on_and_off_leaves_no_trace(bakes: dict[str, Path], layout: str, by_copy: bool) -> None:
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    head = lived_in_scene()
    before = fingerprint()
    shown = switch_on(head, bakes[layout])
    assert len(bpy.data.objects) == len(before["objects"]) + 1  # type: ignore[arg-type]  # a list of objects
    switch_off(shown.copy if by_copy else head)
    assert differences(before, fingerprint()) == {}
    assert not is_on(head)


def test_while_on_nothing_else_changes(sidecar: Path) -> None:
    """Only what hides the object, and who is selected; and what the copy brings."""
    head = lived_in_scene()
    before = fingerprint()
    switch_on(head, sidecar)
    after = fingerprint()
    ours = ("(baked)", "RadTex", "Ball")
    changed = {
        path: values
        for path, values in differences(before, after).items()
        if path in before and not any(word in path for word in ours)
    }
    name = f"objects[{head.name}]"
    assert {path for path in changed if path.startswith(name)} == {
        f"{name}.hide_render",
        f"{name}.hide_viewport",
        f"{name}.users",
    } | {path for path in changed if path.startswith(name) and path.endswith("visible_in_viewport_get")}
    for path, (old, new) in changed.items():
        if path.startswith(name) or path.endswith((".active", ".active.name")):
            continue
        if isinstance(old, list):  # a list of all blocks of a kind: more of them, more users
            assert {entry[0] for entry in old} <= {entry[0] for entry in new}, path  # type: ignore[attr-defined]
        else:
            assert path.startswith(("scenes", "collections", "actions")), (path, old, new)


@pytest.mark.parametrize("flag", ["hide_render", "hide_viewport", "eye"])
def test_an_object_that_was_hidden_is_hidden_again(sidecar: Path, flag: str) -> None:
    original = ball()
    if flag == "eye":
        original.hide_set(True)
    else:
        setattr(original, flag, True)
    before = fingerprint()
    copy: Any = switch_on(original, sidecar).copy
    assert (copy.hide_render, copy.hide_viewport, copy.hide_get()) == (
        flag == "hide_render",
        flag == "hide_viewport",
        flag == "eye",
    )
    switch_off(original)
    assert differences(before, fingerprint()) == {}


def test_several_come_and_go_in_any_order(sidecar: Path) -> None:
    some = [ball(name) for name in ("Ball", "Other", "Third")]
    before = fingerprint()
    for item in some:
        switch_on(item, sidecar)
    assert len(bpy.data.images) == 3
    for item in (some[1], some[0], some[2]):
        switch_off(item)
        assert [is_on(other) for other in some].count(True) == sum(map(is_on, some))
    assert differences(before, fingerprint()) == {}


def test_selection_goes_along(sidecar: Path) -> None:
    first, second = ball("First"), ball("Second")
    first.select_set(False)
    copies: list[Any] = [switch_on(item, sidecar).copy for item in (first, second)]
    assert [copy.select_get() for copy in copies] == [False, True]
    copies[0].select_set(True)
    context.view_layer.objects.active = copies[0]
    for copy in copies:
        switch_off(copy)
    assert first.select_get()
    assert second.select_get()
    assert context.view_layer.objects.active == first


def test_what_is_used_elsewhere_by_now_stays(sidecar: Path) -> None:
    original, other = ball(), ball("Other")
    copy: Any = switch_on(original, sidecar).copy
    material = copy.material_slots[0].material
    other.data.materials[0] = material
    switch_off(original)
    assert other.data.materials[0] == material
    assert images() == {"Ball.radiance.exr"}
    other.data.materials.clear()
    switch_on(original, sidecar)
    switch_off(original)
    assert images() == set()


# what happens meanwhile


def test_renamed_objects_find_each_other(sidecar: Path) -> None:
    original = ball()
    copy = switch_on(original, sidecar).copy
    original.name, copy.name = "Kugel", "Bild"
    ball(NAME)
    assert original_of(copy) == original
    switch_off(original)
    assert {item.name for item in bpy.data.objects} == {"Kugel", "Ball"}
    assert not original.hide_render


@pytest.mark.parametrize("by_hand", [False, True], ids=["by a script", "by the user"])
def test_a_deleted_copy_gives_the_object_back(sidecar: Path, by_hand: bool) -> None:
    original = ball()
    copy = switch_on(original, sidecar).copy
    if by_hand:
        bpy.ops.object.delete()
    else:
        bpy.data.objects.remove(copy)
    assert is_on(original)
    switch_off(original)
    assert not is_on(original)
    assert not original.hide_render
    assert not original.hide_viewport
    assert [item.name for item in bpy.data.objects] == [NAME]
    assert images() == set()


@pytest.mark.parametrize("by_hand", [False, True], ids=["by a script", "by the user"])
def test_a_deleted_object_stays_deleted(sidecar: Path, by_hand: bool) -> None:
    original = ball()
    copy = switch_on(original, sidecar).copy
    if by_hand:
        with context.temp_override(selected_objects=[original]):
            bpy.ops.object.delete()
        assert not original.users_collection
    else:
        bpy.data.objects.remove(original)
    assert is_on(copy)
    assert original_of(copy) is None
    switch_off(copy)
    assert list(bpy.data.objects) == []


def test_duplicates_are_the_users_own(sidecar: Path) -> None:
    original = ball()
    copy = switch_on(original, sidecar).copy
    again: list[Any] = [item.copy() for item in (original, copy)]
    for item in again:
        context.scene.collection.objects.link(item)
        assert not is_on(item)
        assert original_of(item) == item
    switch_off(original)
    assert [item.name for item in again] == ["Ball.001", "Ball (baked).001"]
    switch_on(again[0], sidecar)  # it was hidden, as what it was made of
    switch_off(again[0])
    assert not again[0].hide_render


def test_a_saved_file_knows_its_previews(sidecar: Path, tmp_path: Path) -> None:
    switch_on(ball(), sidecar)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "user.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "user.blend"))
    original = object_called(NAME)
    assert is_on(original)
    switch_off(original)
    assert not original.hide_render
    assert [item.name for item in bpy.data.objects] == [NAME]
    assert images() == set()


def test_undo_and_redo_go_through_on_and_off(sidecar: Path) -> None:
    lived_in_scene()
    name = context.object.name
    states = []

    def step(act: Callable[[Any], object] | None = None) -> None:
        if act is not None:
            act(object_called(name))
        bpy.ops.ed.undo_push(message="RadTex")
        states.append(digest())

    step()
    step(lambda item: switch_on(item, sidecar))
    step(switch_off)
    for state in (states[1], states[0]):
        bpy.ops.ed.undo()
        assert differences(state, digest()) == {}
    for state in (states[1], states[2]):
        bpy.ops.ed.redo()
        assert differences(state, digest()) == {}
    bpy.ops.ed.undo()
    switch_off(object_called(name))
    assert differences(states[0], digest()) == {}


# for renders


def test_originals_can_be_rendered_meanwhile(sidecar: Path) -> None:
    original, hidden = ball(), ball("Hidden")
    hidden.hide_render = True
    shown: list[Preview] = [switch_on(item, sidecar) for item in (original, hidden)]
    before = digest()
    with originals_rendered([original, hidden, shown[0].copy]):
        assert [item.hide_render for item in (original, hidden)] == [False, True]
        assert all(one.copy.hide_render for one in shown)
    assert differences(before, digest()) == {}


# libraries


@pytest.fixture
def linked(sidecar: Path, tmp_path: Path) -> Any:
    """A collection linked into an empty file, with a ball in it."""
    made = ball()
    home = bpy.data.collections.new("home")
    context.scene.collection.children.link(home)
    home.objects.link(made)
    context.scene.collection.objects.unlink(made)
    path = tmp_path / "library.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    libraries: Any = bpy.data.libraries
    with libraries.load(str(path), link=True) as (_, wanted):
        wanted.collections = ["home"]
    context.scene.collection.children.link(wanted.collections[0])
    context.view_layer.update()
    return wanted.collections[0]


def test_a_linked_object_is_refused(linked: Any, sidecar: Path) -> None:
    before = fingerprint()
    with pytest.raises(InputError, match=r"linked from library\.blend.*make a library override"):
        switch_on(linked.objects[0], sidecar)
    assert differences(before, fingerprint()) == {}


@pytest.mark.parametrize("saved", [False, True], ids=["at once", "in a file saved meanwhile"])
def test_an_override_is_hidden_and_shown_again(
    linked: Any, sidecar: Path, saved: bool, tmp_path: Path
) -> None:
    linked.override_hierarchy_create(context.scene, context.view_layer)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "user.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "user.blend"))
    before = fingerprint()
    copy: Any = switch_on(_override(), sidecar).copy
    assert copy.override_library is None
    assert copy.name in context.scene.collection.objects
    if saved:
        bpy.ops.wm.save_mainfile()
        bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "user.blend"))
    assert is_on(_override())
    assert _override().hide_render
    switch_off(_override())
    assert not is_on(_override())
    if saved:
        assert not _override().hide_render
        assert len(bpy.data.objects) == len(before["objects"])  # type: ignore[arg-type]  # a list
    else:  # Blender counts a removed copy as one who uses the linked object, until the file is opened again
        changed = differences(before, fingerprint())
        assert {path for path in changed if not path.endswith(".users")} == {"objects"}


def _override() -> Any:
    return next(
        item for item in context.scene.objects if item.override_library and "radtex_original" not in item
    )


# refusals


def _no_atlas(sidecar: Path) -> None:
    sidecar.with_suffix(".exr").unlink()


def _damaged(sidecar: Path) -> None:
    sidecar.with_suffix(".exr").write_bytes(b"none")


def _no_preview(sidecar: Path) -> None:
    sidecar.with_name("Ball.preview.blend").unlink()


def _no_blend(sidecar: Path) -> None:
    sidecar.with_name("Ball.preview.blend").write_bytes(b"none")


def _no_sidecar(sidecar: Path) -> None:
    sidecar.unlink()


def _other_object(sidecar: Path) -> None:
    sidecar.write_text(sidecar.read_text().replace('"Ball"', '"Cube"'))


def _other_layer(sidecar: Path) -> None:
    sidecar.write_text(sidecar.read_text().replace('"uv_map": "RadTex"', '"uv_map": "Mine"'))


@pytest.mark.parametrize(
    ("spoil", "shown", "kind", "words"),
    [
        (_no_atlas, True, InputError, r"Ball\.radiance\.exr is missing.*put it back, or bake again"),
        (_damaged, False, FormatError, r"Ball\.radiance\.exr: Blender reads no image in it; bake again"),
        (_no_preview, False, InputError, r"Ball\.preview\.blend is missing.*bake again with a preview"),
        (_no_blend, False, FormatError, r"Ball\.preview\.blend is no \.blend that this Blender reads"),
        (_no_sidecar, False, FormatError, r"Ball\.radiance\.json cannot be read"),
        (_other_object, False, FormatError, r"Ball\.preview\.blend holds no mesh 'Cube'"),
        (_other_layer, False, FormatError, r"of another bake than its sidecar"),
    ],
)
def test_files_that_are_missing_or_spoilt_are_named(
    spoil: Callable[[Path], None], shown: bool, kind: type[RadTexError], words: str, spoilt: Path
) -> None:
    original = ball()
    if shown:
        switch_on(original, spoilt)
    spoil(spoilt)
    before = digest()
    with pytest.raises(kind, match=words) as refused:
        switch_on(original, spoilt)
    assert "\n" not in str(refused.value)
    assert differences(before, digest()) == {}


def _edited(item: Any) -> None:
    bpy.ops.object.mode_set(mode="EDIT")


def _animated(item: Any) -> None:
    item.keyframe_insert("hide_render")


def _driven(item: Any) -> None:
    item.driver_add("hide_viewport")


def _nowhere(item: Any) -> None:
    context.scene.collection.objects.unlink(item)


@pytest.mark.parametrize(
    ("prepare", "words"),
    [
        (_edited, "is being edited: go back to Object Mode"),
        (_animated, "has animated visibility"),
        (_driven, "has animated visibility"),
        (_nowhere, "is in no scene"),
    ],
)
def test_objects_that_cannot_be_replaced_are_named(
    prepare: Callable[[Any], None], words: str, sidecar: Path
) -> None:
    original = ball()
    prepare(original)
    before = fingerprint()
    with pytest.raises(InputError, match=words):
        switch_on(original, sidecar)
    assert differences(before, fingerprint()) == {}


def test_a_lamp_is_refused(sidecar: Path) -> None:
    bpy.ops.object.light_add()
    with pytest.raises(InputError, match="is no mesh"):
        switch_on(context.object, sidecar)


def test_a_rigid_bodys_copy_does_not_fall(sidecar: Path) -> None:
    original = ball()
    bpy.ops.rigidbody.object_add()
    before = fingerprint()
    copy = switch_on(original, sidecar).copy
    bodies = context.scene.rigidbody_world.collection.objects
    assert list(bodies) == [original]
    assert list(copy.users_collection) == [context.scene.collection]
    switch_off(original)
    assert differences(before, fingerprint()) == {}


@pytest.mark.skipif(os.sep != "/", reason="no name there has a backslash")
def test_a_bake_renamed_with_a_backslash_says_what_is_wrong(spoilt: Path) -> None:
    for path in spoilt.parent.iterdir():
        path.rename(path.with_name(path.name.replace(NAME, "A\\B")))
    renamed = spoilt.with_name(spoilt.name.replace(NAME, "A\\B"))
    original = ball()
    before = fingerprint()
    with pytest.raises(InputError, match=r"A\\B.preview.blend: Blender takes a backslash for a slash"):
        switch_on(original, renamed)
    assert differences(before, fingerprint()) == {}
