# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel knows beforehand what would fail and what a bake costs, and soon learns of every change."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast, get_type_hints

import bpy
import pytest

from radtex_addon.bake.progress import Stage
from radtex_addon.core.sampler import Filter
from radtex_addon.job import bake_object, bake_steps, probes
from radtex_addon.job.preflight import run_preflight
from radtex_addon.settings.estimate import Basis
from radtex_addon.settings.spec import BakeSpec
from radtex_addon.ui.operators.bake_operator import RADTEX_OT_bake
from radtex_addon.ui.panel import panel_state
from radtex_addon.ui.panel.cost_panel import RADTEX_PT_cost, figures, told_basis, told_made
from radtex_addon.ui.panel.draw_messages import draw_remarks
from radtex_addon.ui.panel.labels import size
from radtex_addon.ui.panel.main_panel import time_and_size, what_is_there
from radtex_addon.ui.panel.panel_state import Forecast, Next
from radtex_addon.ui.registration import CLASSES
from radtex_addon.ui.settings.request import spec_of, values_of
from tests.blender import stage
from tests.blender.fingerprint import differences, fingerprint
from tests.blender.recorded_layout import RecordedLayout
from tests.blender.ui_stage import context, ops, registered, settings


@pytest.fixture(autouse=True)
def _registered(empty_file: None, tmp_path: Path) -> Iterator[None]:
    with registered():
        stage.world()
        settings().directory = str(tmp_path / "out")
        settings().atlas_layout = "buckets"
        yield


def plane(name: str = "Card") -> None:
    bpy.ops.mesh.primitive_plane_add(size=2)
    context.object.name = name
    context.object.data.materials.append(stage.material(name, "ShaderNodeBsdfGlossy", Roughness=0.3))


def seen() -> Forecast:
    return panel_state.refresh(context.scene, context.view_layer)


def test_nothing_is_known_before_it_was_worked_out_and_then_it_is_kept() -> None:
    panel_state._cache.found.clear()
    assert panel_state.cached_forecast(context.scene, context.view_layer) is None
    found = seen()
    assert panel_state.cached_forecast(context.scene, context.view_layer) is found


def test_the_selected_meshes_are_baked_or_else_the_active_one() -> None:
    plane("B")
    plane("A")
    bpy.ops.object.light_add()
    lamp = context.object
    bpy.ops.object.select_all(action="SELECT")
    assert seen().objects == ("A", "B")
    bpy.ops.object.select_all(action="DESELECT")
    context.view_layer.objects.active = bpy.data.objects["B"]
    assert seen().objects == ("B",)
    context.view_layer.objects.active = lamp
    assert seen().objects == ()


def test_where_nothing_is_chosen_no_size_is_told(tmp_path: Path) -> None:
    settings().directory = str(tmp_path)
    plane()
    assert "at most" in time_and_size(seen())
    context.object.select_set(False)
    context.view_layer.objects.active = None
    assert (seen().objects, time_and_size(seen())) == ((), "")
    layout = RecordedLayout()
    RADTEX_PT_cost.draw(cast(Any, SimpleNamespace(layout=layout)), context)
    assert layout.texts == ["Select a mesh object to bake"]


def test_what_would_fail_is_said_in_place(tmp_path: Path) -> None:
    plane()
    spec, out = spec_of(values_of(settings())), tmp_path / "out"
    assert seen() == Forecast(
        ("Card",),
        spec=spec,
        cost=seen().cost,
        seconds=seen().seconds,
        range=seen().range,
        basis=seen().basis,
        made=seen().made,
        folder=out,
        next=Next.BAKE,
        bakes=1,
    )
    context.object.hide_render = True
    assert "is hidden from render" in str(seen().errors[0])
    context.object.hide_render = False
    settings().uv_layer = "Other"
    assert tuple(map(str, seen().errors)) == (
        "object 'Card' has no UV layer 'Other': choose 'UVMap', or leave the UV layer out to have one made",
    )
    settings().uv_layer = "UVMap"
    assert seen().errors == ()
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "Card.radiance.exr").touch()
    assert (seen().errors, seen().next, seen().finished) == ((), Next.REPLACE, 0)
    assert what_is_there(seen()) == ["Files of its name are there: they will be replaced"]


