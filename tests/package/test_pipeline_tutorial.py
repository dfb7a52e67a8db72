# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The commands of docs/tutorials/pipeline.md, run in their order on a small scene.

Each `sh` block is run by a shell as it stands there, but for two things: bakes and reports are smaller, and
`uv run`, which a test machine may lack, is this test's own Python.
"""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import bpy
import pytest

from radtex_addon.export.targets.web import BUILT

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs/tutorials/pipeline.md"
SMALLER = {
    "farmed --save-preview --texels 128 --samples 16": "farmed --save-preview --texels 16 --samples 1",
    "--texels 128 --samples 16": "--texels 32 --bucket 2 --samples 1 --layout buckets",
    "--views 3 --pixels 256 --samples 128": "--views 1 --pixels 32 --samples 1",
}
_PYTHON, _ROOT = shlex.quote(sys.executable), shlex.quote(str(ROOT))
SHELL = f"""
set -e
RADTEX={_ROOT}
uv() {{ shift 3; {_PYTHON} "$@"; }}  # run, --project and the folder
"""
REGISTERED = "from tests.blender.ui_stage import registered; on = registered(); on.__enter__()\n"
pytestmark = [
    pytest.mark.one_blender,  # tests/blender runs all commands on each
    pytest.mark.skipif(
        os.name == "nt" or shutil.which("bash") is None, reason="no shell runs the tutorial's commands"
    ),
    pytest.mark.skipif(
        not (BUILT / "index.html").is_file(), reason="uv run .ci/build_web.py builds the page"
    ),
]


def blocks(language: str) -> list[str]:
    """The fenced blocks of that language, made smaller."""
    page = PAGE.read_text(encoding="utf-8")
    found: list[str] = re.findall(rf"^```{language}\n(.+?)^```", page, re.MULTILINE | re.DOTALL)
    for large, small in SMALLER.items():
        found = [block.replace(large, small) for block in found]
    return found


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with room.blend: three white things of a collection in white light."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    furniture = bpy.data.collections.new("Furniture")
    scene = bpy.context.scene
    assert scene is not None
    scene.collection.children.link(furniture)
    for place, name in enumerate(("Table", "Vase", "Lamp")):
        bpy.ops.mesh.primitive_cube_add(location=(4 * place, 0, 0))
        made = bpy.context.object
        assert made is not None
        made.name = name
        scene.collection.objects.unlink(made)
        furniture.objects.link(made)
    scene.world = bpy.data.worlds.new("White")
    scene.world.color = 1, 1, 1
    made_in = tmp_path_factory.mktemp("pipeline")
    bpy.ops.wm.save_as_mainfile(filepath=str(made_in / "room.blend"), copy=True)
    return made_in


def test_the_commands_run_in_their_order(folder: Path) -> None:
    script = SHELL + "\n".join(blocks("sh"))
    ended = subprocess.run(
        ["bash"], input=script, cwd=folder, capture_output=True, text=True, timeout=280, check=False
    )
    assert ended.returncode == 0, ended.stderr[-3000:]
    print(ended.stdout, ended.stderr)
    assert "the exit code is 2" in ended.stdout
    assert "Vase: unchanged" in ended.stderr
    left = {path.relative_to(folder).as_posix() for path in folder.rglob("*")}
    assert {f"baked/{name}.radiance.json" for name in ("Table", "Vase", "Lamp")} <= left
    assert {"baked/Vase.report.html", "baked/Room.web/index.html", "baked/Vase.godot/project.godot"} <= left
    assert {"farmed/Table.radiance.irradiance.exr", "farmed/Table.preview.blend"} <= left


def test_the_python_runs(folder: Path) -> None:
    in_blender, functions = blocks("python")
    for block, before in ((in_blender, REGISTERED), (functions, "")):
        small = block.replace("texels=128, samples=16", "texels=32, bucket=2, samples=1")
        small = small.replace('layout="layered"', 'layout="buckets"')
        small = small.replace("wait=True", 'wait=True, atlas_layout="buckets"')
        script = f"import sys; sys.path.insert(0, {str(ROOT)!r})\n{before}{small}"
        ended = subprocess.run(
            [sys.executable, "-c", script],
            cwd=folder,
            env=os.environ | {"PWD": str(folder)},  # by which Blender 4.5 finds relative paths
            capture_output=True,
            text=True,
            timeout=120,
            check=False,
        )
        assert ended.returncode == 0, ended.stderr[-3000:]
    assert (folder / "python/Vase.godot/project.godot").is_file()
    assert (folder / "functions/Lamp.godot/project.godot").is_file()
