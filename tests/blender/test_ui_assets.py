# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel bakes chosen objects that touch as one asset, says so, and lets that be turned off."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import bpy
import pytest

from radtex_addon.preview.swap import copy_of
from radtex_addon.store.checkpoint import announce
from radtex_addon.store.output_files import OutputFiles
from radtex_addon.ui.operators.compare_operator import RADTEX_OT_compare
from radtex_addon.ui.operators.estimate_operator import _bakes
from radtex_addon.ui.panel import main_panel, panel_state
from radtex_addon.ui.panel.main_panel import time_and_size, told_assets
from radtex_addon.ui.panel.panel_state import Forecast, ShownAsset
from radtex_addon.ui.settings.baked_groups import baked_groups
from radtex_addon.ui.settings.request import spec_of, values_of
from tests.blender import stage
from tests.blender.recorded_layout import RecordedLayout
from tests.blender.ui_stage import context, ops, registered, settings

LAMP = ("Foot", "Shade")


@pytest.fixture(autouse=True)
def _lamp(out: Path) -> Iterator[None]:
    """A lamp of two parts on a floor, and a cup five centimetres away; all but the floor are selected."""
    stage.world()
    gloss = stage.material("Gloss", "ShaderNodeBsdfPrincipled", Roughness=0.3)
    bpy.ops.mesh.primitive_plane_add(size=6)
    context.object.name = "Floor"
    for name, size, place in (
        ("Foot", 0.5, (0, 0, 0.25)),
        ("Shade", 0.6, (0, 0, 0.8)),
        ("Cup", 0.2, (0.4, 0, 0.1)),
    ):
        bpy.ops.mesh.primitive_cube_add(size=size, location=place)
        context.object.name = name
    for item in context.scene.objects:
        item.data.materials.append(gloss)
        item.select_set(item.name != "Floor")
    with registered():
        settings().directory = str(out)
        yield


def seen() -> Forecast:
    return panel_state.refresh(context.scene, context.view_layer)


def drawn(cls: Any) -> RecordedLayout:
    layout: Any = RecordedLayout()
    cls.draw(SimpleNamespace(layout=layout), context)
    found: RecordedLayout = layout
    return found


def test_the_panel_offers_one_asset_and_its_cost() -> None:
    found = seen()
    assert found.assets == (ShownAsset("Shade_asset", 2, 192),)
    assert (set(found.objects), found.bakes, found.atlases) == ({"Cup", *LAMP}, 2, 2)
    assert "each" in time_and_size(found)
    context.scene.objects["Cup"].select_set(False)
    found = seen()
    assert (found.bakes, found.atlases) == (1, 1)
    assert found.spec is not None
    assert found.cost is not None
    assert (found.spec.objects, found.spec.texels) == (LAMP, 192)
    assert "each" not in time_and_size(found)
    assert found.layout.startswith("Layered")
    ((name, spec),) = _bakes(context.scene, LAMP)
    assert (name, spec.objects, spec.texels) == ("Shade_asset", LAMP, 192)
    settings().texels = 512
    assert seen().assets[0].texels == 512


def test_the_choice_is_drawn_below_the_button_and_stays_while_it_is_off() -> None:
    seen()
    layout = drawn(main_panel.RADTEX_PT_bake)
    (line,) = [text for text in layout.texts if "touch" in text]
    assert line == told_assets(seen())[0][: len(line)]
    assert "together" in layout.settings
    settings().together = "off"
    found = seen()
    assert (found.assets, found.bakes) == ((), 3)
    layout = drawn(main_panel.RADTEX_PT_bake)
    assert "together" in layout.settings
    assert not [text for text in layout.texts if "touch" in text]
    settings().together = "auto"
    for name in LAMP:
        context.scene.objects[name].select_set(False)
    seen()
    assert "together" not in drawn(main_panel.RADTEX_PT_bake).settings, "there is nothing to choose"


