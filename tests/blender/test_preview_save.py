# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""<name>.preview.blend: what is in it, and that the session it is saved from is left alone."""

from __future__ import annotations

import logging
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np
import pytest

from radtex_addon.core.errors import BakeError
from radtex_addon.core.sampler import Filter
from radtex_addon.preview import save
from radtex_addon.preview.material import preview_material
from radtex_addon.preview.save import FOLDER, StandIn, save_preview
from radtex_addon.scene.nodes import open_material, open_world
from tests.blender.lookup_stage import ENGINES, add_camera_above, render_exr, set_up_render, write_exr
from tests.lookups import LAYOUT

COLOUR = np.array([0.5, 0.25, 0.125, 1], np.float16)
UV_LAYER = "RadTex"


def new_object(name: str, collection: Any) -> Any:
    """An object with a square of its own, in the collection."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [], [(0, 1, 2, 3)])
    mesh.uv_layers.new(name=UV_LAYER)
    added = bpy.data.objects.new(name, mesh)
    collection.objects.link(added)
    return added


def current_scene() -> Any:
    return bpy.context.scene


@pytest.fixture
def pane() -> Any:
    """An object that much else uses: collections, a child, a constraint, a modifier, drivers, a property."""
    scene = current_scene()
    home, second = (bpy.data.collections.new(name) for name in ("home", "second"))
    for collection in (home, second):
        scene.collection.children.link(collection)
    before, pane, after = (new_object(name, home) for name in ("before", "pane", "after"))
    second.objects.link(pane)
    child = new_object("child", scene.collection)
    child.parent = pane
    child.location.z = -5
    child.constraints.new("DAMPED_TRACK").target = pane
    after.modifiers.new("wrap", "SHRINKWRAP").target = pane
    after.hide_render = before.hide_render = True
    after["friend"] = pane
    for driven in (after, pane):
        driver = driven.driver_add("color", 0).driver
        driver.variables.new().targets[0].id = pane
    pane.keyframe_insert("hide_render")
    pane.select_set(True)
    cast(Any, bpy.context.view_layer).objects.active = pane
    return pane


@pytest.fixture
def material(tmp_path: Path) -> bpy.types.Material:
    atlas = np.broadcast_to(COLOUR, (LAYOUT.pixel_height, LAYOUT.pixel_width, 4))
    path = write_exr(tmp_path / "out" / "pane.radiance.exr", atlas)
    return preview_material("RadTex pane", path, LAYOUT, UV_LAYER, Filter.QUADRILINEAR)


def baked_copy(original: Any, materials: int = 0) -> Any:
    copy = original.copy()
    copy.data = original.data.copy()
    copy.data.name = "baked"
    for _ in range(materials):
        copy.data.materials.append(bpy.data.materials.new("own"))
    return copy


def wear(item: Any, image: Any) -> None:
    """Give an object a material of its own that shows the image."""
    material, build = open_material(image.name)
    emission = build.node("ShaderNodeEmission", build.image(image, build.uv_map(UV_LAYER))[0])
    build.node("ShaderNodeOutputMaterial", emission.outputs[0])
    item.data.materials.append(material)


def state(pane: Any, copy: Any) -> dict[str, Any]:
    """What a user could find changed."""
    objects = bpy.data.objects
    return {
        "file": (bpy.data.filepath, bpy.data.is_dirty),
        "shown": (cast(Any, bpy.context.window).scene.name, cast(Any, bpy.context.view_layer).name),
        "objects": [(o.name, o.users, o.hide_render, o.hide_viewport) for o in objects],
        "members": {c.name: [o.name for o in c.objects] for c in bpy.data.collections},
        "selection": (
            pane.select_get(),
            pane.hide_get(),
            cast(Any, bpy.context.view_layer).objects.active == pane,
        ),
        "layers": [
            (found.name, found.exclude, found.hide_viewport)
            for layer in current_scene().view_layers
            for found in layer.layer_collection.children
        ],
        "referring": [
            objects["child"].parent == pane,
            cast(Any, objects["child"]).constraints[0].target == pane,
            cast(Any, objects["after"]).modifiers[0].target == pane,
            objects["after"]["friend"] == pane,
            *(driver_target(objects[name]) == pane for name in ("after", "pane")),
        ],
        "images": [(i.name, i.filepath, i.is_dirty, list(cast(Any, i).pixels[:4])) for i in bpy.data.images],
        "data": [len(getattr(bpy.data, kind)) for kind in ("meshes", "materials", "node_groups", "scenes")],
        "slots": [(slot.link, slot.material) for slot in copy.material_slots],
        "copy": (copy.name, copy.users, list(copy.data.materials)),
    }


def driver_target(driven: Any) -> Any:
    return driven.animation_data.drivers[0].driver.variables[0].targets[0].id


@pytest.mark.parametrize(("saved", "materials"), [(False, 2), (True, 0)])
def test_the_copy_stands_in_the_object_s_place(
    pane: Any, material: bpy.types.Material, tmp_path: Path, saved: bool, materials: int
) -> None:
    if saved:
        bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "user.blend"))
    path = tmp_path / "out" / "pane.preview.blend"
    save_preview(current_scene(), [StandIn(pane, baked_copy(pane, materials), (material,))], path)
    assert sorted(p.name for p in path.parent.iterdir()) == ["pane.preview.blend", "pane.radiance.exr"]
    bpy.ops.wm.open_mainfile(filepath=str(path))
    objects = cast(Any, bpy.data.objects)
    stood = objects["pane"]
    assert stood.data.name == "baked"
    assert {slot.material.name for slot in stood.material_slots} == {"RadTex pane"}
    assert [o.name for o in bpy.data.collections["home"].objects] == ["before", "pane", "after"]
    assert "pane" in bpy.data.collections["second"].objects
    assert sorted(o.name for o in objects) == ["after", "before", "child", "pane"]
    assert objects["child"].parent == stood
    assert objects["child"].constraints[0].target == stood
    assert objects["after"].modifiers[0].target == stood
    assert driver_target(stood) == driver_target(objects["after"]) == stood
    assert [image.filepath for image in bpy.data.images] == ["//pane.radiance.exr"]


@pytest.mark.parametrize("engine", ENGINES.values(), ids=ENGINES)
def test_the_file_shows_the_preview_wherever_its_folder_goes(
    pane: Any, material: bpy.types.Material, tmp_path: Path, engine: str
) -> None:
    path = tmp_path / "out" / "pane.preview.blend"
    add_camera_above(current_scene(), (0, 0), (2, 2), 8)
    save_preview(current_scene(), [StandIn(pane, baked_copy(pane), (material,))], path)
    moved = shutil.move(path.parent, tmp_path / "elsewhere")
    bpy.ops.wm.open_mainfile(filepath=str(Path(moved) / path.name))
    set_up_render(current_scene(), engine)
    image = render_exr(current_scene(), tmp_path / "view.exr")
    np.testing.assert_allclose(image, np.broadcast_to(COLOUR, image.shape), rtol=1e-3)


@pytest.mark.parametrize("saved", [False, True], ids=["a file never saved", "a saved file"])
def test_the_session_is_left_as_it_was(
    pane: Any, material: bpy.types.Material, tmp_path: Path, saved: bool, caplog: pytest.LogCaptureFixture
) -> None:
    if saved:
        bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "user.blend"))
    painted = cast(Any, bpy.data.images.new("painted", 2, 2))
    painted.pixels[0] = 0.5
    painted.update()
    wear(bpy.data.objects["child"], painted)
    other = bpy.data.scenes.new("other")
    other.collection.objects.link(pane)
    other.collection.objects.link(bpy.data.objects["child"])
    copy = baked_copy(pane)
    before = state(pane, copy)
    with caplog.at_level(logging.WARNING):
        save_preview(other, [StandIn(pane, copy, (material,))], tmp_path / "out" / "pane.preview.blend")
    assert state(pane, copy) == before
    assert "image 'painted' has unsaved changes" in caplog.text
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "out" / "pane.preview.blend"))
    assert current_scene().name == "other"


def test_a_file_that_cannot_be_written_leaves_the_session_as_it_was(
    pane: Any, material: bpy.types.Material, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    @contextmanager
    def nowhere(path: Path) -> Iterator[Path]:
        yield tmp_path / "no such folder" / path.name

    monkeypatch.setattr(save, "replacing", nowhere)
    copy = baked_copy(pane, 1)
    before = state(pane, copy)
    path = tmp_path / "out" / "pane.preview.blend"
    with pytest.raises(BakeError, match=r"pane\.preview\.blend could not be written: "):
        save_preview(current_scene(), [StandIn(pane, copy, (material,))], path)
    assert state(pane, copy) == before


@pytest.fixture
def crowded(pane: Any, tmp_path: Path) -> Any:
    """Around the pane, what a session holds besides: hidden objects, another scene, texts, fake users."""
    scene = current_scene()
    store = bpy.data.collections.new("store")
    bpy.data.collections["home"].children.link(store)
    for name in ("high", "cutter", "seen"):
        new_object(name, store).hide_render = name != "seen"
    for name in ("high", "cutter"):
        bpy.data.objects[name].hide_viewport = True
    cut = cast(Any, bpy.data.objects["child"]).modifiers.new("cut", "BOOLEAN")
    cut.object = bpy.data.objects["cutter"]
    new_object("elsewhere", bpy.data.scenes.new("a second scene").collection)
    bpy.data.texts.new("notes").use_fake_user = True
    comparison = bpy.data.images.new("RadTex Difference", 2, 2)
    comparison.use_fake_user = True
    scene.tool_settings.image_paint.canvas = comparison
    scene["chosen"] = bpy.data.objects["high"]
    frames = cast(Any, bpy.data.objects["seen"]).driver_add("location", 0).driver.variables.new().targets[0]
    frames.id_type, frames.id = "SCENE", scene
    wear(pane, bpy.data.images.new("the original's", 2, 2))
    bpy.data.objects["seen"].hide_set(True)
    scene.view_layers[0].layer_collection.children["second"].hide_viewport = True
    return pane


def test_the_file_holds_what_the_scene_shows_alone(
    crowded: Any, material: bpy.types.Material, tmp_path: Path
) -> None:
    path = tmp_path / "out" / "pane.preview.blend"
    copy = baked_copy(crowded)
    before = state(crowded, copy)
    save_preview(current_scene(), [StandIn(crowded, copy, (material,))], path)
    assert state(crowded, copy) == before
    assert cast(Any, current_scene())["chosen"].name == "high"
    bpy.ops.wm.open_mainfile(filepath=str(path))
    assert [scene.name for scene in bpy.data.scenes] == ["Scene"]
    assert sorted(o.name for o in bpy.data.objects) == ["after", "before", "child", "cutter", "pane", "seen"]
    assert [o.name for o in bpy.data.collections["store"].objects] == ["cutter", "seen"]
    assert bpy.data.objects["seen"].hide_get()
    shown = current_scene().view_layers[0].layer_collection.children
    assert [(one.name, one.hide_viewport) for one in shown] == [("home", False), ("second", True)]
    assert [image.name for image in bpy.data.images] == ["pane.radiance.exr"]
    assert sorted(mesh.name for mesh in bpy.data.meshes) == [
        "after",
        "baked",
        "before",
        "child",
        "cutter",
        "seen",
    ]
    assert not bpy.data.texts
    assert bpy.context.object == bpy.data.objects["pane"]


@pytest.mark.parametrize("follows", [True, False], ids=["a solved camera", "no camera"])
def test_the_clip_that_a_camera_follows_stays(
    pane: Any, material: bpy.types.Material, tmp_path: Path, follows: bool
) -> None:
    picture = bpy.data.images.new("frame", 4, 4)
    picture.filepath_raw, picture.file_format = str(tmp_path / "shot0001.png"), "PNG"
    picture.save()
    scene = current_scene()
    scene.active_clip = bpy.data.movieclips.load(str(tmp_path / "shot0001.png"))
    solved = cast(Any, bpy.data.objects["child"]).constraints.new("CAMERA_SOLVER")
    solved.use_active_clip = follows
    path = tmp_path / "pane.preview.blend"
    save_preview(scene, [StandIn(pane, baked_copy(pane), (material,))], path)
    assert scene.active_clip is not None
    bpy.ops.wm.open_mainfile(filepath=str(path))
    assert (current_scene().active_clip is not None) == follows


@pytest.mark.parametrize(("saved", "kept"), [(False, True), (True, False)])
def test_a_packed_hdri_is_stored_once_for_all_previews(
    pane: Any, material: bpy.types.Material, tmp_path: Path, saved: bool, kept: bool
) -> None:
    sky = write_exr(tmp_path / "sky.exr", np.random.default_rng(0).random((128, 256, 4), np.float32))
    packed = sky.read_bytes()
    if saved:
        bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "user.blend"))
    image = cast(Any, bpy.data.images.load(str(sky)))
    image.pack()
    if not kept:
        sky.unlink()
    world, build = open_world("outside")
    shown = build.node("ShaderNodeTexEnvironment", image=image).outputs[0]
    build.node("ShaderNodeOutputWorld", build.node("ShaderNodeBackground", shown).outputs[0])
    current_scene().world = world
    for name in ("pane", "again"):
        copy = baked_copy(pane)
        before = state(pane, copy)
        path = tmp_path / "out" / f"{name}.preview.blend"
        save_preview(current_scene(), [StandIn(pane, copy, (material,))], path)
        assert state(pane, copy) == before
        assert image.packed_file.data == packed
        assert path.stat().st_size < len(packed)
    stored = list((tmp_path / "out" / FOLDER).glob("*"))
    assert [found.read_bytes() for found in stored] == [] if kept else [packed]
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "out" / "again.preview.blend"))
    linked = cast(Any, bpy.data.images["sky.exr"])
    assert linked.packed_file is None
    assert Path(bpy.path.abspath(linked.filepath)).resolve() == (sky if kept else stored[0])
    assert linked.size[:] == (256, 128)
