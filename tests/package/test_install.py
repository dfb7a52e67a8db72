# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The zip installs, works, is updated and goes without a trace in a Blender that has nothing else."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path
from typing import Any
from zipfile import ZIP_DEFLATED, ZipFile

import pytest

from radtex_addon.version import VERSION

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
LATER = "99.0.0"
CHANGES = f"""\
## [Unreleased]

## [{LATER}] - 2099-01-01

### Changed

- **Water** is wet ([docs/water.md](docs/water.md)).
"""
INSTALL_BOTH = """
import importlib, json, sys
import bpy
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.preferences.addon_enable(module="bl_pkg")
told = []
for archive in sys.argv[1:]:
    bpy.ops.extensions.package_install_files(filepath=archive, repo="user_default", enable_on_install=True)
    ours = "bl_ext.user_default.radtex.radtex_addon."
    seen = importlib.import_module(ours + "ui.settings.seen_version")
    changes = importlib.import_module(ours + "ui.operators.changes_operator")
    told.append({"seen": seen.seen_version(), "news": seen.news(), "changes": changes.shown_changes()})
print(json.dumps(told), file=sys.stderr)
"""


def told(python: Path, home: Path, *arguments: str) -> str:
    """Run the bare Blender's Python with a user's folder of its own; what it wrote to standard error."""
    process = subprocess.run(
        [str(python), "-I", *arguments],
        env=os.environ | {"BLENDER_USER_RESOURCES": str(home)},
        cwd=home,
        capture_output=True,
        text=True,
        check=False,
    )
    assert process.returncode == 0, process.stdout + process.stderr
    return process.stderr


@pytest.fixture(scope="module")
def report(bare_python: Path, own_zip: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """What a Blender that has just installed, disabled, enabled and removed the extension says about it."""
    home = tmp_path_factory.mktemp("home")
    answer = home / "report.json"
    told(bare_python, home, str(Path(__file__).with_name("install.py")), str(own_zip), str(answer))
    return {"home": home, **json.loads(answer.read_text())}


@pytest.mark.parametrize("step", ["enabled", "baked", "disabled", "enabled_again", "removed"])
def test_blender_takes_every_step_without_an_error(report: dict[str, Any], step: str) -> None:
    assert report[step]["error"] is None


def test_installing_enables_the_extension_and_loads_no_wheel_but_has_those_of_the_zip(
    report: dict[str, Any],
) -> None:
    before, enabled = report["before"], report["enabled"]
    assert set(before["wheels"].values()) == {None}
    assert not before["operator"]
    assert enabled["addons"] == ["bl_ext.user_default.radtex"]
    assert enabled["operator"]
    assert enabled["loaded_wheels"] == []
    for path in enabled["wheels"].values():
        assert Path(path).is_relative_to(report["home"])


def test_the_installed_operator_bakes_with_the_wheels_of_the_zip(report: dict[str, Any]) -> None:
    baked = report["home"] / "baked"
    expected = ["Plane.preview.blend", "Plane.radiance.exr", "Plane.radiance.json"]
    assert sorted(path.name for path in baked.iterdir()) == expected
    assert "OpenEXR" in report["baked"]["loaded_wheels"]


def test_nothing_is_written_into_the_extensions_folder(report: dict[str, Any]) -> None:
    assert report["enabled"]["files"]
    assert report["baked"]["files"] == report["enabled"]["files"]
    assert report["enabled_again"]["files"] == report["enabled"]["files"]


@pytest.mark.parametrize(
    ("step", "same"), [("disabled", "before"), ("removed", "before"), ("enabled_again", "enabled")]
)
def test_disabling_leaves_nothing_registered_and_it_can_be_enabled_again(
    report: dict[str, Any], step: str, same: str
) -> None:
    for what in ("addons", "operator", "types", "properties", "handlers", "key_maps"):
        assert report[step][what] == report[same][what], what


def test_removing_it_leaves_no_module_and_no_file(report: dict[str, Any]) -> None:
    assert report["removed"]["modules"] == []
    assert [path for path in report["home"].rglob("*") if "radtex" in path.name or path.suffix == ".so"] == []


@pytest.fixture(scope="module")
def home(bare_python: Path, own_zip: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A user's folder of Blender's in which the extension is installed, and a scene in it."""
    folder = tmp_path_factory.mktemp("home")
    told(bare_python, folder, "-c", INSTALL, str(own_zip), str(folder / "scene.blend"))
    return folder


@pytest.mark.parametrize("repository", ["user_default", "a studio's"])
def test_the_installed_batch_imports_the_extension(
    bare_python: Path, home: Path, tmp_path: Path, repository: str
) -> None:
    """bake.py of the installed zip imports the extension, and adds no folder of it to Python's path.

    The second is a repository that Blender's factory settings, which workers have, do not know.
    """
    folder = home / "extensions" / "user_default"
    if repository != "user_default":
        folder = shutil.copytree(folder, tmp_path / repository)
    extension = folder / "radtex"
    wanted = ("--object", "Plane", "--out", str(tmp_path / "baked"), *QUICK)
    said = told(bare_python, home, "-c", RUN, str(extension / "bake.py"), str(home / "scene.blend"), *wanted)
    found = json.loads(said.splitlines()[-1])
    module = "user_default" if repository == "user_default" else "radtex"
    assert found["ours"] == [f"bl_ext.{module}.radtex.radtex_addon"]
    assert not [entry for entry in found["path"] if Path(entry).is_relative_to(extension)]
    assert sorted(path.name for path in (tmp_path / "baked").iterdir()) == [
        "Plane.radiance.exr",
        "Plane.radiance.json",
    ]
    assert list((home / "extensions" / ".local").rglob("OpenEXR*")), "the wheels stay installed"


@pytest.fixture
def later_zip(own_zip: Path, tmp_path: Path) -> Path:
    """This zip with another version, and with words on it."""
    path = tmp_path / "later.zip"
    with ZipFile(own_zip) as source:
        changelog = source.read("CHANGELOG.md").decode()
    before = changelog[changelog.index("## [Unreleased]") : changelog.index(f"## [{VERSION}]")]
    edits = {
        "blender_manifest.toml": (f'version = "{VERSION}"', f'version = "{LATER}"'),
        "radtex_addon/version.py": (f'"{VERSION}"', f'"{LATER}"'),
        "CHANGELOG.md": (before, CHANGES + "\n"),
    }
    with ZipFile(own_zip) as source, ZipFile(path, "w", ZIP_DEFLATED) as target:
        for info in source.infolist():
            content = source.read(info)
            if info.filename in edits:
                old, new = edits[info.filename]
                text = content.decode()
                assert text.count(old) == 1, info.filename
                content = text.replace(old, new).encode()
            target.writestr(info, content)
    return path


@pytest.mark.one_blender
def test_an_update_offers_its_changes_and_a_first_install_none(
    bare_python: Path, own_zip: Path, later_zip: Path, tmp_path: Path
) -> None:
    said = told(bare_python, tmp_path, "-c", INSTALL_BOTH, str(own_zip), str(later_zip))
    first, then = (dict[str, Any](told) for told in json.loads(said.splitlines()[-1]))
    assert (first["seen"], first["news"]) == (VERSION, False)
    assert (then["seen"], then["news"]) == (VERSION, True)
    assert then["changes"] == ["Water is wet."]