def test_what_settles_a_refusal_is_known(tmp_path: Path) -> None:
    plane()
    settings().texels, settings().bucket, settings().samples = 8, 4, 1
    spec, out = spec_of(values_of(settings())), tmp_path / "out"
    assert seen().next is Next.BAKE
    steps = bake_steps(context.scene, "Card", spec, out)
    next(step for step in steps if step.stage is Stage.CAPTURE and step.done)
    steps.close()
    assert seen().next is Next.RESUME
    assert what_is_there(seen()) == ["Its bake is not finished"]
    settings().samples = 2  # another bake
    assert seen().next is Next.REPLACE
    settings().resume = settings().overwrite = True  # which the panel's buttons decide by themselves
    assert seen().next is Next.REPLACE
    settings().samples = 1
    assert seen().next is Next.RESUME
    bake_object(context.scene, "Card", spec, out, resume=True)
    assert (seen().next, seen().finished) == (Next.REPLACE, 1)
    assert what_is_there(seen()) == ["It has a bake: that will be replaced"]
    settings().export_targets = {"web"}
    (out / "Card.web").mkdir()
    (out / "Card.web" / "mine.txt").touch()
    assert (seen().next, len(seen().errors)) == (Next.NOTHING, 1)  # the export would be refused all the same


def test_what_is_made_where_and_how_large_is_told_for_all_that_is_chosen(tmp_path: Path) -> None:
    plane("Cup")
    plane("Jug")
    context.object.radtex.use = True
    context.object.radtex.texels, context.object.radtex.bucket = 8, 2
    context.object.radtex.directory = str(tmp_path / "hero")
    bpy.data.objects["Cup"].select_set(True)
    settings().texels, settings().bucket = 16, 2
    found = seen()
    assert {one.name: (one.texels, one.folder.name) for one in found.made} == {
        "Cup": (16, "out"),
        "Jug": (8, "hero"),
    }
    disk = sum(2 * 4 * (texels * 2) ** 2 for texels in (16, 8))  # four half floats a cell
    assert told_made(found) == [
        f"2 textures, at most {size(disk)} on disk",
        f"in {tmp_path / 'out'}",
        "Cup: 16 × 16 texels",
        f"in {tmp_path / 'hero'}",
        "Jug: 8 × 8 texels",
    ]
    context.object.radtex.use = False
    settings().variants, settings().frames = "frames", "1-3"
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "kitchen.blend"))
    frames = told_made(seen())
    assert frames[:2] == [f"6 textures, at most {size(6 * 2 * 4 * 32**2)} on disk", "in //out"]
    layout = RecordedLayout()
    RADTEX_PT_cost.draw(SimpleNamespace(layout=layout), context)  # type: ignore[arg-type]  # of a panel this is all
    assert "Cup: 16 × 16 texels" in layout.texts
    many = replace(found, made=(found.made[0],) * 20, unseen=5, bakes=0)
    assert (len(told_made(many)), told_made(many)[-1]) == (2 + 12 + 1, "and 13 more")


def lines() -> list[str]:
    """What the panel knows of warnings, in its words."""
    return [str(told) for told in seen().warnings]


def test_negative_and_uneven_scales_are_notes_and_no_errors(tmp_path: Path) -> None:
    settings().directory = str(tmp_path)
    plane()
    context.object.scale = (-1, 1, 1)
    context.view_layer.update()
    assert lines() == ["'Card' has a negative scale: baked as it looks, nothing needs to be applied"]
    plane("Post")
    context.object.scale = (1, 1, 4)
    bpy.data.objects["Card"].select_set(True)
    bpy.data.objects["Card"].scale = (1, 2, 1)
    context.view_layer.update()
    (line,) = lines()
    assert line.startswith("'Card' and 1 more have uneven scales, not applied: baked as it looks")
    assert (seen().errors, seen().next) == ((), Next.BAKE)
    bpy.ops.object.transform_apply(location=False, rotation=False)
    assert lines() == []


def scale_of(name: str) -> Any:
    return bpy.data.objects[name].scale


def test_what_is_flat_is_told_at_once_and_a_button_mends_it(tmp_path: Path) -> None:
    settings().directory = str(tmp_path)
    plane()
    context.object.scale = (1, 0, 1)
    context.view_layer.update()
    assert (seen().next, seen().flat) == (Next.NOTHING, ("Card",))
    assert "is scaled to nothing along an axis" in str(seen().errors[0])
    layout = RecordedLayout()
    draw_remarks(layout, context.scene, settings(), seen())
    (button,) = [arguments for name, arguments in layout.buttons if name == "radtex.fix_scale"]
    plane("Other")
    bpy.data.objects["Card"].select_set(True)
    assert ([one.name for one in seen().left_out], seen().flat) == (["Card"], ("Card",))
    bpy.ops.ed.undo_push(message="before")
    assert ops.radtex.fix_scale(**vars(button)) == {"FINISHED"}
    assert tuple(scale_of("Card")) == (1, 1, 1)
    assert (seen().left_out, seen().flat, seen().next) == ((), (), Next.BAKE)
    bpy.ops.ed.undo()
    assert tuple(scale_of("Card")) == (1, 0, 1)


