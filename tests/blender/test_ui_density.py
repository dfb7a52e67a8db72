# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel's Density asks for what it says, and a line for each object says what it means."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf
from pathlib import Path

import bpy
import pytest

from radtex_addon.core.messages import Setting
from radtex_addon.formats.sidecar import read_sidecar
from radtex_addon.settings import spec as bake_spec
from radtex_addon.ui.panel import forecast, panel_state
from radtex_addon.ui.panel.labels import LABELS
from radtex_addon.ui.settings.presets import apply_preset
from radtex_addon.ui.settings.request import spec_of, values_of, values_with
from tests.blender import stage
from tests.blender.ui_stage import context, ops, registered, settings


@pytest.fixture(autouse=True)
def _registered(empty_file: None, tmp_path: Path) -> Iterator[None]:
    with registered():
        stage.world()
        settings().directory = str(tmp_path / "out")
        settings().atlas_layout = "buckets"
        settings().bucket, settings().samples = 2, 1
        yield


def cube(name: str, size: float) -> None:
    bpy.ops.mesh.primitive_cube_add(size=size)
    context.object.name = name


def sizes() -> tuple[str, ...]:
    return panel_state.refresh(context.scene, context.view_layer).sizes


def test_the_density_counts_once_it_is_chosen() -> None:
    settings().density = 32
    assert spec_of(values_of(settings())).density is None
    settings().atlas_size = "density"
    assert spec_of(values_of(settings())).density == 32
    assert LABELS[Setting.DENSITY] == settings().bl_rna.properties["density"].name


def test_a_script_that_names_one_of_the_two_means_it() -> None:
    for named, other in (("density", "texels"), ("texels", "density")):
        settings().atlas_size = other
        assert values_with(settings(), settings(), [named])["atlas_size"] == named
    assert values_with(settings(), settings(), ["texels", "density"])["atlas_size"] == "density"


def test_a_preset_of_ours_is_of_texels() -> None:
    settings().atlas_size = "density"
    apply_preset("draft")
    assert spec_of(values_of(settings())).density is None


def test_each_selected_object_has_a_line(monkeypatch: pytest.MonkeyPatch) -> None:
    cube("Cup", 1)
    cube("Box", 3)
    bpy.ops.object.select_all(action="SELECT")
    assert sizes() == ()
    settings().atlas_size, settings().density = "density", 32
    assert sizes() == ("Box: about 300 × 300 texels", "Cup: about 112 × 112 texels")
    settings().together = "one"
    assert sizes() == ("Atlas: about 312 × 312 texels",)
    settings().together = "off"
    monkeypatch.setattr(bake_spec, "MOST_TEXELS", 128)
    box, cup = sizes()
    assert cup == "Cup: about 112 × 112 texels"
    assert box == (
        "'Box' would need about 300 texels along a side for 32 texels per metre; 128 is the most, which "
        "gives it about 13.65 texels per metre: ask for fewer (Density)"
    )


def test_what_is_baked_is_told_exactly_and_the_cost_is_of_the_estimate() -> None:
    cube("Cup", 1)
    settings().atlas_size, settings().density = "density", 32
    found = panel_state.refresh(context.scene, context.view_layer)
    assert found.spec is not None
    assert (found.spec.texels, found.spec.density) == (112, 32)
    assert found.cost is not None
    assert found.cost.side == 2 * 112
    assert ops.radtex.bake(wait=True) == {"FINISHED"}
    made = read_sidecar(Path(settings().directory) / "Cup.radiance.json")
    assert sizes() == (f"Cup: {made.width} × {made.height} texels, as baked",)
    settings().density = 16
    assert "about" in sizes()[0]


@pytest.mark.parametrize(("patience", "lines"), [(inf, 9), (0.0, 2)], ids=["enough time", "none"])
def test_many_objects_have_eight_lines_and_a_count(
    patience: float, lines: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    for number in range(10):
        cube(f"Cup {number}", 1)
    bpy.ops.object.select_all(action="SELECT")
    settings().atlas_size = "density"
    monkeypatch.setattr(forecast, "_PATIENCE", patience)
    assert len(sizes()) == lines
    assert sizes()[-1] == f"and {11 - lines} more"
