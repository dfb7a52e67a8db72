# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the panel bakes: selected objects, a collection, a list in its order; each with its settings."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import bpy
import pytest

from radtex_addon.bake.progress import Stage
from radtex_addon.job import bake_steps
from radtex_addon.job.bake_plan import plan_bakes
from radtex_addon.textures.export_spec import ExportSpec, Target
from radtex_addon.ui.jobs import jobs
from radtex_addon.ui.operators.export_sources import export_sources, place_for, submit
from radtex_addon.ui.panel import panel_state
from radtex_addon.ui.panel.cost_panel import RADTEX_PT_cost
from radtex_addon.ui.panel.draw_messages import left_out_of
from radtex_addon.ui.panel.finished_panel import RADTEX_PT_afterwards
from radtex_addon.ui.panel.jobs_panel import job_title
from radtex_addon.ui.panel.list_panel import RADTEX_MT_settings_of
from radtex_addon.ui.panel.main_panel import RADTEX_PT_bake, told_whose, what_is_there
from radtex_addon.ui.panel.panel_state import Forecast, Next
from radtex_addon.ui.settings.chosen_objects import chosen_by, chosen_names, told_names
from radtex_addon.ui.settings.object_settings import by_settings, edited_settings
from radtex_addon.ui.settings.request import request_of, spec_of, values_of
from tests.blender import stage
from tests.blender.recorded_layout import RecordedLayout
from tests.blender.ui_stage import context, finish_jobs, ops, registered, settings

COUNT = 8


@pytest.fixture(autouse=True)
def _registered(empty_file: None, out: Path) -> Iterator[None]:
    with registered():
        stage.world()
        settings().directory = str(out)
        settings().atlas_layout, settings().preview = "buckets", False
        settings().texels, settings().bucket, settings().samples = 4, 2, 1
        yield


def plane(name: str, collection: Any = None) -> Any:
    bpy.ops.mesh.primitive_plane_add(size=2)
    item = context.object
    item.name = name
    if collection is not None:
        for home in item.users_collection:
            home.objects.unlink(item)
        collection.objects.link(item)
    return item


def chosen() -> tuple[str, ...]:
    return chosen_names(context.scene, context.view_layer)


def seen() -> Forecast:
    return panel_state.refresh(context.scene, context.view_layer)


def kitchen() -> Any:
    """A collection with two cups, a collection in it with a plate, a lamp, and what is never rendered."""
    kitchen, shelf = bpy.data.collections.new("Kitchen"), bpy.data.collections.new("Shelf")
    context.scene.collection.children.link(kitchen)
    kitchen.children.link(shelf)
    plane("Cup 2", kitchen)
    plane("Cup 1", kitchen)
    plane("Cutter", kitchen).hide_render = True
    plane("Plate", shelf)
    bpy.ops.object.light_add()
    kitchen.objects.link(context.object)
    plane("Elsewhere")
    return kitchen


def test_a_collections_meshes_are_chosen_whatever_is_selected() -> None:
    chosen_by(context.scene).source = "collection"
    assert chosen() == ()
    chosen_by(context.scene).collection = kitchen()
    assert chosen() == ("Cup 1", "Cup 2", "Plate")
    assert (seen().next, seen().bakes) == (Next.BAKE, 3)


def test_what_has_no_object_says_what_to_do() -> None:
    with pytest.raises(RuntimeError, match="Add a mesh object"):
        ops.radtex.bake()
    plane("A")
    for source, words in (
        ("collection", "No collection is chosen: choose the one whose meshes are to be baked"),
        ("list", "The bake list is empty: select objects and press its plus"),
    ):
        chosen_by(context.scene).source = source
        with pytest.raises(RuntimeError, match=words):
            ops.radtex.bake()


