# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The bench of programs (tests/bench/engines) on a scene small enough for a test."""

from __future__ import annotations

from pathlib import Path
from typing import Any, cast

import bpy
import pytest

from tests.bench.engines import looking, programs
from tests.bench.engines.__main__ import Programs, Settings, measured
from tests.bench.engines.report import LOOKUP, table
from tests.bench.fidelity.scenes.materials import assign, connect, principled
from tests.bench.fidelity.scenes.meshes import as_subject, made
from tests.bench.fidelity.scenes.stage import Stage, finish, start
from tests.blender.surroundings import sample_sky_coarsely
from tests.real.root import Root
from tests.real.web import Site

LEAST = 20.0  # dB against the path-traced picture
APART = 1.5  # dB between the preview and the reference lookup, and between Godot and the page
SOFT_EDGES = 4.0  # dB that edges may cost in Godot


def sheet() -> Stage:
    """A dull upright sheet, half clear, whose back has faces of its own."""
    start("courtyard.exr", strength=0.8, turn=40)
    sample_sky_coarsely()
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=6, y_subdivisions=6, rotation=(1.3, 0, 0.5))
    item = as_subject(made())
    assign(item, principled("Film", (0.7, 0.3, 0.2), Roughness=0.7, Alpha=0.5))
    return finish("sheet", item, see_through=True)


def sieves() -> Stage:
    """Three upright sheets with square holes, one behind another: the outer ones are drawn first."""
    start("courtyard.exr", strength=0.8, turn=40)
    sample_sky_coarsely()
    sheets = []
    for away, colour in ((-0.5, (0.7, 0.2, 0.1)), (0.5, (0.1, 0.3, 0.7)), (0.0, (0.8, 0.8, 0.2))):
        bpy.ops.mesh.primitive_plane_add(rotation=(1.5, 0, 0.5), location=(0, away, 0))
        sheets.append(made())
        film = principled(f"Sieve {away}", colour, Roughness=0.8)
        holes: Any = cast(Any, film.node_tree).nodes.new("ShaderNodeTexChecker")
        holes.inputs["Scale"].default_value = 4
        place = cast(Any, film.node_tree).nodes.new("ShaderNodeTexCoord")
        cast(Any, film.node_tree).links.new(place.outputs["UV"], holes.inputs["Vector"])
        connect(film, "Alpha", holes.outputs["Fac" if "Fac" in holes.outputs else "Factor"])
        assign(sheets[-1], film)
    for each in sheets:
        each.select_set(True)
    cast(Any, bpy.context.view_layer).objects.active = sheets[0]
    bpy.ops.object.join()
    return finish("sieves", as_subject(made()), see_through=True)


@pytest.fixture(params=[1])
def few_rays(request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures of fewer pixels than those that are measured by hand, and no reference of an earlier run."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    for module in (looking, programs):
        monkeypatch.setattr(module, "RAYS", request.param)


def test_programs_show_what_the_reference_lookup_sees(
    web: Site, root: Root, tmp_path: Path, few_rays: None
) -> None:
    """The page and Godot blend display values, the others light. Eevee takes a minute for its shaders."""
    settings = Settings(texels=24, views=1, samples=16, spp=4, by=("Chromium", "Godot", "Cycles"))
    strip = tmp_path / "sheet.png"
    row = measured(sheet, settings, Programs(root, web), strip)
    print(table({"sheet": row}))
    assert strip.is_file()
    assert row.layout == "layered"
    assert set(row.decibels) == {LOOKUP, *settings.by}
    assert min(row.decibels.values()) > LEAST
    assert abs(row.decibels["Cycles"] - row.decibels[LOOKUP]) < APART
    assert abs(row.decibels["Godot"] - row.decibels["Chromium"]) < APART


@pytest.mark.parametrize("few_rays", [2], indirect=True)  # for the edges
def test_what_is_cut_out_hides_nothing(web: Site, root: Root, tmp_path: Path, few_rays: None) -> None:
    """Holes are neither drawn nor written as depths: what lies behind them is seen through them.

    Godot blends soft edges in the order of the mesh, which costs 2 dB; with depths in holes it would be 7.
    """
    settings = Settings(texels=48, views=1, samples=16, spp=1, by=("Chromium", "Godot"))
    row = measured(sieves, settings, Programs(root, web), tmp_path / "sieves.png")
    print(table({"sieves": row}))
    assert row.decibels["Chromium"] > row.decibels[LOOKUP] - APART
    assert row.decibels["Godot"] > row.decibels[LOOKUP] - SOFT_EDGES
