# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""One row makes a kind, and one folder with a row a form: both bake, show, export and are found finished."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.examples.extended import ROOT, add_form, add_kind, summary

pytestmark = pytest.mark.one_blender

BAKE = """
import json, sys
from pathlib import Path
import bpy
from radtex_addon.bake.spec import BakeSpec
from radtex_addon.core.sampler import Filter
from radtex_addon.export.exporting import export_steps
from radtex_addon.export.export_manifest import read_manifest
from radtex_addon.formats.containers.exr import read_buckets
from radtex_addon.job import bake_object
from radtex_addon.store.bake_folder import BakeFolder
from radtex_addon.textures.export_spec import ExportSpec, Target
from radtex_addon.ui.settings.menu_items import KINDS
from tests.blender import stage

bpy.ops.wm.read_factory_settings(use_empty=True)
stage.world((0.5, 0.25, 1.0))
bpy.ops.mesh.primitive_plane_add()
bpy.context.object.name = "Card"
out = Path(sys.argv[1])
spec = BakeSpec(kind="irradiance", uv_layer="UVMap", texels=4, bucket=4, samples=4, half=False)
result = bake_object(bpy.context.scene, "Card", spec, out, preview=Filter.LINEAR)
pixels, facts = read_buckets(result.files.sidecar)
steps = export_steps(result.files.sidecar, ExportSpec(Target.RAW))
while True:
    try:
        next(steps)
    except StopIteration as stop:
        exported = stop.value
        break
manifest = read_manifest(exported.folder / "Card.export.json")
print("RESULT " + json.dumps({
    "light": pixels[..., :3].mean(axis=(0, 1)).tolist(),
    "spread": float(pixels[..., :3].std(axis=(0, 1)).max()),
    "size": list(pixels.shape[:2]),
    "finished": BakeFolder("Card", spec, out).is_finished(),
    "offered": "irradiance" in [name for name, _, _ in KINDS],
    "preview": result.files.preview.is_file(),
    "textures": list(manifest.textures),
}))
"""


@pytest.mark.parametrize(("add", "cells"), [(add_kind, 4), (add_form, 1)])
def test_what_is_added_bakes_and_exports(add: Callable[[Path], Path], cells: int, tmp_path: Path) -> None:
    package = add(tmp_path / "copy")
    environment = {name: value for name, value in os.environ.items() if name != "OCIO"}
    environment["PYTHONPATH"] = os.pathsep.join([str(package.parent), str(ROOT)])
    command = [sys.executable, "-c", BAKE, str(tmp_path / "out")]
    ended = subprocess.run(
        command, cwd=package.parent, env=environment, capture_output=True, text=True, check=False
    )
    assert ended.returncode == 0, ended.stderr[-4000:]
    found = json.loads(next(line for line in ended.stdout.splitlines() if line.startswith("RESULT "))[7:])
    assert found["light"] == pytest.approx([0.5, 0.25, 1.0], rel=1e-3)
    assert found["spread"] < 1e-3
    assert found["size"] == [4 * cells, 4 * cells]
    assert found["finished"]
    assert found["offered"]
    assert found["preview"]
    assert found["textures"] == ["irradiance"]


def test_what_is_added_is_what_the_documentation_says(tmp_path: Path) -> None:
    assert summary(add_kind(tmp_path / "kind")) == ["bake/kinds.py: edited, +10"]
    edited = ["bake/forms.py: edited, +2", "bake/kinds.py: edited, +12"]
    new = [line.partition(":")[0] for line in summary(add_form(tmp_path / "form")) if ": new" in line]
    assert [line for line in summary(add_form(tmp_path / "again")) if ": edited" in line] == edited
    assert new == ["forms/mean/__init__.py", "forms/mean/form.py"]
