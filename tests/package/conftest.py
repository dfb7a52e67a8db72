# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The zips, and a bare Blender."""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.real.installable import built_zips

ROOT = Path(__file__).resolve().parents[2]
BLENDER_OF = {(3, 11): "45", (3, 13): "52"}
SYSTEMS = {"Linux": "linux", "Darwin": "macos", "Windows": "windows"}
MACHINES = {"x86_64": "x64", "AMD64": "x64", "arm64": "arm64"}


@pytest.fixture(scope="session")
def zips() -> dict[str, Path]:
    """One zip for each platform, as in {"linux-x64": …/radtex-0.1.0-linux_x64.zip}."""
    return {path.stem.rpartition("-")[2].replace("_", "-"): path for path in built_zips().glob("*.zip")}


@pytest.fixture(scope="session")
def own_zip(zips: dict[str, Path]) -> Path:
    """The zip for this machine."""
    return zips[f"{SYSTEMS[platform.system()]}-{MACHINES[platform.machine()]}"]


@pytest.fixture(scope="session")
def bare_python(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An environment with the bpy of this run and what bpy itself needs: no wheel of ours, no pytest."""
    uv = os.environ.get("UV") or shutil.which("uv")
    assert uv is not None, "uv makes the bare environment: pip install uv"
    venv = tmp_path_factory.mktemp("bare") / "venv"
    group = f"--only-group=blender-{BLENDER_OF[sys.version_info[:2]]}"
    command = [uv, "sync", "--quiet", "--frozen", group, "--python", platform.python_version()]
    environment = {name: value for name, value in os.environ.items() if name != "VIRTUAL_ENV"}
    environment["UV_PROJECT_ENVIRONMENT"] = str(venv)
    subprocess.run(command, cwd=ROOT, env=environment, check=True)
    return venv / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