def test_a_list_keeps_its_order_and_is_edited_by_buttons() -> None:
    for name in ("A", "B", "C"):
        plane(name)
    chosen_by(context.scene).source = "list"
    bpy.ops.object.select_all(action="DESELECT")
    for name in ("C", "A", "B"):
        bpy.data.objects[name].select_set(True)
        assert ops.radtex.list_add() == {"FINISHED"}
        assert ops.radtex.list_add() == {"CANCELLED"}  # it is on the list
        bpy.data.objects[name].select_set(False)
    assert chosen() == ("C", "A", "B")
    assert ops.radtex.list_move(way="UP") == {"FINISHED"}
    assert chosen() == ("C", "B", "A")
    chosen_by(context.scene).listed[0].use = False
    assert chosen() == ("B", "A")
    assert ops.radtex.list_remove() == {"FINISHED"}
    assert chosen() == ("A",)
    bpy.data.objects.remove(bpy.data.objects["A"])
    assert chosen() == ()
    assert ops.radtex.list_clear() == {"FINISHED"}
    assert not ops.radtex.list_move.poll()


def test_a_collection_is_added_to_the_list() -> None:
    kitchen()
    layers = context.view_layer.layer_collection.children
    context.view_layer.active_layer_collection = layers["Kitchen"]
    assert ops.radtex.list_add(what="COLLECTION") == {"FINISHED"}
    chosen_by(context.scene).source = "list"
    assert chosen() == ("Cup 1", "Cup 2", "Plate")


def test_own_settings_start_from_the_scenes_and_count_wherever_the_object_is_baked(out: Path) -> None:
    cup, plate = plane("Cup"), plane("Plate")
    cup.radtex.use = True
    assert (cup.radtex.texels, cup.radtex.samples) == (4, 1)
    cup.radtex.texels = 6
    cup.radtex.use = False
    cup.radtex.use = True
    assert cup.radtex.texels == 6  # they are kept
    settings().texels = 8
    for item in (cup, plate):
        item.select_set(True)
    assert seen().bakes == 2
    assert ops.radtex.bake() == {"FINISHED"}
    sizes = {
        name: json.loads((out / f"{name}.radiance.json").read_text())["texels"] for name in ("Cup", "Plate")
    }
    assert sizes == {"Cup": [6, 6], "Plate": [8, 8]}


def on_the_list(*items: Any) -> Any:
    """The objects on the bake list, which is chosen; the last one is active, and the last row is marked."""
    bpy.ops.object.select_all(action="DESELECT")
    choice = chosen_by(context.scene)
    choice.source = "list"
    for item in items:
        choice.listed.add().item = item
    choice.active = len(items) - 1
    context.view_layer.objects.active = items[-1]
    return choice


def drawn(panel: Any) -> RecordedLayout:
    seen()
    layout = RecordedLayout()
    panel.draw(SimpleNamespace(layout=layout), context)
    return layout


def whose() -> str:
    """The panel's line on whose settings it shows."""
    (line,) = [text for text in drawn(RADTEX_PT_bake).texts if "ettings" in text and "Own" not in text]
    return line


def test_the_marked_row_of_the_list_says_whose_settings_are_shown() -> None:
    cup, plate, jug = plane("Cup"), plane("Plate"), plane("Jug")
    choice = on_the_list(cup, plate, jug)
    cup.radtex.use, plate.radtex.use = True, True
    cup.radtex.texels = 16
    names = chosen()
    assert edited_settings(context.scene, jug, names) == settings(), "the scene's, of the marked jug"
    choice.active = 0
    assert edited_settings(context.scene, jug, names) == cup.radtex
    assert ops.radtex.preset_apply(name="final") == {"FINISHED"}
    assert (cup.radtex.texels, plate.radtex.texels, settings().texels) == (256, 4, 4)
    choice.listed[0].use = False  # not baked: the active object counts then, if that is
    context.view_layer.objects.active = plate
    assert edited_settings(context.scene, plate, chosen()) == plate.radtex
    choice.source = "selection"
    assert edited_settings(context.scene, plate, ("Cup", "Plate")) == plate.radtex


