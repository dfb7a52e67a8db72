# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the window offers after a bake, by keyword arguments: preview, comparison, export."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import bpy
import numpy as np
import pytest
from mathutils import Matrix

from radtex_addon.core.sampler import Filter
from radtex_addon.job import bake_object
from radtex_addon.preview.swap import is_on
from radtex_addon.report.shown import bakes_of
from radtex_addon.report.side_by_side import ComparisonSpec
from radtex_addon.report.viewpoint import Viewpoint
from radtex_addon.settings.spec import BakeSpec, Kind
from radtex_addon.textures.export_spec import Arrangement, ExportSpec, Target, TextureFormat
from radtex_addon.ui import registration
from radtex_addon.ui.jobs import jobs
from radtex_addon.ui.jobs.comparison import BAKED, DIFFERENCE, TRACED, figures
from radtex_addon.ui.operators.compare_operator import RADTEX_OT_compare, submit
from radtex_addon.ui.operators.export_operator import ARRANGEMENTS, FORMATS
from radtex_addon.ui.operators.export_sources import Place, submit_scene
from radtex_addon.ui.operators.export_sources import submit as export
from radtex_addon.ui.panel import panel_state
from radtex_addon.ui.panel.finished_panel import RADTEX_PT_afterwards
from radtex_addon.ui.panel.jobs_panel import job_title
from radtex_addon.ui.panel.main_panel import RADTEX_PT_bake
from tests.blender import stage
from tests.blender.fingerprint import differences, fingerprint
from tests.blender.recorded_layout import RecordedLayout
from tests.blender.test_swap import GLOW, NAME, PLAIN, bake_of, ball, digest
from tests.blender.ui_stage import finish_jobs

context: Any = bpy.context  # to the stubs, every pointer may be None
radtex: Any = bpy.ops.radtex  # type: ignore[attr-defined]  # ours, not Blender's


