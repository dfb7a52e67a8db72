# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene that is handed over arrives as it was on the screen; the session stays what it was."""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.cli.opening import open_scene
from radtex_addon.core.errors import BakeError, InputError
from radtex_addon.worker.handover import hand_over, jobs_folder, this_program
from radtex_addon.worker.order import Handover
from radtex_addon.worker.unsaved_images import load_unsaved, save_unsaved
from tests.blender import stage
from tests.blender.fingerprint import differences, fingerprint
from tests.blender.lived_in import lived_in_scene

context: Any = bpy.context  # to the stubs, every pointer may be None
blocks: Any = bpy.data


@pytest.fixture
def jobs(tmp_path: Path) -> Path:
    return tmp_path / "Aufträge für später"


def arrive(handover: Handover) -> None:
    """Open what was handed over, as a worker does."""
    bpy.ops.wm.open_mainfile(filepath=str(handover.blend), load_ui=False, use_scripts=False)
    if handover.images is not None:
        load_unsaved(handover.images)


def image(name: str, **options: bool) -> Any:
    made: Any = blocks.images.new(name, 4, 2, alpha=True, **options)
    made.use_fake_user = True
    return made


def shades(of: Any) -> Any:
    """A different value for every channel, each one exactly a byte."""
    width, height = of.size
    return (np.arange(width * height * 4) * 3 % 256 / 255).astype(np.float32)


def paint(of: Any) -> None:
    of.pixels.foreach_set(shades(of))
    of.update()
    assert of.is_dirty


def pixels(of: Any) -> Any:
    values = np.empty(of.size[0] * of.size[1] * 4, dtype=np.float32)
    of.pixels.foreach_get(values)
    return values


# the session


def images_state() -> dict[str, tuple[object, ...]]:
    return {
        each.name: (
            each.is_dirty,
            each.filepath_raw,
            each.source,
            len(each.packed_files),
            pixels(each).tobytes(),
        )
        for each in blocks.images
        if each.has_data and each.source != "VIEWER"
    }


@pytest.mark.parametrize("is_saved", [False, True])
def test_the_session_is_what_it_was(is_saved: bool, jobs: Path, tmp_path: Path) -> None:
    lived_in_scene()
    for name, floats, tiles in (("bytes", False, False), ("floats", True, False), ("tiles", False, True)):
        paint(image(name, float_buffer=floats, tiled=tiles))
    blocks.images["tiles"].save(filepath=str(tmp_path / "tiles.<UDIM>.png"), save_copy=True)  # not generated
    if is_saved:
        bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "mine.blend"))
    bpy.ops.ed.undo_push(message="a change")
    assert blocks.is_dirty
    before, files = fingerprint(), blocks.filepath
    images = images_state()
    handover = hand_over(context.scene, jobs)
    assert differences(before, fingerprint()) == {}
    assert images_state() == images
    assert (blocks.is_dirty, blocks.filepath) == (True, files)
    assert 0 < handover.stalled < 60


@pytest.mark.parametrize("compress", [False, True])
def test_the_users_file_stays_compressed_or_not(compress: bool, jobs: Path, tmp_path: Path) -> None:
    mine = tmp_path / "mine.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(mine), compress=compress)
    copy = hand_over(context.scene, jobs).blend  # Blender remembers the last choice, also that of a copy
    assert [path.read_bytes()[:4] == b"\x28\xb5\x2f\xfd" for path in (mine, copy)] == [compress] * 2


def test_other_add_ons_hear_of_no_saved_file_and_listen_again_afterwards(jobs: Path) -> None:
    heard: list[str] = []

    def hear(*_: Any) -> None:
        heard.append("saved")

    bpy.app.handlers.save_pre.append(hear)
    bpy.app.handlers.save_post.append(hear)
    hand_over(context.scene, jobs)
    assert heard == []
    assert hear in bpy.app.handlers.save_pre
    assert hear in bpy.app.handlers.save_post


# what arrives


def test_unsaved_changes_arrive_whatever_the_file_on_disk_says(jobs: Path, tmp_path: Path) -> None:
    bpy.ops.mesh.primitive_cube_add()
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "zimmer 1.blend"))
    context.object.name = "Würfel"
    context.object.location.x = 4
    handover = hand_over(context.scene, jobs)
    assert handover.blend.name == "zimmer 1.blend"
    assert handover.blend.is_relative_to(jobs)
    arrive(handover)
    assert blocks.objects["Würfel"].location.x == 4


def test_a_mesh_in_edit_mode_arrives_as_it_is_edited(jobs: Path) -> None:
    bpy.ops.mesh.primitive_cube_add()
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.subdivide()
    handover = hand_over(context.scene, jobs)
    assert context.mode == "EDIT_MESH"
    arrive(handover)
    assert len(blocks.objects["Cube"].data.polygons) == 24