def test_one_line_says_whose_settings_are_shown_and_a_menu_goes_to_the_others() -> None:
    cup, plate, jug = plane("Cup"), plane("Plate"), plane("Jug")
    assert whose() == "Scene's settings"
    choice = on_the_list(cup, plate, jug)
    assert drawn(RADTEX_PT_bake).menus == []
    cup.radtex.use = True
    assert whose().startswith("Scene's settings; 1 of 3")
    assert drawn(RADTEX_PT_bake).menus == ["RADTEX_MT_settings_of"]
    menu = drawn(RADTEX_MT_settings_of)
    assert menu.texts == ["Cup", "Scene's settings: Plate and 1 more"]
    for row, line in ((0, "Settings of Cup"), (1, "Scene's settings; 1 of 3")):
        (name, arguments) = menu.buttons[row]
        assert name == "radtex.show_settings"
        assert ops.radtex.show_settings(**vars(arguments)) == {"FINISHED"}
        assert (choice.active, whose().startswith(line)) == (row, True)
    choice.source = "selection"
    for item in (cup, plate, jug):
        item.select_set(True)
    assert ops.radtex.show_settings(object="Cup") == {"FINISHED"}
    assert (context.view_layer.objects.active, len(chosen())) == (cup, 3)
    cup.name = "Mug"
    assert whose().startswith("Settings of Mug")


def test_settings_of_what_is_not_there_are_refused_by_name() -> None:
    cup, plate = plane("Cup"), plane("Plate")
    on_the_list(cup)
    with pytest.raises(RuntimeError, match="'Plate' is not on the bake list: add it first"):
        ops.radtex.show_settings(object="Plate")
    chosen_by(context.scene).source = "selection"
    with pytest.raises(RuntimeError, match="has no object 'Spoon': name another"):
        ops.radtex.show_settings(object="Spoon")
    assert context.view_layer.objects.active == cup
    assert plate.name in context.view_layer.objects


def test_the_names_of_the_longest_line_that_fits_are_told() -> None:
    objects = tuple(f"Tile {number}" for number in range(8))
    assert told_whose(None, objects, objects[:2])[0] == (
        "Scene's settings; 2 of 8 objects have their own: Tile 0, Tile 1"
    )
    assert told_whose("Tile 1", objects, objects[:2]) == (
        "Settings of Tile 1, 1 of 8 objects",
        "Settings of Tile 1",
        "Tile 1's",
    )
    assert told_whose("Tile 1", objects[1:2], objects[1:2]) == ("Settings of Tile 1", "Tile 1's")
    assert told_whose(None, objects[:1], objects[:1])[0] == "Scene's settings; Tile 0 has its own"
    for names in (objects, objects[:1]):  # in the narrowest sidebar
        assert told_whose(None, names, objects[:1])[-2:] == ("Scene's settings", "Scene's")


def no_collection() -> None:
    chosen_by(context.scene).source = "collection"


def empty_list() -> None:
    chosen_by(context.scene).source = "list"


def never_saved() -> None:
    plane("Cup")
    settings().directory = "//x"


def no_such_layer() -> None:
    plane("Cup")
    settings().uv_layer = "none such"


def empty_collection() -> None:
    chosen_by(context.scene).source = "collection"
    chosen_by(context.scene).collection = bpy.data.collections.new("Nothing")


def unticked() -> None:
    on_the_list(plane("Cup")).listed[0].use = False


def deleted() -> None:
    on_the_list(plane("Cup"), plane("Plate"))
    for name in ("Cup", "Plate"):
        bpy.data.objects.remove(bpy.data.objects[name])
    plane("Jug")


def only_a_lamp() -> None:
    bpy.ops.object.select_all(action="DESELECT")
    bpy.ops.object.light_add()


def only_hidden() -> None:
    plane("Cup").hide_render = True


@pytest.mark.parametrize(
    ("state", "words"),
    [
        (no_collection, "No collection is chosen"),
        (empty_collection, "Collection 'Nothing' has no mesh that is seen in renders: choose another"),
        (empty_list, "The bake list is empty: select"),
        (unticked, "No object of the bake list is ticked: tick those to bake"),
        (deleted, "The objects of the bake list were deleted: take them off"),
        (only_a_lamp, "' is a light, and has no surface to bake"),
        (only_hidden, "'Cup' is hidden from render"),
        (never_saved, "This file was never saved"),
        (
            no_such_layer,
            "has no UV layer 'none such'",
        ),
    ],
)
def test_a_grey_button_has_its_reason_in_the_panel(state: Callable[[], object], words: str) -> None:
    state()
    assert seen().next is Next.NOTHING
    assert words in " ".join(" ".join(drawn(RADTEX_PT_bake).texts).split())
    if not seen().objects:
        assert drawn(RADTEX_PT_afterwards).texts[-1], "the buttons for finished bakes are grey, too"
        costs = [*drawn(RADTEX_PT_bake).texts, *drawn(RADTEX_PT_cost).texts]
        assert not any("t most" in text for text in costs), "nothing costs nothing"


