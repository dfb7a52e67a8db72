# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""bake.py of the installed zip: it imports the extension, and adds no folder of it to Python's path."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path

import pytest

INSTALL = """
import sys
import bpy
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.mesh.primitive_plane_add()
bpy.ops.wm.save_as_mainfile(filepath=sys.argv[2])
bpy.ops.preferences.addon_enable(module="bl_pkg")
bpy.ops.extensions.package_install_files(filepath=sys.argv[1], repo="user_default", enable_on_install=True)
"""
RUN = """
import json, runpy, sys
sys.argv.pop(0)
try:
    runpy.run_path(sys.argv[0], run_name="__main__")
finally:
    ours = [name for name in sys.modules if name.endswith("radtex_addon")]
    print(json.dumps({"ours": ours, "path": sys.path}), file=sys.stderr)
"""
QUICK = ("--layout", "buckets", "--texels", "2", "--bucket", "2", "--samples", "1", "--progress", "none")


@pytest.fixture(scope="module")
def home(bare_python: Path, own_zip: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A user's folder of Blender's in which the extension is installed, and a scene in it."""
    folder = tmp_path_factory.mktemp("home")
    told(bare_python, folder, INSTALL, str(own_zip), str(folder / "scene.blend"))
    return folder


def told(python: Path, home: Path, code: str, *arguments: str) -> str:
    """Run code in the bare Blender; what it wrote to standard error."""
    environment = os.environ | {"BLENDER_USER_RESOURCES": str(home)}
    process = subprocess.run(
        [str(python), "-I", "-c", code, *arguments],
        env=environment,
        cwd=home,
        capture_output=True,
        text=True,
        check=False,
    )
    assert process.returncode == 0, process.stdout + process.stderr
    return process.stderr


@pytest.mark.parametrize("repository", ["user_default", "a studio's"])
def test_the_installed_batch_imports_the_extension(
    bare_python: Path, home: Path, tmp_path: Path, repository: str
) -> None:
    """The second is a repository that Blender's factory settings, which workers have, do not know."""
    folder = home / "extensions" / "user_default"
    if repository != "user_default":
        folder = shutil.copytree(folder, tmp_path / repository)
    extension = folder / "radtex"
    wanted = ("--object", "Plane", "--out", str(tmp_path / "baked"), *QUICK)
    said = told(bare_python, home, RUN, str(extension / "bake.py"), str(home / "scene.blend"), *wanted)
    found = json.loads(said.splitlines()[-1])
    module = "user_default" if repository == "user_default" else "radtex"
    assert found["ours"] == [f"bl_ext.{module}.radtex.radtex_addon"]
    assert not [entry for entry in found["path"] if Path(entry).is_relative_to(extension)]
    assert sorted(path.name for path in (tmp_path / "baked").iterdir()) == [
        "Plane.radiance.exr",
        "Plane.radiance.json",
    ]
    assert list((home / "extensions" / ".local").rglob("OpenEXR*")), "the wheels stay installed"