def generated(folder: Path) -> Any:
    return image("painted")


def of_floats(folder: Path) -> Any:
    made = image("painted", float_buffer=True)
    made.colorspace_settings.name = "Non-Color"
    return made


def of_a_file(folder: Path) -> Any:
    made = image("painted")
    made.filepath_raw, made.file_format = str(folder / "on disk.jpg"), "JPEG"
    made.save()
    return made


def of_a_file_that_went(folder: Path) -> Any:
    made = of_a_file(folder)
    paint(made)
    (folder / "on disk.jpg").unlink()
    return made


def packed(folder: Path) -> Any:
    made = image("painted")
    made.pixels[0] = 0.5
    made.pack()
    assert made.packed_file
    return made


def resized(folder: Path) -> Any:
    made = of_a_file(folder)
    made.scale(8, 4)
    return made


def tiled(folder: Path) -> Any:
    return image("painted", tiled=True)


@pytest.mark.parametrize(
    "kind",
    [generated, of_floats, of_a_file, of_a_file_that_went, packed, resized, tiled],
    ids=lambda f: f.__name__,
)
def test_a_painted_image_arrives_to_the_last_bit(
    kind: Callable[[Path], Any], jobs: Path, tmp_path: Path
) -> None:
    made = kind(tmp_path)
    paint(made)
    expected = pixels(made)
    size, space, floats = tuple(made.size), made.colorspace_settings.name, made.is_float
    handover = hand_over(context.scene, jobs)
    assert made.is_dirty
    arrive(handover)
    there = blocks.images["painted"]
    assert (tuple(there.size), there.colorspace_settings.name, there.is_float) == (size, space, floats)
    np.testing.assert_array_equal(pixels(there), expected)
    assert there.packed_files
    assert not there.is_dirty


def test_floats_beyond_one_arrive(jobs: Path) -> None:
    made = image("bright", float_buffer=True)
    made.pixels.foreach_set(np.linspace(-1, 1e4, 32).astype(np.float32))
    arrive(hand_over(context.scene, jobs))
    np.testing.assert_array_equal(
        pixels(blocks.images["bright"]), np.linspace(-1, 1e4, 32).astype(np.float32)
    )


def test_without_painted_images_none_travel(jobs: Path) -> None:
    image("plain")
    assert hand_over(context.scene, jobs).images is None


def linked_room(folder: Path) -> None:
    """A file in folder/scenes that uses, by relative paths, a library and a picture in folder/assets."""
    assets, scenes = folder / "assets", folder / "scenes"
    assets.mkdir()
    scenes.mkdir()
    picture = image("texture")
    picture.pixels.foreach_set(shades(picture))
    picture.filepath_raw, picture.file_format = str(assets / "Bild.png"), "PNG"
    picture.save()
    bpy.ops.mesh.primitive_cube_add()
    context.object.name = "Linked"
    made: Any = stage.material("picture", "ShaderNodeEmission")
    texture = made.node_tree.nodes.new("ShaderNodeTexImage")
    texture.image = picture
    made.node_tree.links.new(texture.outputs[0], made.node_tree.nodes["Emission"].inputs[0])
    context.object.data.materials.append(made)
    bpy.ops.wm.save_as_mainfile(filepath=str(assets / "library.blend"), relative_remap=True)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.ops.wm.save_as_mainfile(filepath=str(scenes / "room.blend"))
    with blocks.libraries.load(str(assets / "library.blend"), link=True, relative=True) as (_, wanted):
        wanted.objects = ["Linked"]
    context.scene.collection.objects.link(blocks.objects["Linked"])
    local = blocks.images.load(str(assets / "Bild.png"))
    local.name, local.use_fake_user = "local", True
    local.filepath = bpy.path.relpath(local.filepath)
    assert local.filepath.startswith("//")


def test_relative_paths_and_libraries_lead_where_they_led(jobs: Path, tmp_path: Path) -> None:
    linked_room(tmp_path)
    arrive(hand_over(context.scene, jobs))
    item = blocks.objects["Linked"]
    assert item.library is not None
    assert len(item.data.polygons) == 6
    for each in (blocks.images["local"], blocks.images["texture"]):
        assert (
            Path(bpy.path.abspath(each.filepath, library=each.library)).resolve()
            == tmp_path / "assets/Bild.png"
        )
        np.testing.assert_allclose(pixels(each), shades(each), atol=1e-6)


def test_a_painted_image_of_a_library_arrives(jobs: Path, tmp_path: Path) -> None:
    linked_room(tmp_path)
    linked = blocks.images["texture"]
    linked.pixels.foreach_set(1 - shades(linked))
    assert linked.is_dirty
    arrive(hand_over(context.scene, jobs))
    there = blocks.images["texture"]
    assert there.library is not None
    np.testing.assert_allclose(pixels(there), 1 - shades(there), atol=1e-6)