def test_presets_change_the_settings_that_the_panel_shows() -> None:
    cup, plate = plane("Cup"), plane("Plate")
    cup.radtex.use = True
    context.view_layer.objects.active = cup
    bpy.ops.object.select_all(action="DESELECT")
    cup.select_set(True)
    assert ops.radtex.preset_apply(name="final") == {"FINISHED"}
    assert (cup.radtex.texels, settings().texels) == (256, 4)
    cup.select_set(False)
    plate.select_set(True)  # the cup is active, and is not baked
    assert ops.radtex.preset_apply(name="draft") == {"FINISHED"}
    assert (cup.radtex.texels, settings().texels) == (256, 64)


def test_a_bake_in_an_objects_own_folder_is_found(tmp_path: Path) -> None:
    settings().preview = True
    cup = plane("Cup")
    cup.radtex.use = True
    cup.radtex.directory = str(tmp_path / "hero")
    assert ops.radtex.bake() == {"FINISHED"}
    assert (tmp_path / "hero" / "Cup.radiance.json").is_file()
    assert ops.radtex.preview_toggle() == {"FINISHED"}
    assert cup.hide_render
    assert ops.radtex.export(target="raw") == {"FINISHED"}
    assert (tmp_path / "hero" / "Cup.raw").is_dir()


def test_a_button_drawn_for_other_objects_bakes_nothing(out: Path) -> None:
    plane("Cup")
    with pytest.raises(RuntimeError, match="Other objects are chosen by now"):
        ops.radtex.bake(expected="Plate", overwrite=True)
    assert not out.exists()
    assert ops.radtex.bake(expected="Cup") == {"FINISHED"}


def test_what_is_missing_beside_own_settings_is_baked_alone(out: Path) -> None:
    cup, plate = plane("Cup"), plane("Plate")
    cup.radtex.use = True
    cup.radtex.texels = 6
    for item in (cup, plate):
        item.select_set(True)
    assert ops.radtex.bake(object="Cup") == {"FINISHED"}
    assert (seen().next, what_is_there(seen())) == (Next.RESUME, ["1 of 2 bakes is there"])
    before = written(out)
    assert ops.radtex.bake(resume=True) == {"FINISHED"}
    after = written(out)
    assert (set(after), after["Cup"]) == ({"Cup", "Plate"}, before["Cup"])
    assert seen().next is Next.REPLACE
    with pytest.raises(RuntimeError, match="All objects are finished"):
        ops.radtex.bake(resume=True)


def test_all_are_checked_before_any_is_baked(out: Path) -> None:
    cup, plate = plane("Cup"), plane("Plate")
    cup.radtex.use = True
    cup.radtex.uv_layer = "None such"
    for item in (cup, plate):
        item.select_set(True)
    (error,) = seen().errors
    assert "has no UV layer 'None such'" in str(error)
    assert seen().next is Next.NOTHING
    cup.radtex.frames, cup.radtex.variants = "first", "frames"  # an error before anything is planned
    assert (len(seen().errors), seen().next) == (1, Next.NOTHING)
    cup.radtex.variants = "none"
    with pytest.raises(RuntimeError, match="has no UV layer 'None such'"):
        ops.radtex.bake()
    assert not out.exists()


