# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets make bakes that can be, cost more the better they are, and are kept as Blender keeps them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
import pytest

from radtex_addon.forms import cost_of
from radtex_addon.settings import cost
from radtex_addon.settings.presets import STOCK, SUBDIR
from radtex_addon.settings.spec import BakeSpec, Layout
from radtex_addon.ui.settings.presets import PRESET_NAMES, is_applied
from radtex_addon.ui.settings.request import spec_of, values_of
from tests.blender.ui_stage import ops, preferences, registered, settings

NAMES = [name for name, _, _ in STOCK]


@pytest.fixture(autouse=True)
def _registered(empty_file: None) -> Iterator[None]:
    with registered():
        yield


def applied(name: str) -> BakeSpec:
    assert ops.radtex.preset_apply(name=name) == {"FINISHED"}
    return spec_of(values_of(settings()))


def layered(spec: BakeSpec) -> BakeSpec:
    """The specification that an automatic layout comes to, for most objects."""
    if settings().atlas_layout != "auto":
        return spec
    return replace(spec, layout=Layout.LAYERED, bucket=Layout.LAYERED.cells)


@pytest.mark.parametrize("name", NAMES)
def test_a_stock_preset_is_a_bake_for_a_machine_of_8_gb(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cost, "physical_memory", lambda: 8 * 10**9)
    applied(name)


def test_blender_finds_the_stock_presets_and_no_others() -> None:
    (folder,) = bpy.utils.preset_paths(SUBDIR)
    assert sorted(path.stem for path in Path(folder).glob("*.py")) == sorted(NAMES)


def test_a_better_preset_traces_more_paths() -> None:
    draft, preview, final = (cost_of(layered(applied(name))) for name in ("draft", "preview", "final"))
    assert 3 * draft.paths < 2 * preview.paths < final.paths
    assert draft.paths < 1_000_000


def test_what_is_mirrored_is_layered_and_what_is_matt_needs_few_cells() -> None:
    assert applied("mirror_like").layout is Layout.LAYERED
    matt = applied("diffuse_like")
    assert (matt.layout, matt.bucket) == (Layout.BUCKETS, 4)


@pytest.mark.parametrize("name", NAMES)
def test_a_preset_leaves_nothing_of_the_one_before(name: str) -> None:
    expected = applied(name)
    for other in NAMES:
        applied(other)
        assert applied(name) == expected, other


def test_new_files_are_set_as_for_a_preview() -> None:
    assert [name for name in NAMES if is_applied(name, settings())] == ["preview"]


def test_ones_own_preset_is_kept_applied_and_removed() -> None:
    settings().texels, settings().samples, settings().directory = 99, 3, "/elsewhere"
    assert ops.radtex.preset_add(name="My Pots") == {"FINISHED"}
    expected = values_of(settings())
    applied("draft")
    settings().directory = "/here"
    applied("My Pots")
    found = values_of(settings())
    assert {name: found[name] for name in PRESET_NAMES} == {name: expected[name] for name in PRESET_NAMES}
    assert found["directory"] == "/here"  # where to is not a preset's matter
    assert ops.radtex.preset_add(remove_name=True, name="My Pots") == {"FINISHED"}
    with pytest.raises(RuntimeError, match="There is no preset 'My Pots'"):
        ops.radtex.preset_apply(name="My Pots")


def test_a_preset_of_ones_own_has_the_settings_that_the_panel_shows() -> None:
    bpy.ops.mesh.primitive_plane_add()
    shown: Any = bpy.context.object
    settings().texels = 32
    shown.radtex.use, shown.radtex.texels = True, 77
    assert ops.radtex.preset_add(name="My Cup") == {"FINISHED"}
    shown.radtex.use = False
    applied("My Cup")
    assert settings().texels == 77
    assert ops.radtex.preset_add(remove_name=True, name="My Cup") == {"FINISHED"}


def test_new_files_start_from_the_default_preset_and_saved_ones_do_not(tmp_path: Path) -> None:
    path = str(tmp_path / "scene.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    preferences().default_preset = "diffuse_like"
    bpy.ops.wm.open_mainfile(filepath=path)
    assert settings().bucket == 14
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    assert settings().bucket == 4


def test_a_script_s_preset_is_a_step_to_undo() -> None:
    applied("draft")
    before = values_of(settings())
    applied("final")
    after = values_of(settings())
    bpy.ops.ed.undo()
    assert values_of(settings()) == before
    bpy.ops.ed.redo()
    assert values_of(settings()) == after
