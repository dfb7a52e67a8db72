# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The operator offers what a BakeSpec takes, and only where there is something to bake."""

from __future__ import annotations

from collections.abc import Iterator

import bpy
import pytest

from radtex_addon.bake.spec import BakeSpec, Kind, Layout
from radtex_addon.ui import registration
from radtex_addon.ui.settings.menu_items import KINDS, LAYOUTS


@pytest.fixture(autouse=True)
def registered(empty_file: None) -> Iterator[None]:
    registration.register()
    yield
    registration.unregister()


def test_every_kind_and_layout_can_be_chosen() -> None:
    assert [identifier for identifier, _, _ in KINDS] == [kind.value for kind in Kind]
    assert [identifier for identifier, _, _ in LAYOUTS] == [layout.value for layout in Layout]


@pytest.mark.parametrize("name", ["kind", "texels", "samples"])
def test_the_operator_starts_from_the_specs_defaults(name: str) -> None:
    setting = bpy.ops.radtex.bake.get_rna_type().properties[name]  # type: ignore[attr-defined]  # ours, not Blender's
    assert setting.default == getattr(BakeSpec(), name)


def test_the_operators_cells_are_those_of_the_layout_that_is_chosen_for_itself() -> None:
    properties = bpy.ops.radtex.bake.get_rna_type().properties  # type: ignore[attr-defined]  # ours, not Blender's
    found = (properties["atlas_layout"].default, properties["bucket"].default)
    assert found == ("auto", Layout.LAYERED.cells)


def test_saved_files_keep_their_layouts() -> None:
    """Blender saves a choice by its number."""
    setting = bpy.ops.radtex.bake.get_rna_type().properties["atlas_layout"]  # type: ignore[attr-defined]  # ours, not Blender's
    numbers = {item.identifier: item.value for item in setting.enum_items}
    assert numbers == {"buckets": 0, "auto": 2, "layered": 3}


def test_every_setting_has_a_tooltip() -> None:
    properties = bpy.ops.radtex.bake.get_rna_type().properties  # type: ignore[attr-defined]  # ours, not Blender's
    assert all(setting.description for setting in properties if setting.identifier != "rna_type")


@pytest.mark.parametrize("kind_of_object", ["nothing", "light"])
def test_without_a_mesh_the_operator_is_greyed_out(kind_of_object: str) -> None:
    if kind_of_object == "light":
        bpy.ops.object.light_add()
    assert not bpy.ops.radtex.bake.poll()  # type: ignore[attr-defined]  # ours, not Blender's


def test_with_a_mesh_the_operator_is_ready() -> None:
    bpy.ops.mesh.primitive_plane_add()
    assert bpy.ops.radtex.bake.poll()  # type: ignore[attr-defined]  # ours, not Blender's