def test_a_bake_that_is_shown_is_baked_again_by_one_press(out: Path) -> None:
    settings().preview = True
    plane("Card")
    assert ops.radtex.bake() == {"FINISHED"}
    assert ops.radtex.preview_toggle() == {"FINISHED"}
    assert (seen().errors, seen().next, seen().shown) == ((), Next.REPLACE, ("Card",))
    with pytest.raises(RuntimeError, match="its preview is shown in its place"):
        ops.radtex.bake(overwrite=True)
    before = (out / "Card.radiance.json").stat().st_mtime_ns
    assert ops.radtex.bake(overwrite=True, show_object=True) == {"FINISHED"}
    assert (out / "Card.radiance.json").stat().st_mtime_ns > before
    assert not bpy.data.objects["Card"].hide_render


@pytest.mark.one_blender
def test_many_objects_are_baked_the_one_that_changed_again_and_all_exported(out: Path) -> None:
    """A collection's, without another setting; its neighbours count only if they are asked for."""
    settings().preview = True
    kitchen = bpy.data.collections.new("Kitchen")
    context.scene.collection.children.link(kitchen)
    for number in range(COUNT):
        plane(f"Tile {number:02}", kitchen).location = (3 * number, 0, 0)
    settings().texels = 2
    chosen_by(context.scene).source, chosen_by(context.scene).collection = "collection", kitchen
    assert ops.radtex.bake() == {"FINISHED"}
    before = written(out)
    assert len(before) == COUNT
    assert ops.radtex.bake(only="affected") == {"FINISHED"}
    assert written(out) == before
    bpy.data.objects["Tile 07"].rotation_euler.x = 0.4
    assert ops.radtex.bake(only="changed") == {"FINISHED"}
    after = written(out)
    assert [name for name, time in after.items() if time != before[name]] == ["Tile 07"]
    assert ops.radtex.bake(only="affected") == {"FINISHED"}
    again = written(out)
    assert [name for name, time in again.items() if time == after[name]] == ["Tile 07"]
    assert ops.radtex.export() == {"FINISHED"}
    made = {folder.name for folder in out.iterdir() if folder.is_dir()}
    assert made == {f"Tile {number:02}.gltf" for number in range(COUNT)}
    assert all((out / name / f"{name.removesuffix('.gltf')}.glb").is_file() for name in made)


@pytest.mark.one_blender
def test_several_bakes_are_exported_by_one_job_into_the_chosen_folder(out: Path, tmp_path: Path) -> None:
    settings().preview = True
    for name in ("Cup", "Jug", "Plate"):
        plane(name).select_set(True)
        assert ops.radtex.bake(object=name) == {"FINISHED"}
        bpy.data.objects[name].select_set(True)
    bpy.ops.object.select_all(action="SELECT")
    (tmp_path / "game").mkdir()
    assert ops.radtex.export(target="raw", into=str(tmp_path / "game")) == {"FINISHED"}
    assert {path.name for path in (tmp_path / "game").iterdir()} == {"Cup.raw", "Jug.raw", "Plate.raw"}

    sources = export_sources(context.scene, context.view_layer, "", "")
    (out / "Jug.preview.blend").write_bytes(b"damaged")
    places = [place_for(source, out / f"{source.name}.raw") for source in sources]
    submit(places, ExportSpec(Target.RAW), overwrite=False)
    (job,) = jobs.snapshot()
    assert job_title(job) == "3 bakes for Raw"
    (job,) = finish_jobs()
    assert job.state == "done", job.message
    assert [folder.name for folder in job.files] == ["Cup.raw", "Plate.raw"]
    (warning,) = job.warnings
    assert "Jug.preview.blend is no .blend" in str(warning)
    assert not (out / "Jug.raw").exists()


@pytest.mark.one_blender
def test_what_has_changed_is_not_baked_over_what_is_unfinished_or_added_to(out: Path) -> None:
    for name in ("Cup", "Plate"):
        plane(name).select_set(True)
    bpy.ops.object.select_all(action="SELECT")
    assert ops.radtex.bake() == {"FINISHED"}
    spec = spec_of(values_of(settings()))
    steps = bake_steps(context.scene, "Cup", spec, out, overwrite=True)
    while next(steps).stage is not Stage.WRITE:
        pass
    steps.close()
    assert seen().next is Next.RESUME  # which has no Bake Changed beside it
    with pytest.raises(RuntimeError, match=r"The bake of 'Cup' is not finished: go on with it \(Resume\)"):
        ops.radtex.bake(only="changed")
    assert list(out.glob("*.radtex-unfinished"))
    assert ops.radtex.bake(resume=True) == {"FINISHED"}
    assert ops.radtex.bake(only="changed") == {"FINISHED"}
    settings().accumulate = True
    before = written(out)
    with pytest.raises(RuntimeError, match="baked anew, and not added to the bake: leave Accumulate off"):
        ops.radtex.bake(only="changed")
    assert written(out) == before