def test_one_of_several_scenes_is_opened_by_its_name(jobs: Path) -> None:
    other = blocks.scenes.new("Andere")
    other.use_fake_user = True
    handover = hand_over(other, jobs)
    scene = open_scene(handover.blend, demo=False, name=handover.scene)
    assert (scene.name, context.scene.name) == ("Andere", "Andere")
    with pytest.raises(InputError, match=r"^there is no scene 'None' in the file: it has 'Andere', 'Scene'$"):
        open_scene(None, demo=False, name="None")


# where it goes


def test_by_the_bpy_module_there_is_no_extension_and_no_blender(temporary: Path) -> None:
    assert jobs_folder() == temporary
    assert not this_program().is_blender


def test_a_folder_that_refuses_is_one_line_and_leaves_nothing(
    jobs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("mine")
    with pytest.raises(
        BakeError, match=r"nothing can be saved for a worker below .*file.*: choose another folder$"
    ) as raised:
        hand_over(context.scene, tmp_path / "file")
    assert "\n" not in str(raised.value)
    paint(image("painted"))
    monkeypatch.setattr(np, "save", refuse)
    with pytest.raises(BakeError, match="No space left"):
        hand_over(context.scene, jobs)
    assert list(jobs.iterdir()) == []


def refuse(*_: Any) -> None:
    raise OSError(28, "No space left on device")


def test_folders_that_a_dead_blender_left_go_and_others_stay(jobs: Path) -> None:
    kept = hand_over(context.scene, jobs).folder
    left = hand_over(context.scene, jobs).folder
    (jobs / "mine").mkdir()
    days_ago = time.time() - 3 * 86400
    for folder in (left, jobs / "mine"):
        os.utime(folder, (days_ago, days_ago))
    new = hand_over(context.scene, jobs).folder
    assert set(jobs.iterdir()) == {kept, new, jobs / "mine"}


def test_images_that_are_no_longer_there_are_one_line(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"holds no unsaved images .*: hand the scene over again$"):
        load_unsaved(tmp_path / "none")


# what is handed over is looked at: images are files of their own folder, caches are files


@pytest.fixture
def listed_images(tmp_path: Path) -> Path:
    image: Any = bpy.data.images.new("Paint", 3, 2)
    image.pixels = [0.5] * 24
    image.update()
    assert save_unsaved(tmp_path / "images")
    return tmp_path / "images"


@pytest.mark.one_blender
@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("file", "../secret.npy"),
        ("file", "/etc/passwd"),
        ("file", 7),
        ("name", None),
        ("tiled", "yes"),
        ("more", 1),
    ],
)
def test_a_list_that_leads_elsewhere_is_refused(key: str, value: Any, listed_images: Path) -> None:
    listed = listed_images / "images.json"
    (entry,) = json.loads(listed.read_text())
    listed.write_text(json.dumps([entry | {key: value}]))
    with pytest.raises(InputError, match=r"holds no unsaved images .*: hand the scene over again"):
        load_unsaved(listed_images)


@pytest.mark.one_blender
@pytest.mark.parametrize(
    "pixels",
    [
        np.zeros(3, np.uint8),
        np.zeros((2, 3, 9), np.uint8),
        np.zeros((0, 3, 4), np.uint8),
        np.zeros((2, 3, 4)),
    ],
)
def test_pixels_that_are_no_images_are_refused(pixels: Any, listed_images: Path) -> None:
    np.save(listed_images / "0.npy", pixels)
    with pytest.raises(InputError, match=r"holds no image"):
        load_unsaved(listed_images)


@pytest.mark.one_blender
@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such files")
@pytest.mark.parametrize("name", ["images.json", "0.npy"])
def test_a_pipe_is_not_waited_for(name: str, listed_images: Path) -> None:
    (listed_images / name).unlink()
    os.mkfifo(listed_images / name)
    with pytest.raises(InputError, match="pipe"):
        load_unsaved(listed_images)


@pytest.mark.one_blender
@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such files")
def test_of_a_cache_only_files_are_copied(tmp_path: Path) -> None:
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    caches = tmp_path / "blendcache_scene"
    (caches / "deep").mkdir(parents=True)
    (caches / "deep" / "1.bphys").write_bytes(b"cache")
    os.mkfifo(caches / "pipe")
    (caches / "endless").symlink_to("/dev/zero")
    scene: Any = bpy.context.scene
    handed = hand_over(scene, tmp_path / "jobs")
    copied = handed.folder / "blendcache_scene"
    files = [path.relative_to(copied).as_posix() for path in copied.rglob("*") if not path.is_dir()]
    assert files == ["deep/1.bphys"]
