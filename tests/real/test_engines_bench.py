# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The bench of programs (tests/bench/engines) on a scene small enough for a test."""

from __future__ import annotations

from pathlib import Path

import bpy
import pytest

from tests.bench.engines.__main__ import Programs, Settings, measured
from tests.bench.engines.report import LOOKUP, table
from tests.bench.fidelity.scenes.materials import assign, principled
from tests.bench.fidelity.scenes.meshes import as_subject, made
from tests.bench.fidelity.scenes.stage import Stage, finish, start
from tests.real.root import Root
from tests.real.web import Site

LEAST = 20.0  # dB against the path-traced picture
APART = 1.5  # dB between the preview and the reference lookup, and between Godot and the page


def sheet() -> Stage:
    """A dull upright sheet, half clear, whose back has faces of its own."""
    start("courtyard.exr", strength=0.8, turn=40)
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=6, y_subdivisions=6, rotation=(1.3, 0, 0.5))
    item = as_subject(made())
    assign(item, principled("Film", (0.7, 0.3, 0.2), Roughness=0.7, Alpha=0.5))
    return finish("sheet", item, see_through=True)


def test_programs_show_what_the_reference_lookup_sees(
    web: Site, root: Root, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The page and Godot blend display values, the others light. Eevee takes a minute for its shaders."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
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