@pytest.mark.one_blender
def test_a_lists_order_holds_where_objects_have_settings_of_their_own(out: Path) -> None:
    for name in ("C", "A", "B"):
        bpy.ops.object.select_all(action="DESELECT")
        plane(name).select_set(True)
        assert ops.radtex.list_add() == {"FINISHED"}
    chosen_by(context.scene).source = "list"
    own: Any = bpy.data.objects["A"]
    own.radtex.use = True
    own.radtex.texels = 6
    plans = [
        plan_bakes(context.scene, request_of(values_of(group), names))
        for group, names in by_settings(context.scene, chosen())
    ]
    assert [plan.request.objects for plan in plans] == [("C", "B"), ("A",)]
    jobs.submit(context.scene, plans, chosen())
    assert [job.object for job in jobs.snapshot()] == ["C", "A", "B"]
    jobs.cancel()
    finish_jobs()
    assert ops.radtex.bake(overwrite=True) == {"FINISHED"}
    times = written(out)
    assert sorted(times, key=lambda name: times[name]) == ["C", "A", "B"]


def written(folder: Path) -> dict[str, int]:
    """When the bake of each object was written, in ns."""
    return {
        path.name.removesuffix(".radiance.json"): path.stat().st_mtime_ns
        for path in sorted(folder.glob("*.json"))
    }


def bare(name: str, corners: list[tuple[float, float, float]]) -> Any:
    """A mesh object of one face, or of none."""
    data = bpy.data.meshes.new(name)
    data.from_pydata(corners, [], [tuple(range(len(corners)))] if corners else [])
    made = bpy.data.objects.new(name, data)
    context.scene.collection.objects.link(made)
    return made


def no_geometry() -> Any:
    """A group of geometry nodes that makes nothing of what it gets."""
    nodes: Any = bpy.data.node_groups.new("Nothing", "GeometryNodeTree")
    nodes.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    nodes.nodes.new("NodeGroupOutput")
    return nodes


def unbakeable() -> dict[str, str]:
    """Objects that cannot be baked, each for another reason, and words of that reason; none is a mistake."""
    corners = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)]
    plane("Cutter").hide_render = True
    bare("Empty Mesh", [])
    bare("Not Finite", [(float("nan"), 0, 0), *corners[1:]])
    bare("Flat", corners).scale.z = 0
    bare("Point", [(0, 0, 0)] * 3)
    plane("Unseen").visible_camera = False
    bumped = stage.material("Bumped", "ShaderNodeBsdfDiffuse")
    tree: Any = bumped.node_tree
    tree.links.new(
        tree.nodes.new("ShaderNodeDisplacement").outputs[0], tree.nodes["Material Output"].inputs[2]
    )
    bumped.displacement_method = "DISPLACEMENT"
    plane("Displaced").data.materials.append(bumped)
    instancer = plane("Instancer")
    instancer.instance_type, instancer.show_instancer_for_render = "FACES", False
    plane("Vanished").modifiers.new("Nothing", "NODES").node_group = no_geometry()
    dark = bpy.data.collections.new("Dark")
    context.scene.collection.children.link(dark)
    dark.hide_render = True
    plane("In the Dark", dark)
    return {
        "Cutter": "is hidden from render: enable it in renders",
        "Empty Mesh": "has no faces in renders",
        "Not Finite": "coordinates are not finite",
        "Flat": "is scaled to nothing along an axis",
        "Point": "has faces, but no area",
        "Unseen": "cameras do not see it",
        "Displaced": "displaces the surface",
        "Instancer": "it is an instancer",
        "Vanished": "has no faces in renders",
        "In the Dark": "enable its collection 'Dark' in renders",
    }


