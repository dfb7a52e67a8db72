# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rules of extensions.blender.org that code and manifest must keep; docs/release.md lists all of them."""

from __future__ import annotations

import ast
import os
import re
import shutil
import subprocess
import sys
import tomllib
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from zipfile import ZipFile

import pytest

pytestmark = pytest.mark.one_blender

ROOT = Path(__file__).resolve().parents[2]
MANIFEST = tomllib.loads((ROOT / "blender_manifest.toml").read_text(encoding="utf-8"))
# Who changes where Python looks for modules, and why that is not the extension's own folder.
CHANGES_PATH = {
    "bake.py",  # in a clone alone: test_install.py
    "radtex_addon/preview/osl.py",  # Blender's own packages, while a shader is compiled
    "radtex_addon/scene/uv/xatlas_worker.py",  # a process of its own, which gets its parent's path
    "radtex_addon/worker/order.py",  # the same, for a Blender that is started with factory settings
}
# What could reach other machines, and what it is for.
ON_THE_NETWORK = {
    # listens on 127.0.0.1, and closes connections there
    "radtex_addon/export/page_server.py": {"http", "http.server", "socket", "socketserver"},
    "radtex_addon/formats/disk/lock.py": {"socket"},  # asks this machine's name
    "radtex_addon/ui/jobs/browser.py": {"webbrowser"},  # opens that server's page
}
CLIENTS = re.compile(
    r"(asyncio|ftplib|http|httpx|imaplib|poplib|requests|smtplib|socket|socketserver|ssl|urllib3?"
    r"|webbrowser|xmlrpc)(\.|$)"
)


@dataclass(frozen=True)
class Shipped:
    """A Python file of the zip."""

    name: str
    text: str
    nodes: list[ast.AST]

    @property
    def imported(self) -> set[str]:
        names = {alias.name for node in self.nodes if isinstance(node, ast.Import) for alias in node.names}
        absolute = (node for node in self.nodes if isinstance(node, ast.ImportFrom) and not node.level)
        return names | {node.module for node in absolute if node.module}


@pytest.fixture(scope="module")
def shipped() -> list[Shipped]:
    paths = (ROOT / "bake.py", ROOT / "__init__.py", *(ROOT / "radtex_addon").rglob("*.py"))
    texts = {path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8") for path in paths}
    return [Shipped(name, text, list(ast.walk(ast.parse(text)))) for name, text in texts.items()]


def test_only_these_change_pythons_path(shipped: list[Shipped]) -> None:
    change = re.compile(r"sys\.path(\.(append|insert|extend|remove)\(|\[:\] =| \+=| =)")
    assert {file.name for file in shipped if change.search(file.text)} == CHANGES_PATH


def test_nothing_reaches_the_internet(shipped: list[Shipped]) -> None:
    """So the network permission is for a server on this machine, and bpy.app.online_access is not asked."""
    used = {
        file.name: {module for module in file.imported if CLIENTS.match(module)} - {"urllib.parse"}
        for file in shipped
    }
    assert {name: modules for name, modules in used.items() if modules} == ON_THE_NETWORK
    server = (ROOT / "radtex_addon/export/page_server.py").read_text(encoding="utf-8")
    assert re.findall(r'^HERE = "(.*)"', server, re.MULTILINE) == ["127.0.0.1"]
    assert set(MANIFEST["permissions"]) == {"clipboard", "files", "network"}


def test_no_code_is_made_from_text_or_installed_at_run_time(shipped: list[Shipped]) -> None:
    for file in shipped:
        calls = [node.func for node in file.nodes if isinstance(node, ast.Call)]
        called = {call.id for call in calls if isinstance(call, ast.Name)}
        assert not called & {"exec", "eval", "compile"}, file.name
        assert not file.imported & {"pip", "ensurepip"}, file.name


def test_the_listing_promises_what_the_rules_allow() -> None:
    assert len(MANIFEST["tagline"]) <= 64
    assert MANIFEST["tagline"][-1].isalnum()
    assert "blender" not in MANIFEST["name"].lower()
    assert "website" not in MANIFEST  # the project has no public address yet


@pytest.mark.parametrize("platform", MANIFEST["platforms"])
def test_blenders_own_tool_finds_each_zip_valid(zips: dict[str, Path], platform: str) -> None:
    """What `blender --command extension validate` runs."""
    spec = find_spec("bpy")
    assert spec is not None
    assert spec.origin is not None
    (scripts,) = Path(spec.origin).parent.glob("[0-9]*/scripts")
    tags = scripts / "modules/_bpy_internal/extensions/tags.py"
    tool = scripts / "addons_core/bl_pkg/cli/blender_ext.py"
    command = [sys.executable, str(tool), "validate", f"--valid-tags={tags}", str(zips[platform])]
    process = subprocess.run(command, capture_output=True, text=True, check=False)
    assert process.returncode == 0, process.stdout + process.stderr


def test_the_pages_sources_in_the_zip_make_the_page_in_the_zip(zips: dict[str, Path], tmp_path: Path) -> None:
    """It is minified, so its sources must be there, whole."""
    with ZipFile(zips["linux-x64"]) as archive:
        archive.extractall(tmp_path)
    sources, modules = tmp_path / "shaders/three", ROOT / "shaders/three/node_modules"
    if modules.is_dir() and os.name != "nt":  # where links need rights
        (sources / "node_modules").symlink_to(modules)
    else:
        npm(sources, "ci", "--ignore-scripts", "--no-audit", "--no-fund", "--loglevel=error")
    npm(
        sources,
        "run",
        "--silent",
        "build:page",
        "--",
        f"--outfile={tmp_path / 'viewer.js'}",
        "--log-level=warning",
    )
    built = tmp_path / "radtex_addon/export/web/built"
    for name in ("viewer.js", "viewer.css"):
        assert (tmp_path / name).read_bytes() == (built / name).read_bytes()
    assert (sources / "page/index.html").read_bytes() == (built / "index.html").read_bytes()


def npm(folder: Path, *arguments: str) -> None:
    tool = [
        os.environ.get("UV") or shutil.which("uv") or "uv",
        "run",
        "--quiet",
        "--frozen",
        "--isolated",
        "--only-group=package",
        f"--project={ROOT}",
        f"--python={sys.executable}",
        "npm",
    ]
    process = subprocess.run([*tool, *arguments], cwd=folder, capture_output=True, text=True, check=False)
    assert process.returncode == 0, process.stdout + process.stderr
