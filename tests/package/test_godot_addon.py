# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The zip of the addon for Godot: what its asset library wants, and all that its files name."""

from __future__ import annotations

import configparser
import io
import re
import subprocess
import sys
import zipfile
from pathlib import Path, PurePosixPath

import pytest
from PIL import Image

pytestmark = pytest.mark.one_blender

ROOT = Path(__file__).resolve().parents[2]
ADDON = "addons/radtex/"
UNIFORMS = {
    f"radtex_{name}"
    for name in ("mirror", "material", "lobes", "images", "base_map", "bump_map", "metal_map")
}
SHIPPED = {".gd", ".gdshader", ".gdshaderinc", ".tres", ".svg", ".cfg", ".md", ""}
WANTED = {f"{ADDON}{name}" for name in ("plugin.cfg", "plugin.gd", "icon.svg", "README.md", "LICENSE")}


def build(*arguments: str) -> None:
    subprocess.run(
        [sys.executable, ".ci/build_godot.py", *arguments], cwd=ROOT, check=True, capture_output=True
    )


def test_the_addons_zip_is_whole(tmp_path: Path) -> None:
    build("--out", str(tmp_path))
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


def test_the_zip_keeps_the_asset_librarys_rules(tmp_path: Path) -> None:
    """As docs/release.md lists them: what can be seen in the zip."""
    build("--out", str(tmp_path))
    (path,) = tmp_path.iterdir()
    with zipfile.ZipFile(path) as archive:
        names = archive.namelist()
        texts = {name: archive.read(name).decode("utf-8") for name in names}
    # Godot's installer takes a folder for the archive's root, and leaves it out, where its entry comes first.
    assert not [name for name in names if name.endswith("/")]
    assert {PurePosixPath(name).parts[:2] for name in names} == {("addons", "radtex")}
    assert {PurePosixPath(name).suffix for name in names} <= SHIPPED
    assert not [name for name in names if PurePosixPath(name).name.startswith(".")]
    assert re.search(r"^Copyright \(c\) \d{4} \w", texts[f"{ADDON}LICENSE"], re.MULTILINE)
    assert texts[f"{ADDON}LICENSE"].startswith("MIT License\n")
    facts = configparser.ConfigParser()
    facts.read_string(texts[f"{ADDON}plugin.cfg"])
    assert set(facts["plugin"]) == {"name", "description", "author", "version", "script"}
    assert all(value.strip('"') for value in facts["plugin"].values())
    assert re.fullmatch(r'"[A-Z].*\."', facts["plugin"]["description"])
    assert f"{ADDON}{facts['plugin']['script'].strip(chr(34))}" in names
    for name in names:
        if name.endswith(".tres"):
            assert set(re.findall(r'"res://([^"]+)"', texts[name])) <= set(names)


def test_the_repository_keeps_the_asset_librarys_rules(tmp_path: Path) -> None:
    """And what git makes an archive of, as code hosts do, is the addon alone, as in the zip."""
    build("--out", str(tmp_path / "zip"), "--repository", str(tmp_path / "repository"))
    folder = tmp_path / "repository"
    assert {path.name for path in folder.iterdir()} == {
        *("addons", "LICENSE", "README.md", "icon.png", ".gitignore", ".gitattributes")
    }
    with Image.open(folder / "icon.png") as icon:
        assert icon.format == "PNG"
        assert icon.width == icon.height >= 128
    git = ["git", "-c", "user.name=RadTex", "-c", "user.email=nobody@localhost"]
    for arguments in (["init", "-q"], ["add", "."], ["commit", "-q", "-m", "Release"]):
        subprocess.run([*git, *arguments], cwd=folder, check=True, capture_output=True)
    archived = subprocess.run(
        ["git", "archive", "--format=zip", "HEAD"], cwd=folder, check=True, capture_output=True
    )
    (path,) = (tmp_path / "zip").iterdir()
    with zipfile.ZipFile(io.BytesIO(archived.stdout)) as theirs, zipfile.ZipFile(path) as ours:
        files = {name for name in theirs.namelist() if not name.endswith("/")}
        assert files == set(ours.namelist())
        assert all(theirs.read(name) == ours.read(name) for name in files)


def test_nothing_in_a_function_is_called_as_a_uniform_is() -> None:
    """Forward+ and Mobile take one for the other: a function would read the uniform. Lookups have parameters
    that are called as those uniforms which they are given."""
    folder = ROOT / "shaders" / "godot" / ADDON / "surfaces"
    texts = {path.name: path.read_text(encoding="utf-8") for path in folder.glob("*.gdshaderinc")}

    def whole(name: str) -> str:
        included = re.findall(r'^#include "([\w.]+)"', texts[name], re.MULTILINE)
        return texts[name] + "".join(map(whole, included))

    lookups = "\n".join(
        re.sub("//.*", "", path.read_text(encoding="utf-8"))
        for path in (ROOT / "shaders").glob("*.gdshaderinc")
    )
    words = set(re.findall(r"\w+", lookups))
    checked = 0
    for name in texts:
        text = whole(name)
        uniforms = set(re.findall(r"^(?:instance )?uniform \w+ (\w+)", text, re.MULTILINE))
        if '#include "display.gdshaderinc"' in text or name == "display.gdshaderinc":
            own = set(re.findall(r"^(?:instance )?uniform \w+ (\w+)", whole("sun.gdshaderinc"), re.MULTILINE))
            assert len(own) == 9
            assert not own & words, name
        for function, given in re.findall(r"^\w+ (\w+)\(([^()]+)\) \{", text, re.MULTILINE):
            parameters = {each.split()[-1] for each in given.split(",")}
            checked += len(parameters)
            assert not parameters & uniforms, f"{name}: {function}"
    assert checked > 50