@pytest.fixture(scope="module")
def baked(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The sidecar of a bake; not to be written to."""
    return bake_of(PLAIN, tmp_path_factory.mktemp("baked"))


@pytest.fixture
def bake(baked: Path, tmp_path: Path) -> str:
    """The folder of a bake, as an operator takes it, in an empty file."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    return str(shutil.copytree(baked.parent, tmp_path / "bake"))


@pytest.fixture(autouse=True)
def registered(bake: str) -> Iterator[None]:
    registration.register()
    yield
    registration.unregister()


def scene_with_balls(*names: str) -> list[Any]:
    """Balls side by side, the last one selected and active, and a camera above the first."""
    made = [ball(name) for name in names or (NAME,)]
    for place, item in enumerate(made):
        item.location.x = 3 * place
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location.z = 5
    context.scene.collection.objects.link(camera)
    context.scene.camera = camera
    context.view_layer.update()
    return made


# preview


def test_selected_objects_are_toggled(bake: str) -> None:
    (item,) = scene_with_balls()
    before = fingerprint()
    assert radtex.preview_toggle(bake=bake) == {"FINISHED"}
    assert is_on(item)
    assert context.active_object.name == "Ball (baked)"
    radtex.preview_toggle(bake=bake)
    assert differences(before, fingerprint()) == {}


def test_an_object_can_be_named_and_the_folder_be_the_scenes(bake: str) -> None:
    items = scene_with_balls(NAME, "Other")
    context.scene.radtex.directory = bake
    for action in ("ON", "ON"):
        radtex.preview_toggle(object=NAME, action=action)
        assert [is_on(item) for item in items] == [True, False]
    for action in ("OFF", "OFF"):
        radtex.preview_toggle(object=NAME, action=action)
        assert not is_on(items[0])


def test_of_several_those_that_were_baked_are_shown(bake: str) -> None:
    items = scene_with_balls(NAME, "Other")
    for item in items:
        item.select_set(True)
    radtex.preview_toggle(bake=bake)
    assert [is_on(item) for item in items] == [True, False]
    radtex.preview_toggle(bake=str(Path(bake) / "Ball.radiance.json"))
    assert [is_on(item) for item in items] == [True, True]
    radtex.preview_toggle()
    assert [is_on(item) for item in items] == [False, False]


@pytest.mark.parametrize("shading", ["SOLID", "MATERIAL"])
def test_showing_a_bake_moves_no_button(bake: str, shading: str, capfd: pytest.CaptureFixture[str]) -> None:
    """What the panels drew before is still there, in the same places; what is new comes below."""
    scene_with_balls()
    context.scene.radtex.directory = bake
    (area,) = [one for one in context.window_manager.windows[0].screen.areas if one.type == "VIEW_3D"]
    area.spaces.active.shading.type = shading
    with context.temp_override(window=context.window_manager.windows[0], area=area):
        before = [drawn(panel).texts for panel in (RADTEX_PT_bake, RADTEX_PT_afterwards)]
        radtex.preview_toggle()
        main, finished = (drawn(panel) for panel in (RADTEX_PT_bake, RADTEX_PT_afterwards))
    assert main.texts == before[0]
    assert finished.texts == before[1]
    blind = shading == "SOLID"
    assert " ".join(main.texts).count("Solid shows no bake.") == blind
    shadings = [text for text in main.texts if text in ("Material Preview", "Rendered")]
    assert shadings == (["Material Preview", "Rendered"] if blind else [])
    told = main.texts.index("It has a bake: that will be replaced")
    below = main.texts[main.texts.index("Preview Bake") + 1 : told]
    assert below[-2:-1] == ["Rendered"] * blind, (
        "right below Preview Bake, but for the time that a bake takes"
    )
    assert ("Shade the view by Material Preview or Rendered" in capfd.readouterr().out) == blind


def test_each_panel_is_about_its_own_view(bake: str, capfd: pytest.CaptureFixture[str]) -> None:
    """Only the view whose panel it is counts; in another editor, one view that shows materials is enough."""
    scene_with_balls()
    context.scene.radtex.directory = bake
    window = context.window_manager.windows[0]
    for area, kind in zip(window.screen.areas, ("VIEW_3D", "VIEW_3D", "OUTLINER"), strict=False):
        area.type = kind
    solid, rendered, other = list(window.screen.areas)[:3]
    solid.spaces.active.shading.type, rendered.spaces.active.shading.type = "SOLID", "RENDERED"
    told = "Shade the view by Material Preview or Rendered"
    for area, blind in ((solid, True), (rendered, False), (other, False)):
        with context.temp_override(window=window, area=area):
            assert ("Rendered" in drawn(RADTEX_PT_bake).texts) == blind
            radtex.preview_toggle(action="ON")
        assert (told in capfd.readouterr().out) == blind
    rendered.spaces.active.shading.type = "WIREFRAME"
    with context.temp_override(window=window, area=other):
        radtex.preview_toggle(action="ON")
    assert told in capfd.readouterr().out
    with context.temp_override(window=window, area=rendered):
        assert any("Wireframe shows" in text for text in drawn(RADTEX_PT_bake).texts)


def test_where_nothing_is_baked_the_panel_says_so(bake: str, tmp_path: Path) -> None:
    scene_with_balls()
    told = "Nothing of it is baked yet"
    context.scene.radtex.directory = str(tmp_path)
    assert drawn(RADTEX_PT_afterwards).texts[-1] == told
    context.scene.radtex.directory = bake
    assert told not in drawn(RADTEX_PT_afterwards).texts
    context.scene.radtex.directory = str(tmp_path)
    radtex.preview_toggle(bake=bake)  # another folder's
    assert told not in drawn(RADTEX_PT_afterwards).texts


def drawn(panel: Any) -> RecordedLayout:
    """What a panel draws, once it has thought about the scene."""
    panel_state.refresh(context.scene, context.view_layer)
    layout = RecordedLayout()
    panel.draw(SimpleNamespace(layout=layout), context)
    return layout


@pytest.mark.parametrize("how", [("EXEC_DEFAULT", True), ()], ids=["a press", "a script's call"])
def test_each_press_is_one_step_to_undo(bake: str, how: tuple[object, ...]) -> None:
    scene_with_balls()
    bpy.ops.ed.undo_push(message="before")
    before = digest()
    radtex.preview_toggle(*how, bake=bake)
    after = digest()
    bpy.ops.ed.undo()
    assert differences(before, digest()) == {}
    bpy.ops.ed.redo()
    assert differences(after, digest()) == {}


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"object": "Kugel"}, "No object 'Kugel' in view layer"),
        ({"object": "Other"}, "holds no bake of 'Other'"),
        ({"object": NAME, "bake": "/nowhere"}, "There is no /nowhere"),
        ({"object": "Camera"}, "'Camera'"),
        ({}, "No mesh object is selected"),
    ],
)
def test_what_cannot_be_shown_is_said_and_nothing_changes(
    arguments: dict[str, str], words: str, bake: str
) -> None:
    for item in scene_with_balls(NAME, "Other"):
        item.select_set(False)
    context.view_layer.objects.active = None
    before = fingerprint()
    with pytest.raises(RuntimeError, match=words):
        radtex.preview_toggle(**{"bake": bake} | arguments)
    assert differences(before, fingerprint()) == {}


