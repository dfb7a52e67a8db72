# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""blender_manifest.toml agrees with uv.lock, with pyproject.toml and with the platforms it promises.

Blender's own validator checks none of this.
"""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

import pytest

pytestmark = pytest.mark.one_blender


ROOT = Path(__file__).resolve().parents[2]

PYTHONS = ("cp311", "cp313")  # Blender 4.5 and 5.2
BUNDLED = ("flip-evaluator", "openexr", "uvunwrap", "xatlas")
ONE_FOR_ALL = {"uvunwrap": ("cp311-abi3",)}  # one wheel for every Python from 3.11 on
NOT_MADE = {("flip-evaluator", "macos-x64")}
WHEEL_PLATFORMS = {
    "linux-x64": r"manylinux\w+_x86_64(\.manylinux\w+)?",
    "macos-arm64": r"macosx_\w+_arm64",
    "macos-x64": r"macosx_\w+_x86_64",
    "windows-x64": r"win_amd64",
}


def read(name: str) -> dict[str, Any]:
    return tomllib.loads((ROOT / name).read_text(encoding="utf-8"))


def locked(name: str) -> dict[str, Any]:
    package: dict[str, Any] = next(entry for entry in read("uv.lock")["package"] if entry["name"] == name)
    return package


def test_the_manifest_names_exactly_the_locked_wheels_of_every_platform_and_python() -> None:
    expected: list[str] = []
    for package in BUNDLED:
        files = [wheel["url"].rpartition("/")[2] for wheel in locked(package)["wheels"]]
        for python in ONE_FOR_ALL.get(package, [f"{each}-{each}" for each in PYTHONS]):
            for platform in read("blender_manifest.toml")["platforms"]:
                tags = rf".+-{python}-{WHEEL_PLATFORMS[platform]}\.whl"
                matches = [name for name in files if re.fullmatch(tags, name)]
                assert len(matches) == ((package, platform) not in NOT_MADE)
                expected.extend(f"./wheels/{match}" for match in matches)
    assert sorted(read("blender_manifest.toml")["wheels"]) == sorted(expected)


def test_the_bundled_wheels_need_nothing_that_blender_lacks() -> None:
    needed = {entry["name"] for name in BUNDLED for entry in locked(name).get("dependencies", ())}
    assert needed <= {"numpy"}


def test_the_lock_file_names_the_public_index_only() -> None:
    urls = re.findall(r"\"(\w+://[^/\"]*)", (ROOT / "uv.lock").read_text(encoding="utf-8"))
    assert set(urls) == {"https://pypi.org", "https://files.pythonhosted.org"}
