# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The exported .glb by Khronos's validator, which .ci/build_web.py installs from npm by its lock file."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

from radtex_addon.bake.progress import finished
from radtex_addon.export.exporting import export_steps
from radtex_addon.export.exporting_scene import export_scene_steps
from radtex_addon.formats.containers.glb import Glb
from radtex_addon.textures.export_spec import ExportSpec, Target
from tests.blender.every_kind import EXPORTS, bake_every_kind
from tests.gltf_schema import EXTENSION_FOLDER
from tests.real.exhibit import Bake, Exhibit, Form
from tests.real.web import build_page, node

VALIDATE = """
const fs = require("fs"), validator = require("gltf-validator");
validator.validateBytes(new Uint8Array(fs.readFileSync(process.argv[1])), { maxIssues: 0 })
  .then((report) => process.stdout.write(JSON.stringify(report)));
"""
# What it tells as information, as docs/gltf/RADTEX_radiance_texture/README.md lists it: it does not know our
# extension, nor what we need tangents and levels of detail for, and textures may have any size by now.
KNOWN = {"UNSUPPORTED_EXTENSION", "UNUSED_MESH_TANGENT", "UNUSED_OBJECT", "IMAGE_NPOT_DIMENSIONS"}
README = EXTENSION_FOLDER / "README.md"


@pytest.fixture(scope="module", autouse=True)
def _packages() -> None:
    """The validator comes with what the page is built by."""
    build_page()


def validated(glb: Path) -> dict[str, Any]:
    report: dict[str, Any] = json.loads(node("node", "-e", VALIDATE, str(glb)))
    return report


def codes(report: dict[str, Any]) -> set[str]:
    """What a report without errors and warnings tells."""
    issues = report["issues"]
    assert (issues["numErrors"], issues["numWarnings"]) == (0, 0), issues["messages"]
    return {message["code"] for message in issues["messages"]}


def exported(bake: Bake, folder: Path) -> Path:
    made = finished(export_steps(bake.sidecar, ExportSpec(Target.GLTF), folder))
    return made.folder / f"{made.name}.glb"


@pytest.mark.parametrize("form", Form)
def test_the_validator_finds_no_error(form: Form, exhibit: Exhibit, tmp_path: Path) -> None:
    report = validated(exported(getattr(exhibit, form), tmp_path / "made"))
    assert codes(report) <= KNOWN
    facts = report["info"]
    materials = 2 if form is Form.LAYERED else 1
    assert (facts["materialCount"], facts["drawCallCount"]) == (materials, materials)
    assert facts["totalTriangleCount"] == 15744
    assert facts["resources"][1]["image"]["transfer"] == "srgb"


def test_every_kind_and_a_scene_have_no_error_and_no_warning(room: list[Path], tmp_path: Path) -> None:
    sidecars = bake_every_kind(tmp_path / "bakes")
    told = codes(validated(EXTENSION_FOLDER / "example" / "Ball.glb"))
    for name, (kind, spec) in EXPORTS.items():
        made = finished(export_steps(sidecars[kind], spec, tmp_path / name))
        told |= codes(validated(made.folder / f"{made.name}.glb"))
    steps = export_scene_steps(room, ExportSpec(Target.GLTF), "Room", tmp_path / "room")
    told |= codes(validated(finished(steps).folder / "Room.glb"))
    print(sorted(told))
    assert told == KNOWN
    listed = set(re.findall(r"^\| `([A-Z_]+)` \|", README.read_text(encoding="utf-8"), re.MULTILINE))
    assert listed - {"POSITION", "NORMAL", "TANGENT", "TEXCOORD_0"} == KNOWN


def test_it_would_find_a_tangent_that_is_no_unit(exhibit: Exhibit, tmp_path: Path) -> None:
    path = exported(exhibit.plain, tmp_path / "made")
    glb = Glb.read(path)
    attributes = glb.document["meshes"][0]["primitives"][0]["attributes"]
    attributes["TANGENT"] = glb.add_vertices(4 * glb.accessor(attributes["TANGENT"]))
    glb.write(path)
    messages = validated(path)["issues"]["messages"]
    assert "ACCESSOR_VECTOR3_NON_UNIT" in {message["code"] for message in messages}