def test_one_that_fails_takes_the_others_back(bake: str) -> None:
    items = scene_with_balls(NAME, "Other")
    items[1].keyframe_insert("hide_render")
    for item in items:
        item.select_set(True)
    context.view_layer.update()
    before = fingerprint()
    with pytest.raises(RuntimeError, match="'Other' has animated visibility"):
        radtex.preview_toggle(bake=str(Path(bake) / "Ball.radiance.json"))
    assert differences(before, fingerprint()) == {}


@pytest.mark.parametrize("name", ["preview_toggle", "compare", "export"])
def test_in_edit_mode_buttons_are_grey(name: str) -> None:
    scene_with_balls()
    operator = getattr(radtex, name)
    assert operator.poll()
    bpy.ops.object.mode_set(mode="EDIT")
    assert not operator.poll()


# comparison


def pixels(name: str) -> Any:
    image: Any = bpy.data.images[name]
    return np.array(image.pixels).reshape(image.size[1], image.size[0], 4)


@pytest.mark.parametrize("on", [False, True], ids=["its preview off", "its preview on"])
def test_a_glowing_ball_looks_as_it_was_baked(bake: str, on: bool) -> None:
    (item,) = scene_with_balls()
    stage.world((0.1, 0.1, 0.1))
    context.scene.render.resolution_x, context.scene.render.resolution_y = 200, 100
    if on:
        radtex.preview_toggle(bake=bake)
    before = digest()
    radtex.compare(bake="" if on else bake, object=NAME, pixels=64, samples=4)
    changed = {path for path in differences(before, digest()) if not path.startswith("images")}
    assert changed == set()
    assert is_on(item) == on
    traced, shown, difference = (pixels(name) for name in (TRACED, BAKED, DIFFERENCE))
    assert traced.shape == shown.shape == difference.shape == (32, 64, 4)
    for picture in (traced, shown):
        np.testing.assert_allclose(picture[16, 32, :3], GLOW, rtol=0.02)
        np.testing.assert_allclose(picture[2, 2, :3], 0.1, rtol=0.02)
    assert difference[..., :3].max() < 0.2


def test_the_difference_is_four_times_what_a_display_shows(bake: str) -> None:
    (item,) = scene_with_balls()
    stage.world((0.1, 0.1, 0.1))
    item.data.materials[0] = stage.material("dim", "ShaderNodeEmission", Color=(0.25, 0.25, 0.125, 1))
    radtex.compare(bake=bake, pixels=32, samples=4)
    expected = min(1, 4 * (0.5 ** (1 / 2.2) - 0.25 ** (1 / 2.2)))
    np.testing.assert_allclose(pixels(DIFFERENCE)[9, 16, :3], (expected, 0, 0), atol=0.03)


def test_a_second_comparison_takes_the_place_of_the_first(bake: str) -> None:
    scene_with_balls()
    radtex.compare(bake=bake, pixels=32, samples=1)
    texture: Any = stage.material("wall", "ShaderNodeEmission").node_tree.nodes.new("ShaderNodeTexImage")
    texture.image = bpy.data.images[TRACED]
    radtex.compare(bake=bake, pixels=48, samples=1)
    assert ours() == [BAKED, DIFFERENCE, TRACED]
    assert texture.image == bpy.data.images[TRACED]
    assert tuple(texture.image.size) == (48, 27)
    np.testing.assert_allclose(pixels(TRACED)[13, 24, :3], GLOW, rtol=0.02)


def test_a_comparison_is_one_step_to_undo(bake: str) -> None:
    scene_with_balls()
    bpy.ops.ed.undo_push(message="before")
    before = digest()
    radtex.compare("EXEC_DEFAULT", True, bake=bake, pixels=32, samples=1)
    bpy.ops.ed.undo()
    assert differences(before, digest()) == {}
    bpy.ops.ed.redo()
    np.testing.assert_allclose(pixels(TRACED)[9, 16, :3], GLOW, rtol=0.02)


