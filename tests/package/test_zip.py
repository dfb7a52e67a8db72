# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Each platform's zip holds what ships and nothing else."""

from __future__ import annotations

import subprocess
import tomllib
from pathlib import Path, PurePosixPath
from zipfile import ZipFile

import pytest

pytestmark = pytest.mark.one_blender  # the zips are the same for both

ROOT = Path(__file__).resolve().parents[2]
PLATFORMS = tomllib.loads((ROOT / "blender_manifest.toml").read_text(encoding="utf-8"))["platforms"]

TOP_LEVEL = {"__init__.py", "bake.py", "blender_manifest.toml", "CHANGELOG.md", "LICENSE", "NOTICE.md"}
FOLDERS = {"radtex_addon", "shaders", "wheels"}
WEB = PurePosixPath("radtex_addon/export/web/built")  # made of shaders/three
BUILT = {
    WEB / name
    for name in ("index.html", "viewer.css", "boot.js", "viewer.js", "viewer.js.gz", "LICENSES.txt")
}


def names(zips: dict[str, Path], platform: str) -> set[PurePosixPath]:
    with ZipFile(zips[platform]) as archive:
        return {PurePosixPath(name) for name in archive.namelist()}


def test_there_is_a_zip_for_every_platform(zips: dict[str, Path]) -> None:
    assert set(zips) == set(PLATFORMS)


@pytest.mark.parametrize("platform", PLATFORMS)
def test_the_zip_holds_every_file_of_the_package_and_of_the_shaders_and_nothing_else(
    zips: dict[str, Path], platform: str
) -> None:
    command = ["git", "ls-files", "--cached", "--others", "--exclude-standard", "radtex_addon", "shaders"]
    listed = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout.splitlines()
    ours = BUILT | {PurePosixPath(name) for name in listed if (ROOT / name).exists()}
    shipped = names(zips, platform)
    assert {name for name in shipped if name.parts[0] in {"radtex_addon", "shaders"}} == ours
    assert {name.name for name in shipped if len(name.parts) == 1} == TOP_LEVEL
    assert {name.parts[0] for name in shipped if len(name.parts) > 1} == FOLDERS


@pytest.mark.parametrize("platform", PLATFORMS)
def test_the_zip_carries_its_wheels_for_both_pythons_and_no_other_platforms(
    zips: dict[str, Path], platform: str
) -> None:
    wheels = [name.name for name in names(zips, platform) if name.parts[0] == "wheels"]
    flip = [] if platform == "macos-x64" else ["flip_evaluator"]  # nobody makes one
    assert sorted(tuple(wheel.split("-"))[::2][:2] for wheel in wheels) == [
        *((package, python) for package in [*flip, "openexr"] for python in ("cp311", "cp313")),
        ("uvunwrap", "cp311"),  # its stable interface is for later ones, too
        *(("xatlas", python) for python in ("cp311", "cp313")),
    ]
    system, machine = platform.split("-")
    mark = {"linux": "manylinux", "macos": "macosx", "windows": "win"}[system]
    ends = {"x64": ("x86_64", "amd64"), "arm64": ("arm64",)}[machine]
    for wheel in wheels:
        tag = wheel.removesuffix(".whl").split("-")[-1]
        assert tag.startswith(mark)
        assert tag.endswith(ends)