def test_a_scale_that_cannot_be_set_is_said_and_a_parents_gets_no_button(tmp_path: Path) -> None:
    settings().directory = str(tmp_path)
    plane()
    card: Any = context.object
    card.driver_add("scale", 1).driver.expression = "0"
    context.view_layer.update()
    assert seen().flat == ("Card",)
    with pytest.raises(RuntimeError, match="scale of 'Card' stays 0: drivers or animation set it"):
        ops.radtex.fix_scale()
    card.driver_remove("scale", 1)
    card.scale = (1, 1, 1)
    bpy.ops.object.empty_add()
    context.object.scale = (1, 0, 1)
    card.parent = context.object
    context.view_layer.objects.active = card
    card.select_set(True)
    context.view_layer.update()
    assert "is scaled to nothing along an axis" in str(seen().errors[0])
    assert seen().flat == ()


def test_bakes_that_are_shown_are_known(tmp_path: Path) -> None:
    plane("A")
    settings().texels, settings().bucket, settings().samples = 4, 2, 1
    spec, out = spec_of(values_of(settings())), tmp_path / "out"
    bake_object(context.scene, "A", spec, out, preview=Filter.QUADRILINEAR)
    assert seen().shown == ()
    assert ops.radtex.preview_toggle() == {"FINISHED"}
    found = seen()
    assert (found.objects, found.shown, found.errors, found.next) == (("A",), ("A",), (), Next.REPLACE)
    plane("B")
    context.object.hide_render = True
    bpy.ops.object.select_all(action="SELECT")
    assert (seen().objects, seen().shown, seen().errors) == (("A",), ("A",), ())
    assert [one.name for one in seen().left_out] == ["B"]


def test_what_cannot_be_is_said_and_costs_nothing() -> None:
    plane()
    settings().atlas_layout, settings().kind = "layered", "incident"
    (error,) = map(str, seen().errors)
    assert "the layered layout knows kind radiance only" in error
    assert seen().cost is None
    assert seen().spec is None


def test_a_file_never_saved_still_has_its_cost() -> None:
    plane()
    settings().directory = "//radtex"
    assert "never saved" in str(seen().errors[0])
    assert (seen().needs_folder, seen().next) == (True, Next.NOTHING)
    assert seen().cost is not None


def test_the_dark_is_warned_of() -> None:
    plane()
    context.scene.world = None
    found = seen()
    assert found.errors == ()
    assert any("has no light" in str(warning) for warning in found.warnings)


def test_of_many_objects_as_many_are_looked_at_as_time_allows(tmp_path: Path) -> None:
    plane("A")
    plane("B")
    context.object.hide_render = True
    found = [
        run_preflight(context.scene, ("A", "B"), BakeSpec(), tmp_path, patience=patience)
        for patience in (0.0, 60.0)
    ]
    assert [len(one.errors) for one in found] == [0, 1]


def test_every_change_marks_it_stale() -> None:
    plane()
    for change in (
        lambda: setattr(settings(), "texels", 64),
        lambda: context.object.select_set(False),
        lambda: context.scene.objects["Card"].modifiers.new("More", "SUBSURF"),
    ):
        bpy.app.timers.unregister(panel_state._tick)
        change()
        context.view_layer.update()
        assert bpy.app.timers.is_registered(panel_state._tick)


def test_arguments_of_a_button_leave_it_as_it_is() -> None:
    """Drawing sets them: if that marked it stale, it would be worked out again for ever, or never."""
    plane()
    seen()
    bpy.app.timers.unregister(panel_state._tick)
    properties = context.window_manager.operator_properties_last("radtex.bake")
    properties.resume, properties.overwrite, properties.bucket = True, True, 5
    assert not bpy.app.timers.is_registered(panel_state._tick)


def test_no_argument_of_an_operator_has_an_update_callback() -> None:
    """After such a callback Blender redraws all windows: a button that sets it is drawn for ever."""
    operators = [cls for cls in CLASSES if issubclass(cls, bpy.types.Operator)]
    arguments = [
        f"{operator.__name__}.{name}"
        for operator in operators
        for name, deferred in get_type_hints(operator).items()
        if "update" in getattr(deferred, "keywords", {})
    ]
    assert RADTEX_OT_bake in operators
    assert arguments == []


def test_the_timer_waits_for_quiet_and_then_stops(monkeypatch: pytest.MonkeyPatch) -> None:
    plane()
    now = 100.0
    monkeypatch.setattr(panel_state, "monotonic", lambda: now)
    panel_state.mark_stale()
    now = 100.1
    assert panel_state._tick() == pytest.approx(0.2)
    now = 100.4
    seen()
    assert panel_state._tick() is None
    assert set(panel_state._cache.found) <= {(context.scene.session_uid, context.view_layer.name)}


def test_looking_ahead_changes_nothing(tmp_path: Path) -> None:
    plane()
    context.view_layer.update()
    before = fingerprint()
    seen()
    assert not differences(before, fingerprint())
    assert list(tmp_path.iterdir()) == []