def test_a_view_can_be_given_by_its_matrices(bake: str) -> None:
    (item,) = scene_with_balls()
    context.scene.camera = None
    item.location = (7, 0, 0)
    context.view_layer.update()
    view = Matrix.Translation((7, 0, 5)).inverted()
    window = np.diag([0.5, 1.0, -0.002, 1.0])  # orthographic, 4 x 2, 500 behind and before the viewer
    arguments = {
        "view_matrix": [value for row in view for value in row],
        "window_matrix": window.ravel().tolist(),
    }
    radtex.compare(bake=bake, pixels=64, samples=1, **arguments)
    picture = pixels(TRACED)
    assert picture.shape == (32, 64, 4)
    np.testing.assert_allclose(picture[16, 32, :3], GLOW, rtol=0.02)
    np.testing.assert_allclose(picture[16, 43, :3], GLOW, rtol=0.05)
    assert picture[16, 51, :3].max() < 0.02


@pytest.mark.parametrize(
    ("prepare", "words"),
    [
        (lambda scene: setattr(scene.camera, "rotation_euler", (3, 0, 0)), "'Ball': not seen from here"),
        (lambda scene: setattr(scene, "camera", None), "has no camera: add one, or look at the object"),
        (lambda scene: setattr(scene.camera.data, "type", "PANO"), "is panoramic"),
    ],
    ids=["looking away", "no camera", "panorama"],
)
def test_views_that_show_nothing_are_refused(prepare: Any, words: str, bake: str) -> None:
    scene_with_balls()
    prepare(context.scene)
    context.view_layer.update()
    before = digest()
    with pytest.raises(RuntimeError, match=words):
        radtex.compare(bake=bake, pixels=32, samples=1)
    assert differences(before, digest()) == {}


def test_the_dialog_asks_for_no_names() -> None:
    """The button that opened it has chosen the object and the bake."""
    drawn = RecordedLayout()
    operator = SimpleNamespace(layout=drawn, bl_rna=radtex.compare.get_rna_type())
    RADTEX_OT_compare.draw(operator, context)  # type: ignore[arg-type]  # Blender makes operators itself
    assert drawn.settings == ["pixels", "samples"]


def _perspective(data: Any) -> None:
    data.lens, data.shift_x, data.shift_y = 31, 0.2, -0.1


def _orthographic(data: Any) -> None:
    data.type, data.ortho_scale, data.shift_x, data.shift_y = "ORTHO", 3, -0.3, 0.15


@pytest.mark.parametrize("kind", [_perspective, _orthographic])
@pytest.mark.parametrize("size", [(300, 200), (200, 300)])
def test_our_camera_sees_what_the_users_sees(kind: Any, size: tuple[int, int]) -> None:
    scene_with_balls()
    scene, layer = context.scene, context.view_layer
    kind(scene.camera.data)
    scene.camera.rotation_euler = (0.3, 0.2, 0.1)
    scene.camera.data.clip_start, scene.camera.data.clip_end = 0.5, 50
    scene.render.resolution_x, scene.render.resolution_y = size
    eye = Viewpoint.of_camera(scene, layer)
    width, height = eye.size(300)
    assert (width, height) == size
    scene.camera = eye.camera()
    scene.collection.objects.link(scene.camera)
    again = Viewpoint.of_camera(scene, layer)
    np.testing.assert_allclose(again.projection @ np.linalg.inv(again.matrix), _whole(eye), atol=2e-4)


def _whole(eye: Viewpoint) -> Any:
    return eye.projection @ np.linalg.inv(eye.matrix)


# by workers, as in a window


def compare(item: Any, bake: str, size: int) -> None:
    """As the button does in a window."""
    place = Path(bake)
    eye = Viewpoint.of_camera(context.scene, context.view_layer)
    submit(context.scene, bakes_of([item], place), place, eye, ComparisonSpec(size, 1))


def ours() -> list[str]:
    return sorted(image.name for image in bpy.data.images if image.name.startswith("RadTex"))