def test_one_atlas_is_for_all_and_as_large_as_the_resolution() -> None:
    settings().together, settings().atlas_name = "one", "All"
    found = seen()
    assert (found.assets, found.bakes, found.atlases) == ((), 1, 1)
    assert found.spec is not None
    assert (len(found.spec.objects), found.spec.texels) == (3, 128)


def test_objects_with_settings_of_their_own_are_no_parts() -> None:
    context.scene.objects["Foot"].radtex.use = True
    assert seen().assets == ()


def test_a_source_is_part_of_no_asset() -> None:
    own = context.scene.objects["Cup"].radtex
    own.use, own.atlas_layout, own.source = True, "buckets", "Foot"
    groups = baked_groups(context.scene, ("Cup", *LAMP))
    assert [(group.names, group.is_asset) for group in groups] == [(("Cup",), False), (LAMP, False)]
    own.source = ""
    assert [group.is_asset for group in baked_groups(context.scene, ("Cup", *LAMP))] == [False, True]


def test_the_button_bakes_one_asset_which_stays_one_while_it_is_shown(out: Path) -> None:
    context.scene.objects["Cup"].select_set(False)
    settings().texels, settings().samples, settings().unwrap = 16, 1, "blender"
    assert ops.radtex.bake() == {"FINISHED"}
    found = sorted(path.name for path in out.glob("*.json"))
    assert found == ["Shade_asset.radiance.json"]
    assert seen().done == 1
    assert ops.radtex.preview_toggle() == {"FINISHED"}
    shown = seen()
    assert shown.shown == LAMP
    assert (shown.assets, shown.done) == ((ShownAsset("Shade_asset", 2, 64),), 1)
    assert ops.radtex.preview_toggle() == {"FINISHED"}
    assert ops.radtex.export(target="raw") == {"FINISHED"}
    assert [path.name for path in out.iterdir() if path.is_dir()] == ["Shade_asset.raw"]


def test_the_bake_of_an_asset_goes_before_those_of_its_parts(out: Path) -> None:
    context.scene.objects["Cup"].select_set(False)
    settings().texels, settings().samples, settings().unwrap = 16, 1, "blender"
    settings().together = "off"
    assert ops.radtex.bake() == {"FINISHED"}
    settings().together = "auto"
    assert ops.radtex.bake() == {"FINISHED"}
    assert len(list(out.glob("*.radiance.json"))) == 3
    assert ops.radtex.preview_toggle() == {"FINISHED"}
    worn = {copy_of(context.scene.objects[name]).material_slots[0].material.name for name in LAMP}
    assert worn == {"RadTex Shade_asset"}
    assert ops.radtex.preview_toggle() == {"FINISHED"}
    assert ops.radtex.export(target="raw") == {"FINISHED"}
    assert [path.name for path in out.iterdir() if path.is_dir()] == ["Shade_asset.raw"]
    lamp = [context.scene.objects[name] for name in LAMP]
    bakes, _ = RADTEX_OT_compare._bakes(cast(Any, None), context.scene, lamp, "")
    assert {each.path.name for each in bakes.values() if each} == {"Shade_asset.radiance.json"}
    settings().together = "off"
    assert ops.radtex.export(target="raw") == {"FINISHED"}
    assert {path.name for path in out.glob("*.raw")} == {"Shade_asset.raw", "Foot.raw", "Shade.raw"}


def test_an_asset_is_resumed_by_the_names_of_its_objects(out: Path) -> None:
    settings().texels, settings().samples, settings().unwrap = 16, 1, "blender"
    bpy.ops.object.select_all(action="DESELECT")
    spec = replace(spec_of(values_of(settings())), objects=LAMP, texels=64)
    announce(OutputFiles.of("Shade_asset", spec, out).unfinished, ())
    one = {"objects": "\n".join(LAMP), "together": "one", "atlas_name": "Shade_asset", "texels": 64}
    assert ops.radtex.bake(**one, resume=True) == {"FINISHED"}
    assert [path.name for path in out.glob("*.json")] == ["Shade_asset.radiance.json"]