def lines_of(found: Forecast) -> dict[str, str]:
    """What the panel says of each object that is left out."""
    return {one.name: str(one.why) for one in found.left_out}


def test_what_cannot_be_baked_is_left_out_of_all_that_is_selected(
    out: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    wanted = unbakeable() | {"BézierCircle": "has no faces in renders"}
    plane("Cup")
    bpy.ops.object.light_add()
    bpy.ops.object.empty_add()
    bpy.ops.curve.primitive_bezier_circle_add()
    bpy.ops.object.select_all(action="SELECT")
    found = seen()
    assert (found.objects, found.errors, found.next, found.bakes) == (("Cup",), (), Next.BAKE, 1)
    told = lines_of(found)
    assert told.keys() == wanted.keys()
    for name, words in wanted.items():
        assert f"'{name}'" in told[name]
        assert words in told[name]
    assert len(left_out_of(found)) == len(wanted) - 2  # the three without faces share a line
    assert len(found.not_baked) == 1

    assert ops.radtex.bake(expected=told_names(found.chosen)) == {"FINISHED"}
    said = capfd.readouterr().out
    assert list(written(out)) == ["Cup"]
    for name in wanted:
        assert sum(f"'{name}'" in line for line in said.splitlines()) == 1, name
    assert ops.radtex.bake(only="changed") == {"FINISHED"}
    assert ops.radtex.estimate() == {"FINISHED"}
    with pytest.raises(RuntimeError, match="'Cutter' is hidden from render"):
        ops.radtex.bake(object="Cutter")  # which is named

    bpy.data.objects["Cup"].select_set(False)
    context.view_layer.objects.active = bpy.data.objects["Cutter"]
    found = seen()
    assert (found.next, len(found.errors), found.left_out) == (Next.NOTHING, len(wanted) - 2, ())
    with pytest.raises(RuntimeError, match="in renders"):
        ops.radtex.bake(overwrite=True)


def test_a_list_leaves_out_what_cannot_be_baked_and_what_is_not_in_the_view_layer(out: Path) -> None:
    away, other = bpy.data.collections.new("Away"), bpy.data.scenes.new("Other")
    context.scene.collection.children.link(away)
    for name in ("Cutter", "Excluded", "Elsewhere", "Cup"):
        bpy.ops.object.select_all(action="DESELECT")
        plane(name, away if name == "Excluded" else None).select_set(True)
        assert ops.radtex.list_add() == {"FINISHED"}
    bpy.data.objects["Cutter"].hide_render = True
    context.view_layer.layer_collection.children["Away"].exclude = True
    context.scene.collection.objects.unlink(bpy.data.objects["Elsewhere"])
    other.collection.objects.link(bpy.data.objects["Elsewhere"])
    bpy.ops.object.light_add()
    chosen_by(context.scene).listed.add().item = context.object  # as a script may
    chosen_by(context.scene).source = "list"
    found = seen()
    assert (found.objects, found.errors, found.next) == (("Cup",), (), Next.BAKE)
    told = lines_of(found)
    assert "enable it in renders" in told["Cutter"]
    assert "include its collection 'Away'" in told["Excluded"]
    assert "is not in scene 'Scene'" in told["Elsewhere"]
    assert "is a light, not a mesh" in told["Point"]
    assert ops.radtex.bake() == {"FINISHED"}
    assert list(written(out)) == ["Cup"]
    chosen_by(context.scene).listed[3].use = False
    assert (seen().next, len(seen().errors)) == (Next.NOTHING, 4)


def test_a_fault_of_the_viewport_alone_leaves_nothing_out() -> None:
    """Renders show faces that the viewport lacks."""
    shown = plane("Shown Later")
    nodes = no_geometry()
    modifier = shown.modifiers.new("Nothing", "NODES")
    modifier.node_group = nodes
    modifier.show_render = False
    plane("Cup")
    bpy.ops.object.select_all(action="SELECT")
    assert seen().objects == ("Cup", "Shown Later")
    modifier.show_render = True
    assert seen().objects == ("Cup",)
    nodes.nodes.new("GeometryNodeIsViewport")
    assert seen().objects == ("Cup", "Shown Later")
