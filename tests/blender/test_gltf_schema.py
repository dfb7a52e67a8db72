# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Exports of every kind and layout against the JSON Schema of our glTF extension."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pytest

from radtex_addon.bake.progress import finished
from radtex_addon.export.exporting import export_steps
from radtex_addon.formats.containers.glb import Glb
from tests.blender.every_kind import EXPORTS, bake_every_kind
from tests.gltf_schema import extensions_of, problems


@pytest.fixture(scope="module")
def bakes(tmp_path_factory: pytest.TempPathFactory) -> Mapping[str, Path]:
    """Sidecars by kind; not to be written to."""
    return bake_every_kind(tmp_path_factory.mktemp("kinds"))


@pytest.mark.parametrize("name", EXPORTS)
def test_an_export_is_valid(name: str, bakes: Mapping[str, Path], tmp_path: Path) -> None:
    kind, spec = EXPORTS[name]
    made = finished(export_steps(bakes[kind], spec, tmp_path / "made"))
    glb = made.folder / f"{made.name}.glb"
    found = extensions_of(glb)
    assert len(found) == (2 if kind == "layered" else 1)
    for number, facts in enumerate(found):
        assert problems(facts) == []
        assert facts.get("material", 0) == number
        assert ("mirror" in facts) == spec.mirror
        for texture in (*facts["textures"].values(), *([facts["mirror"]] if spec.mirror else [])):
            assert (made.folder / texture["uri"]).is_file()
    materials = Glb.read(glb).document["materials"]
    assert [each.get("extras", {}) for each in materials] == (
        [{"radtex_material": 0}, {"radtex_material": 1}] if kind == "layered" else [{}]
    )
