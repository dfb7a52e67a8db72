# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The zip installs, works and goes without a trace in a Blender that has nothing else."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path
from typing import Any

import pytest


@pytest.fixture(scope="module")
def report(bare_python: Path, own_zip: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """What a Blender that has just installed, disabled, enabled and removed the extension says about it."""
    home = tmp_path_factory.mktemp("home")
    answer = home / "report.json"
    process = subprocess.run(
        [str(bare_python), "-I", str(Path(__file__).with_name("install.py")), str(own_zip), str(answer)],
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


def test_nothing_is_written_into_the_extensions_folder(report: dict[str, Any]) -> None:
    assert report["enabled"]["files"]
    assert report["baked"]["files"] == report["enabled"]["files"]
    assert report["enabled_again"]["files"] == report["enabled"]["files"]


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