@pytest.mark.one_blender
def test_a_workers_pictures_are_a_step_to_undo_and_there_until_they_are_forgotten(bake: str) -> None:
    (item,) = scene_with_balls()
    bpy.ops.ed.undo_push(message="before")
    before = digest()
    for size, height in ((32, 18), (48, 27)):
        compare(item, bake, size)
        assert ours() in ([], [BAKED, DIFFERENCE, TRACED])
        assert job_title(jobs.snapshot()[-1]) == "Ball, compared"
        job = finish_jobs()[-1]
        assert job.state == "done", job.message
        assert pixels(TRACED).shape == (height, size, 4)
        np.testing.assert_allclose(pixels(TRACED)[height // 2, size // 2, :3], GLOW, rtol=0.02)
        assert pixels(DIFFERENCE)[..., :3].max() < 0.2
    assert ours() == [BAKED, DIFFERENCE, TRACED]
    bpy.ops.ed.undo()
    assert pixels(TRACED).shape == (18, 32, 4), "the second took the place of the first"
    bpy.ops.ed.undo()
    assert differences(before, digest()) == {}
    bpy.ops.ed.redo()
    assert pixels(TRACED).shape == (18, 32, 4)
    first, second = jobs.snapshot()
    assert [float(next(iter(figures(job.facts))).split()[0]) > 30 for job in (first, second)] == [True, True]
    radtex.show_comparison(number=second.number)
    assert pixels(TRACED).shape == (27, 48, 4)
    bpy.data.images.remove(bpy.data.images[DIFFERENCE])
    radtex.show_comparison(number=first.number)
    assert ours() == [BAKED, DIFFERENCE, TRACED]
    assert pixels(DIFFERENCE).shape == (18, 32, 4)
    assert all(path.is_file() for job in (first, second) for path in job.files)
    radtex.clear_jobs()
    assert not any(path.exists() for job in (first, second) for path in (*job.files, job.out))
    with pytest.raises(RuntimeError, match="has no pictures: compare again"):
        radtex.show_comparison(number=first.number)


@pytest.mark.one_blender
def test_pictures_do_not_come_into_another_file(bake: str) -> None:
    (item,) = scene_with_balls()
    compare(item, bake, 32)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    (job,) = finish_jobs()
    assert job.state == "done", job.message
    assert ours() == []
    radtex.show_comparison(number=job.number)
    assert ours() == [BAKED, DIFFERENCE, TRACED]


@pytest.mark.one_blender
def test_a_worker_exports_one_bake_or_a_scene_while_the_open_one_is_left_alone(bake: str) -> None:
    scene_with_balls()
    before = fingerprint()
    sidecar, out, room = (Path(bake) / name for name in ("Ball.radiance.json", "made", "Room"))
    export([Place(NAME, sidecar, out)], ExportSpec(Target.GODOT), overwrite=False)
    submit_scene([sidecar, sidecar], ExportSpec(Target.GLTF), "Room", room, overwrite=False)
    assert [job_title(job) for job in jobs.snapshot()] == ["Ball for Godot", "Room for glTF"]
    one, scene = finish_jobs()
    assert (one.state, one.files) == ("done", (out,)), one.message
    assert (scene.state, scene.files) == ("done", (room,)), scene.message
    assert (room / "Room.export.json").is_file()
    assert differences(before, fingerprint()) == {}


# export


def test_of_several_kinds_the_panels_is_exported(bake: str) -> None:
    scene_with_balls()
    spec = BakeSpec(kind=Kind.SHADOW, texels=16)
    bake_object(context.scene, NAME, spec, Path(bake), preview=Filter.QUADRILINEAR, overwrite=True)
    context.scene.radtex.kind = "shadow"
    radtex.export(bake=bake, target="raw")
    made = {path.name for path in (Path(bake) / "Ball.raw").iterdir()}
    assert {"Ball.shadow.ktx2", "Ball.radiance.ktx2"} & made == {"Ball.shadow.ktx2"}


def test_a_preview_is_exported_as_its_object(bake: str, tmp_path: Path) -> None:
    scene_with_balls()
    radtex.preview_toggle(bake=bake)
    before = digest()
    radtex.export(bake=bake, target="gltf", directory=str(tmp_path / "made"))
    assert differences(before, digest()) == {}
    assert (tmp_path / "made" / "Ball.glb").is_file()


@pytest.mark.one_blender
@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"target": "web", "format": "exr"}, "web does not read it"),
        ({"object": "Other"}, "holds no bake of 'Other'"),
        ({"limit": 3}, "a texture needs 16 pixels at least"),
    ],
)
def test_what_cannot_be_exported_is_said(arguments: dict[str, Any], words: str, bake: str) -> None:
    for item in scene_with_balls(NAME, "Other"):
        item.select_set(True)
    with pytest.raises(RuntimeError, match=words):
        radtex.export(**{"bake": bake, "target": "raw"} | arguments)
    assert not (Path(bake) / "Ball.raw").exists()


def test_every_format_and_arrangement_can_be_chosen() -> None:
    assert [identifier for identifier, _, _ in FORMATS] == [form.value for form in TextureFormat]
    assert [identifier for identifier, _, _ in ARRANGEMENTS] == [one.value for one in Arrangement]
