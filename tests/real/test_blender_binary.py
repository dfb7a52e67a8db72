# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The batch in a Blender program with the extension installed: what it writes, says and exits with.

RADTEX_BLENDER is that Blender, or a command that starts one; without it these tests are skipped. A Blender
whose Python is not one that the zip has wheels for (a Linux distribution's, say) needs RADTEX_WHEELS too: a
folder with wheels of OpenEXR and xatlas for it.
"""

from __future__ import annotations

import json
import os
import re
import shlex
import signal
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import pytest

from tests.real.installable import build_zip, with_wheels

ROOT = Path(__file__).resolve().parents[2]
BLENDER = shlex.split(os.environ.get("RADTEX_BLENDER", ""))
WHEELS = os.environ.get("RADTEX_WHEELS")
pytestmark = pytest.mark.skipif(not BLENDER, reason="RADTEX_BLENDER names no Blender program")

SMALL = ("--layout", "buckets", "--texels", "64", "--bucket", "4", "--samples", "2")
MAKE_SCENE = """
import bpy
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.object.light_add(type="AREA", location=(2, -2, 3))
bpy.context.object.data.energy = 200
bpy.ops.mesh.primitive_monkey_add()
bpy.ops.wm.save_as_mainfile(filepath={path!r})
"""
INSTALL = """
import bpy
bpy.ops.extensions.package_install_files(filepath={path!r}, repo="user_default", enable_on_install=True)
bpy.ops.wm.save_userpref()
"""
PYTHON_TAG = "import sys; print('TAG cp%d%d' % sys.version_info[:2])"
MODULES = "import OpenEXR, xatlas; print('FROM', OpenEXR.__file__); print('FROM', xatlas.__file__)"


@dataclass(frozen=True)
class Blender:
    """A Blender with a home of its own."""

    home: Path

    def command(self, *arguments: str) -> list[str]:
        return [*BLENDER, "-b", *arguments]

    @property
    def environment(self) -> dict[str, str]:
        return os.environ | {"BLENDER_USER_RESOURCES": str(self.home)}

    def run(self, *arguments: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            self.command(*arguments),
            env=self.environment,
            cwd=self.home,
            capture_output=True,
            text=True,
            timeout=600,
            check=False,
        )

    def tell(self, code: str, mark: str, *files: str) -> list[str]:
        """Run Python inside; what it printed on lines that begin with `mark`."""
        process = self.run(*files, "--python-exit-code", "1", "--python-expr", code)
        assert process.returncode == 0, process.stdout + process.stderr
        lines = process.stdout.splitlines()
        return [line.removeprefix(mark).strip() for line in lines if line.startswith(mark)]


@dataclass(frozen=True)
class Installed(Blender):
    """One with the extension installed."""

    scene: Path

    def bake(self, *arguments: str) -> subprocess.CompletedProcess[str]:
        """Run the installed bake.py on the scene."""
        return self.run(str(self.scene), "-P", str(self.script), "--", *arguments)

    @property
    def script(self) -> Path:
        return self.home / "extensions" / "user_default" / "radtex" / "bake.py"


@pytest.fixture(scope="module")
def bare(tmp_path_factory: pytest.TempPathFactory) -> Blender:
    return Blender(tmp_path_factory.mktemp("bare"))


@pytest.fixture(scope="module")
def scene(bare: Blender) -> Path:
    path = bare.home / "scene.blend"
    bare.tell(MAKE_SCENE.format(path=str(path)), "")
    return path


@pytest.fixture(scope="module")
def installed(bare: Blender, scene: Path, tmp_path_factory: pytest.TempPathFactory) -> Installed:
    blender = Installed(tmp_path_factory.mktemp("installed"), scene)
    (tag,) = bare.tell(PYTHON_TAG, "TAG")
    archive = suited_zip(tag, tmp_path_factory.mktemp("dist"))
    blender.tell(INSTALL.format(path=str(archive)), "")
    return blender


def suited_zip(tag: str, folder: Path) -> Path:
    """The extension for this system, with the wheels of RADTEX_WHEELS if it has none for Python `tag`."""
    archive = build_zip()
    with ZipFile(archive) as source:
        if any(f"-{tag}-" in name for name in source.namelist()):
            return archive
    if WHEELS is None:
        pytest.skip(f"the zip has no wheels for {tag}, and RADTEX_WHEELS names none")
    return with_wheels(archive, sorted(Path(WHEELS).glob(f"*-{tag}-*.whl")), folder)


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir()) if folder.is_dir() else []


def events(stdout: str) -> list[dict[str, Any]]:
    """RadTex's lines among Blender's: those that begin with a brace."""
    return [json.loads(line) for line in stdout.splitlines() if line.startswith("{")]


def test_without_the_wheels_one_line_says_how_to_get_them(bare: Blender, scene: Path) -> None:
    has_wheels = "import importlib.util as u; print('HAS', u.find_spec('OpenEXR') is not None)"
    if bare.tell(has_wheels, "HAS") == ["True"]:
        pytest.skip("this Blender's Python has OpenEXR of its own")
    process = bare.run(str(scene), "-P", str(ROOT / "bake.py"), "--", "--object", "Suzanne")
    assert process.returncode == 2
    (line,) = process.stderr.splitlines()
    assert line.startswith(
        "radtex: the Python module 'OpenEXR' is missing: in Blender, install the RadTex extension"
    )


def test_the_extensions_own_wheels_are_used(installed: Installed) -> None:
    modules = installed.tell(MODULES, "FROM")
    assert len(modules) == 2
    assert all(Path(module).is_relative_to(installed.home) for module in modules)


@pytest.mark.parametrize("script", ["installed", "repository"])
def test_a_bake_writes_its_files_and_a_line_a_stage(
    installed: Installed, script: str, tmp_path: Path
) -> None:
    path = installed.script if script == "installed" else ROOT / "bake.py"
    process = installed.run(
        *(str(installed.scene), "-P", str(path), "--", "--object", "Suzanne", "--save-preview"),
        *("--out", str(tmp_path), *SMALL),
    )
    assert process.returncode == 0, process.stderr
    expected = ["Suzanne.preview.blend", "Suzanne.radiance.exr", "Suzanne.radiance.json"]
    assert names(tmp_path) == expected
    stages = process.stderr.splitlines()
    assert (stages[0], stages[-1]) == ("Suzanne: reading the mesh", "Suzanne: saving the preview")
    assert all(re.fullmatch(r"Suzanne: [a-z ]+", line) for line in stages)
    assert len(set(stages)) == len(stages)
    said = process.stdout.splitlines()
    (first,) = [number for number, line in enumerate(said) if line.startswith("Suzanne: ")]
    assert sorted(Path(line.strip()) for line in said[first + 1 : first + 4]) == [
        tmp_path / name for name in expected
    ]


def test_it_needs_no_preferences(installed: Installed, tmp_path: Path) -> None:
    process = installed.run(
        *("--factory-startup", str(installed.scene), "-P", str(installed.script), "--"),
        *("--object", "Suzanne", "--out", str(tmp_path), *SMALL),
    )
    assert process.returncode == 0, process.stderr
    assert names(tmp_path) == ["Suzanne.radiance.exr", "Suzanne.radiance.json"]


def test_json_lines_can_be_told_from_blenders_own(installed: Installed, tmp_path: Path) -> None:
    process = installed.bake("--object", "Suzanne", "--out", str(tmp_path), "--progress", "json", *SMALL)
    assert (process.returncode, process.stderr) == (0, "")
    found = events(process.stdout)
    assert [event["event"] for event in found] == ["progress"] * (len(found) - 1) + ["done"]
    assert found[-1]["files"] == [str(tmp_path / f"Suzanne.radiance.{ending}") for ending in ("exr", "json")]
    assert process.stdout.count('"event"') == len(found)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--object", "Nobody"], "radtex: no object 'Nobody'"),
        (["--object", "Suzanne", "--colour"], "radtex: unrecognized arguments: --colour"),
    ],
)
def test_bad_requests_are_one_line_and_exit_code_2(
    installed: Installed, arguments: list[str], message: str, tmp_path: Path
) -> None:
    process = installed.bake(*arguments, "--out", str(tmp_path))
    assert process.returncode == 2
    (line,) = process.stderr.splitlines()
    assert line.startswith(message)
    assert names(tmp_path) == []


def test_a_file_that_blender_cannot_open_is_blenders_to_refuse(installed: Installed, tmp_path: Path) -> None:
    bad = tmp_path / "bad.blend"
    bad.write_text("no .blend")
    process = installed.run(str(bad), "-P", str(installed.script), "--", "--object", "Cube")
    assert process.returncode == 1
    assert names(tmp_path) == ["bad.blend"]


@pytest.mark.skipif(sys.platform == "win32", reason="signals are a Unix matter")
@pytest.mark.parametrize("asked", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_bake_leaves_nothing(
    installed: Installed, asked: signal.Signals, tmp_path: Path
) -> None:
    long = ("--layout", "buckets", "--texels", "256", "--bucket", "8", "--samples", "8")
    command = installed.command(
        *(str(installed.scene), "-P", str(installed.script), "--", "--object", "Suzanne"),
        *("--out", str(tmp_path), *long),
    )
    with subprocess.Popen(
        command, env=installed.environment, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stderr is not None
        for line in process.stderr:
            if line.endswith(": rendering the light\n"):
                break
        process.send_signal(asked)
        rest = process.stderr.read().splitlines()
    assert process.returncode == 130
    assert len(rest) == 1
    assert rest[0].startswith("radtex: interrupted")
    assert names(tmp_path) == []
