# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The templates beside a farm's .blend, run for real: OpenJD by its own runner, Flamenco's by Node."""

from __future__ import annotations

import hashlib
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bpy
import pytest

from radtex_addon.job import bake_object
from radtex_addon.settings.spec import BakeSpec, Kind
from tests.blender import stage
from tests.blender.farming import BOX, prepared
from tests.real.nodes import BPY, OPENJD, NodeUnavailableError, ready_python
from tests.real.root import REPOSITORY
from tests.real.web import compiled_flamenco_job

FRAMES = 8
SPEC = BakeSpec(kind=Kind.INCIDENT, texels=16, bucket=8, samples=2, seed=9, sheet=48, uv_layer="UVMap")
NO_CRASH = """#!/bin/sh
# A node that loses frame 8, once.
case "$*" in *" -f 8"*) if [ ! -e '{mark}' ]; then touch '{mark}'; echo lost >&2; exit 1; fi;; esac
exec '{python}' '{runner}' "$@"
"""


@dataclass(frozen=True)
class Far:
    """A farm's folder, and the digest of the atlas that this machine baked."""

    folder: Path
    atlas: str


@pytest.fixture(scope="module")
def far(tmp_path_factory: pytest.TempPathFactory) -> Far:
    """A plane under lamps, eight sheets."""
    folder = tmp_path_factory.mktemp("farm")
    bpy.ops.wm.read_factory_settings(use_empty=True)
    stage.world((0.2, 0.3, 0.4))
    stage.lamps()
    bpy.ops.mesh.primitive_cube_add(size=0.5, location=(0.3, 0.2, 0.6))
    bpy.ops.mesh.primitive_plane_add()
    scene: Any = bpy.context.scene
    scene.objects["Plane"].name = BOX
    bake_object(scene, BOX, SPEC, folder / "local")
    farm = prepared(scene, SPEC, folder / "far")
    assert farm.manifest.sheets == FRAMES
    return Far(farm.files.folder, _digest(folder / "local"))


def _digest(folder: Path) -> str:
    return hashlib.sha256((folder / f"{BOX}.incident.exr").read_bytes()).hexdigest()


def _python(requirements: tuple[str, ...]) -> Path:
    if sys.platform != "linux" or sys.version_info < (3, 13):
        pytest.skip("farms run with Blender 5.2's tests, on Linux")
    try:
        return ready_python(requirements)
    except NodeUnavailableError as error:
        pytest.skip(str(error))


def _openjd(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    command = [str(_python(OPENJD) / "openjd"), "run", str(folder / "openjd.yaml"), *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=240)


def _assemble(folder: Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, str(REPOSITORY / "bake.py"), "assemble", str(folder), "--progress", "none"]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)


def test_openjd_renders_on_bare_nodes_and_repeats_what_failed(far: Far, tmp_path: Path) -> None:
    """Eight chunks, one of which fails; that one alone is run again; the atlas is the local bake's."""
    python = _python(BPY) / "python"
    bare = subprocess.run([python, "-c", "import OpenEXR"], capture_output=True, check=False)
    assert bare.returncode == 1  # a node has nothing of what RadTex needs
    flaky = tmp_path / "flaky"
    runner = far.folder / "render_frames.py"
    flaky.write_text(NO_CRASH.format(mark=tmp_path / "failed", python=python, runner=runner))
    flaky.chmod(0o755)
    first = _openjd(far.folder, "--step", "Render", "-p", f"Blender={flaky}")
    assert first.returncode != 0
    assert (tmp_path / "failed").exists()
    missing = _assemble(far.folder)
    assert missing.returncode == 1
    assert f"1 of {FRAMES} frames cannot be used: {FRAMES} missing" in missing.stderr
    again = _openjd(far.folder, "--step", "Render", "-p", f"Blender={flaky}", "-tp", f"Frame={FRAMES}")
    assert again.returncode == 0, again.stdout
    joins = f"{sys.executable} {REPOSITORY / 'bake.py'} assemble"
    joined = _openjd(far.folder, "--step", "Assemble", "--no-run-dependencies", "-p", f"Assemble={joins}")
    assert joined.returncode == 0, joined.stdout
    assert _digest(far.folder.parent) == far.atlas


def test_flamenco_compiles_the_job(far: Far) -> None:
    settings = {"frames": "1-5,8", "chunk_size": 2, "blendfile": "/farm/box/farm.blend"}
    script = far.folder / "radtex_farm.js"
    made = compiled_flamenco_job(script, settings)
    assert made["type"]["label"] == "RadTex farm"
    tasks = made["tasks"]
    assert [task["name"] for task in tasks] == ["sheets-1-2", "sheets-3-4", "sheets-5,8"]
    (command,) = tasks[2]["commands"]
    assert command["name"] == "blender-render"
    assert command["parameters"]["blendfile"] == "/farm/box/farm.blend"
    assert command["parameters"]["args"] == ["--render-frame", "5,8"]
    assert tasks[0]["commands"][0]["parameters"]["args"] == ["--render-frame", "1..2"]
    assert {task["type"] for task in tasks} == {"blender"}
    joined = compiled_flamenco_job(script, settings | {"assemble": "/opt/join"})["tasks"][-1]
    assert joined["dependencies"] == [task["name"] for task in tasks]
    assert joined["commands"] == [{"name": "exec", "parameters": {"exe": "/opt/join", "args": ["/farm/box"]}}]