@pytest.mark.one_blender
@pytest.mark.parametrize(
    "choice",
    [
        {"texels": 8, "bucket": 4, "samples": 2},
        {"texels": 8, "bucket": 4, "samples": 2, "full_floats": True, "uv_layer": "UVMap"},
        {"atlas_layout": "layered", "texels": 8, "samples": 1},
    ],
    ids=["buckets", "floats", "layered"],
)
def test_a_bake_takes_no_more_than_was_said(choice: dict[str, object], tmp_path: Path) -> None:
    plane()
    for name, value in choice.items():
        setattr(settings(), name, value)
    found = seen()
    assert found.errors == ()
    assert found.spec is not None
    assert found.cost is not None
    made = bake_object(context.scene, "Card", found.spec, tmp_path / "out")
    disk = sum(path.stat().st_size for path in made.files.images)
    print(f"{choice}: paths {made.paths} of {found.cost.paths}, disk {disk} of {found.cost.disk}")
    headers = 4096 * len(made.files.images)  # and the sidecar's JSON in them
    assert made.paths <= found.cost.paths
    if not found.spec.form.by_paths:  # else what is around the object has a say too
        assert made.paths > 0.4 * found.cost.paths
    assert disk <= found.cost.disk + headers
    assert made.layout.pixel_width <= found.cost.side


def test_figures_are_for_people() -> None:
    found = seen()
    assert found.cost is not None
    assert figures(found.cost) == [
        ("Largest image", "1024 × 1024"),
        ("On disk", "8.39 MB"),
        ("On the GPU", "8.39 MB"),
        ("In memory", "988 MB"),
        ("Paths", "16.8 million"),
    ]


@pytest.mark.one_blender
def test_a_time_is_told_at_once_and_measured_by_the_button() -> None:
    plane()
    settings().texels, settings().bucket, settings().samples = 256, 4, 8
    assert (seen().basis, told_basis(Basis.NOTHING)) == ("nothing", "very roughly: nothing was baked here")
    guessed = seen().seconds
    assert guessed is not None
    assert guessed > 5
    assert ops.radtex.estimate() == {"FINISHED"}
    found = seen()
    assert found.basis == "measured"
    assert found.seconds is not None
    settings().texels = 512
    finer = seen()
    assert finer.basis == "measured"
    assert finer.seconds is not None
    assert finer.seconds > found.seconds


def test_what_has_no_mesh_is_named_with_what_to_do() -> None:
    plane("Card")
    bpy.ops.object.text_add()
    context.object.name = "Label"
    assert (seen().not_baked, seen().objects) == ((), ("Label",))
    bpy.ops.object.pointcloud_random_add()
    context.object.name = "Dust"
    (told,) = seen().not_baked
    assert told.text.startswith("'Dust' is a point cloud: it has no faces. Convert it")
    assert told.operator == "object.convert"
    bpy.ops.object.light_add()
    (told,) = seen().not_baked
    assert "is a light, and has no surface to bake" in told.text
    context.object.name = "Key"
    bpy.ops.object.camera_add()
    context.object.name = "Shot"
    bpy.ops.object.camera_add()
    for name in ("Key", "Shot"):
        context.scene.objects[name].select_set(True)
    (told,) = seen().not_baked
    named = told.text.removesuffix(": they have no surface to bake. Select meshes").split(", ")
    assert "'Key' is a light" in named
    assert len(named) == 2  # the cameras are of one sort
    assert "is a camera (and 1 more such)" in told.text
    context.scene.objects["Card"].select_set(True)
    (told,) = seen().not_baked
    assert told.text == f"Left out: {', '.join(named)}"
    bpy.ops.object.collection_instance_add(collection=bpy.data.collections.new("Parts").name)
    (told,) = seen().not_baked
    assert told.operator == "radtex.join_instances"


def test_a_storage_that_is_no_longer_there_is_said() -> None:
    plane()
    settings()["atlas_layout"] = 1
    assert any("is no longer there" in str(told) for told in seen().warnings)


@pytest.mark.one_blender
def test_an_unwrap_that_takes_too_long_is_replaced_in_the_measurement(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    bpy.ops.mesh.primitive_monkey_add()
    context.object.modifiers.new("Finer", "SUBSURF").render_levels = 2
    spec = replace(spec_of(values_of(settings())), texels=48, bucket=4, samples=2)
    monkeypatch.setattr(probes, "_UNWRAP_SECONDS", 0.0)
    found = probes.probe_object(context.scene, context.object.name, spec)
    assert (found.texels, found.triangles) == (48, 15_744)
    assert 0.2 * 48**2 < found.covered < 48**2
    assert "unwrap" not in found.whole
    assert found.part["capture"] > 0
