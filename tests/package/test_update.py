# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A zip of a later version installed over this one: the panel offers what is new, in that zip's words."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path
from typing import Any
from zipfile import ZIP_DEFLATED, ZipFile

import pytest

from radtex_addon.version import VERSION

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


def test_an_update_offers_its_changes_and_a_first_install_none(
    bare_python: Path, own_zip: Path, later_zip: Path, tmp_path: Path
) -> None:
    process = subprocess.run(
        [str(bare_python), "-I", "-c", INSTALL_BOTH, str(own_zip), str(later_zip)],
        env=os.environ | {"BLENDER_USER_RESOURCES": str(tmp_path / "home")},
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert process.returncode == 0, process.stdout + process.stderr
    first, then = (dict[str, Any](told) for told in json.loads(process.stderr.splitlines()[-1]))
    assert (first["seen"], first["news"]) == (VERSION, False)
    assert (then["seen"], then["news"]) == (VERSION, True)
    assert then["changes"] == [[f"{LATER} · Changed", ["Water is wet."]]]
