# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The buttons below a message in the panel, which do what it says."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import bpy
import pytest

from radtex_addon.core.messages import Message, Setting, do
from radtex_addon.ui.panel import panel_state
from radtex_addon.ui.panel.draw_messages import draw_remarks
from radtex_addon.ui.panel.labels import LABELS
from radtex_addon.ui.panel.panel_state import Forecast
from radtex_addon.ui.panel.remedies import PREFERENCES, PROPERTIES, offers
from tests.blender import stage
from tests.blender.recorded_layout import RecordedLayout
from tests.blender.ui_stage import context, ops, preferences, registered, settings


@pytest.fixture(autouse=True)
def _registered(empty_file: None, out: Path) -> Iterator[None]:
    with registered():
        stage.world()
        bpy.ops.mesh.primitive_plane_add()
        settings().directory = str(out)
        yield


def seen() -> Forecast:
    return panel_state.refresh(context.scene, context.view_layer)


def drawn() -> RecordedLayout:
    layout = RecordedLayout()
    draw_remarks(layout, context.scene, settings(), seen())
    return layout


def pressed() -> str:
    """Press the one button that is drawn below the messages; returns its text."""
    layout = drawn()
    ((name, arguments),) = layout.buttons
    assert name == "radtex.apply_remedy"
    assert ops.radtex.apply_remedy(**vars(arguments)) == {"FINISHED"}
    return layout.texts[-1]


def test_a_missing_uv_map_is_cleared_and_a_step_to_undo() -> None:
    context.object.data.uv_layers.remove(context.object.data.uv_layers[0])
    settings().uv_layer = "None such"
    bpy.ops.ed.undo_push(message="chosen")
    assert seen().errors
    assert pressed() == "Clear UV Map"
    assert (settings().uv_layer, seen().errors) == ("", ())
    bpy.ops.ed.undo()
    assert settings().uv_layer == "None such"


def test_a_storage_that_does_not_take_the_light_becomes_another() -> None:
    settings().kind, settings().atlas_layout = "incident", "layered"
    assert pressed() == "Storage: Buckets"
    assert (settings().atlas_layout, seen().errors) == ("buckets", ())


def test_an_objects_own_settings_are_changed_where_it_has_them() -> None:
    item: Any = context.object
    item.radtex.use = True
    item.radtex.kind, item.radtex.atlas_layout = "incident", "layered"
    pressed()
    assert (item.radtex.atlas_layout, settings().atlas_layout) == ("buckets", "auto")
    item.radtex.atlas_layout = "layered"
    bpy.ops.mesh.primitive_plane_add()
    item.select_set(True)
    assert drawn().buttons == [], "there are two objects, and settings of each"


def test_preferences_are_shown_where_a_message_names_them() -> None:
    preferences().device = "metal"
    assert "device" in drawn().settings
    preferences().device = "auto"
    assert drawn().settings == []


def test_every_setting_of_a_message_is_one_of_the_panels() -> None:
    assert all(name in settings().bl_rna.properties for name in PROPERTIES.values())
    assert all(name in preferences().bl_rna.properties for name in PREFERENCES.values())
    assert {*PROPERTIES, *PREFERENCES} <= LABELS.keys()
    told = Message("full", (do("ask for fewer", Setting.DENSITY), do("go on", Setting.RESUME)))
    assert [(offer.name, offer.text) for offer in offers(told, settings())] == [("density", "")]


def test_what_cannot_be_set_is_said() -> None:
    with pytest.raises(RuntimeError, match="There is no setting 'colour'"):
        ops.radtex.apply_remedy(name="colour", value="red")
    with pytest.raises(RuntimeError, match="unwrap cannot be 'by hand'"):
        ops.radtex.apply_remedy(name="unwrap", value="by hand")
