# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The exported .glb for everybody else: Khronos's validator, and three.js without a word of our extension."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np

from radtex_addon.bake.progress import finished
from radtex_addon.export.exporting import export_steps
from radtex_addon.export.exporting_scene import export_scene_steps
from radtex_addon.formats.containers.glb import Glb
from radtex_addon.textures.export_spec import ExportSpec, Target
from tests.blender.every_kind import EXPORTS, every_kind
from tests.blender.image_stage import bake_crate
from tests.finished_bakes import finished_bake
from tests.gltf_schema import EXTENSION_FOLDER
from tests.real.browser import Shown, decoded
from tests.real.exhibit import CAMERAS, SUBDIVISIONS, Bake, Exhibit, Form
from tests.real.root import REPOSITORY
from tests.real.web import SOURCES, Site, encoded, node

INSIDE = REPOSITORY / "tests/real/inside"

# What it tells as information, as docs/gltf/RADTEX_radiance_texture/README.md lists it: it does not know our
# extension, nor what we need tangents and levels of detail for, and textures may have any size by now.
KNOWN = {"UNSUPPORTED_EXTENSION", "UNUSED_MESH_TANGENT", "UNUSED_OBJECT", "IMAGE_NPOT_DIMENSIONS"}
README = EXTENSION_FOLDER / "README.md"


def validated(*files: Path) -> list[dict[str, Any]]:
    reports: list[dict[str, Any]] = json.loads(
        node("node", str(INSIDE / "validate.mjs"), str(SOURCES), *map(str, files))
    )
    return reports


def codes(report: dict[str, Any]) -> set[str]:
    """What a report without errors and warnings tells."""
    issues = report["issues"]
    assert (issues["numErrors"], issues["numWarnings"]) == (0, 0), issues["messages"]
    return {message["code"] for message in issues["messages"]}


def test_the_validator_finds_no_error_in_any_export(
    web: Site, exhibit: Exhibit, room: list[Path], tmp_path: Path
) -> None:
    """Of each kind, of a scene, and of both forms for glTF and for the web; and that it would find one."""
    files = [EXTENSION_FOLDER / "example" / "Ball.glb"]
    sidecars = every_kind(tmp_path / "bakes")
    for name, (kind, spec) in EXPORTS.items():
        made = finished(export_steps(sidecars[kind], spec, tmp_path / name))
        files.append(made.folder / f"{made.name}.glb")
    for name, mixed in (("crate", False), ("mixed", True)):
        crate = Bake(finished_bake(tmp_path / f"{name}-bake", bake_crate, mixed=mixed))
        made = finished(export_steps(crate.sidecar, ExportSpec(Target.GLTF), tmp_path / name))
        files.append(made.folder / f"{made.name}.glb")
    made = finished(export_scene_steps(room, ExportSpec(Target.GLTF), "Room", tmp_path / "room"))
    files.append(made.folder / "Room.glb")
    heads = []
    for form in Form:
        bake: Bake = getattr(exhibit, form)
        made = finished(export_steps(bake.sidecar, ExportSpec(Target.GLTF), tmp_path / f"head-{form}"))
        heads += [made.folder / f"{made.name}.glb", next(web.add(form, bake).glob("*.glb"))]
    reports = validated(*files, *heads, spoilt(heads[0], tmp_path))
    told = set().union(*map(codes, reports[: len(files)]))
    print(sorted(told))
    assert told == KNOWN
    listed = set(re.findall(r"^\| `([A-Z_]+)` \|", README.read_text(encoding="utf-8"), re.MULTILINE))
    assert listed - {"POSITION", "NORMAL", "TANGENT", "TEXCOORD_0"} == KNOWN
    for report, materials in zip(reports[len(files) : -1], (1, 1, 2, 2), strict=True):
        assert codes(report) <= KNOWN
        facts = report["info"]
        assert (facts["materialCount"], facts["drawCallCount"]) == (materials, materials)
        assert facts["totalTriangleCount"] == 984 * 4**SUBDIVISIONS
        assert [each["image"]["transfer"] for each in facts["resources"] if "image" in each] == ["srgb"]
    assert "ACCESSOR_VECTOR3_NON_UNIT" in {each["code"] for each in reports[-1]["issues"]["messages"]}


def spoilt(file: Path, folder: Path) -> Path:
    """The file with tangents that are no units."""
    glb = Glb.read(file)
    attributes = glb.document["meshes"][0]["primitives"][0]["attributes"]
    attributes["TANGENT"] = glb.add_vertices(4 * glb.accessor(attributes["TANGENT"]))
    glb.write(folder / "spoilt.glb")
    return folder / "spoilt.glb"


def test_threejs_shows_the_flat_lightmap(web: Site, exhibit: Exhibit, tmp_path: Path) -> None:
    folder = web.add("plain", exhibit.plain)
    (mesh,) = folder.glob("*.glb")
    script = folder / "plain_three.js"
    node(
        *("npx", "esbuild", str(INSIDE / "plain_three.js"), "--bundle", "--format=iife"),
        *(f"--alias:three={SOURCES / 'node_modules/three'}", f"--outfile={script}", "--log-level=error"),
    )
    (folder / "plain.html").write_text('<canvas id="view"></canvas><script src="plain_three.js"></script>')
    camera = CAMERAS[0]
    with web.opened("plain/") as shown:
        ours = shown.wait()
        ours.set_camera(camera)
        flat = ours.pixels(flat=True)[..., :3]
        scale = json.loads(next(folder.glob("*.export.json")).read_text())["flat_scale"]
    said: list[str] = []
    with web.opened("plain/plain.html") as shown:
        shown.page.on("console", lambda message: said.append(f"{message.type}: {message.text}"))
        made = shown.page.evaluate("([file, camera]) => draw(file, camera)", [mesh.name, Shown.view(camera)])
        theirs = decoded(made).reshape(camera.pixels, camera.pixels, 4)[..., :3]
    assert not any("GLTFLoader" in line for line in said), said
    mask = exhibit.plain.eroded(camera)
    assert mask.sum() > 5000
    difference = np.abs(theirs - encoded(flat * scale)).max(axis=2)[mask]
    assert np.quantile(difference, 0.9) < 0.03
