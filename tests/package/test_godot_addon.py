# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The zip of the addon for Godot: what its asset library wants, and all that its files name."""

from __future__ import annotations

import re
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

pytestmark = pytest.mark.one_blender

ROOT = Path(__file__).resolve().parents[2]
ADDON = "addons/radtex/"
UNIFORMS = {
    f"radtex_{name}"
    for name in ("mirror", "material", "lobes", "images", "base_map", "bump_map", "metal_map")
}
WANTED = {f"{ADDON}{name}" for name in ("plugin.cfg", "plugin.gd", "icon.svg", "README.md", "LICENSE")}


def test_the_addons_zip_is_whole(tmp_path: Path) -> None:
    command = [sys.executable, ".ci/build_godot.py", "--out", str(tmp_path)]
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True)
    (path,) = tmp_path.iterdir()
    with zipfile.ZipFile(path) as archive:
        names = set(archive.namelist())
        texts = {name: archive.read(name).decode("utf-8") for name in names}
    assert names >= WANTED
    assert all(name.startswith(ADDON) for name in names)
    assert texts[f"{ADDON}LICENSE"] == (ROOT / "shaders" / "LICENSE").read_text(encoding="utf-8")
    assert f'version="{path.stem.rpartition("-")[2]}"' in texts[f"{ADDON}plugin.cfg"]
    for name, text in texts.items():
        folder = name.rpartition("/")[0]
        for file in re.findall(r'(?:preload\(|^#include )"([\w.]+)"', text, re.MULTILINE):
            assert f"{folder}/{file}" in names, f"{name} names {file}"
    asked = re.findall(r'"(radtex(?:_\w+)?)"', texts[f"{ADDON}materials.gd"])
    lookups = {f"{ADDON}lookups/{name}.gdshaderinc" for name in asked if name not in UNIFORMS}
    assert lookups <= names
    surfaces = re.findall(r'Recipe\.new\("(\w+)"', texts[f"{ADDON}materials.gd"])
    assert {f"{ADDON}surfaces/{name}.gdshaderinc" for name in surfaces} <= names
