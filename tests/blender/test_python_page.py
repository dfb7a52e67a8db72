# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""docs/reference/python.md: its example runs as it stands there, but for a small atlas and another target."""

from __future__ import annotations

import re
from pathlib import Path

import bpy
import pytest

from radtex_addon.formats.sidecar_file import SidecarFile

pytestmark = pytest.mark.one_blender
PAGE = Path(__file__).resolve().parents[2] / "docs/reference/python.md"


def example() -> str:
    found = re.search(r"^```python\n(.*?)^```$", PAGE.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
    assert found is not None
    return found[1]


def test_the_example_bakes_and_exports(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    bpy.ops.mesh.primitive_uv_sphere_add(segments=8, ring_count=6)
    bpy.context.object.name = "Vase"
    bpy.ops.object.light_add(location=(2, 2, 2))
    scene = tmp_path / "room.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(scene))
    smaller = example().replace("texels=64", "texels=32, samples=1").replace("room.blend", str(scene))
    exec(smaller.replace("Target.WEB", "Target.RAW"), {})  # the web page may not be built
    facts = SidecarFile.read(tmp_path / "baked/Vase.radiance.json").facts.values
    assert (facts["layout"], max(facts["texels"]), facts["samples"]) == ("layered", 32, 1)
    assert (tmp_path / "baked/Vase.raw/Vase.glb").is_file()
