# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The exported .glb for everybody else: Khronos's validator, and three.js without a word of our extension."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from tests.real.browser import Shown, decoded
from tests.real.exhibit import CAMERAS, Exhibit
from tests.real.root import REPOSITORY
from tests.real.web import SOURCES, Site, encoded, node

INSIDE = REPOSITORY / "tests/real/inside"
FORMS = ("plain", "layered")


@pytest.mark.parametrize("form", FORMS)
def test_the_mesh_is_valid(web: Site, exhibit: Exhibit, form: str) -> None:
    (mesh,) = web.add(form, getattr(exhibit, form)).glob("*.glb")
    report = json.loads(node("node", str(INSIDE / "validate.mjs"), str(mesh), str(SOURCES)))
    issues = report["issues"]
    print(f"{form}: {issues['numErrors']} errors, {issues['numWarnings']} warnings")
    assert report["info"]["totalTriangleCount"] > 0
    assert (issues["numErrors"], issues["numWarnings"]) == (0, 0), issues["messages"]


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
