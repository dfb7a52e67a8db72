# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The zip installs, works and goes without a trace in a Blender that has nothing else."""

from __future__ import annotations

import json
import os
import platform
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[2]
BLENDER_OF = {(3, 11): "45", (3, 13): "52"}
SYSTEMS = {"Linux": "linux", "Darwin": "macos", "Windows": "windows"}
MACHINES = {"x86_64": "x64", "AMD64": "x64", "arm64": "arm64"}


@pytest.fixture(scope="module")
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


@pytest.fixture(scope="module")
def report(
    bare_python: Path, zips: dict[str, Path], tmp_path_factory: pytest.TempPathFactory
) -> dict[str, Any]:
    """What a Blender that has just installed, disabled, enabled and removed the extension says about it."""
    home = tmp_path_factory.mktemp("home")
    archive = zips[f"{SYSTEMS[platform.system()]}-{MACHINES[platform.machine()]}"]
    answer = home / "report.json"
    process = subprocess.run(
        [str(bare_python), "-I", str(Path(__file__).with_name("install.py")), str(archive), str(answer)],
        env=os.environ | {"BLENDER_USER_RESOURCES": str(home)},
        cwd=home,
        capture_output=True,
        text=True,
        check=False,
    )
    assert process.returncode == 0, process.stdout + process.stderr
    return {"home": home, **json.loads(answer.read_text())}


@pytest.mark.parametrize("step", ["enabled", "baked", "disabled", "enabled_again", "removed"])
def test_blender_takes_every_step_without_an_error(report: dict[str, Any], step: str) -> None:
    assert report[step]["error"] is None


def test_before_the_install_the_environment_has_no_wheel_of_ours(report: dict[str, Any]) -> None:
    assert set(report["before"]["wheels"].values()) == {None}
    assert not report["before"]["operator"]


def test_installing_enables_the_extension_and_its_operator(report: dict[str, Any]) -> None:
    assert report["enabled"]["addons"] == ["bl_ext.user_default.radtex"]
    assert report["enabled"]["operator"]


def test_the_wheels_are_those_of_the_zip(report: dict[str, Any]) -> None:
    for path in report["enabled"]["wheels"].values():
        assert Path(path).is_relative_to(report["home"])


def test_enabling_loads_no_wheel(report: dict[str, Any]) -> None:
    assert report["enabled"]["loaded_wheels"] == []


def test_the_installed_operator_bakes_with_the_wheels_of_the_zip(report: dict[str, Any]) -> None:
    baked = report["home"] / "baked"
    expected = ["Plane.preview.blend", "Plane.radiance.exr", "Plane.radiance.json"]
    assert sorted(path.name for path in baked.iterdir()) == expected
    assert "OpenEXR" in report["baked"]["loaded_wheels"]


@pytest.mark.parametrize("step", ["disabled", "removed"])
def test_disabling_leaves_nothing_registered(report: dict[str, Any], step: str) -> None:
    for what in ("addons", "operator", "types", "properties", "handlers", "key_maps"):
        assert report[step][what] == report["before"][what], what


def test_it_can_be_enabled_again(report: dict[str, Any]) -> None:
    for what in ("addons", "operator", "types", "properties", "handlers", "key_maps"):
        assert report["enabled_again"][what] == report["enabled"][what], what


def test_removing_it_leaves_no_module_and_no_file(report: dict[str, Any]) -> None:
    assert report["removed"]["modules"] == []
    assert [path for path in report["home"].rglob("*") if "radtex" in path.name or path.suffix == ".so"] == []
