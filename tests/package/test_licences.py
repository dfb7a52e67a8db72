# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Every source names its licence: MIT in shaders/ and in Godot's project, which games ship; GPL elsewhere."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

pytestmark = pytest.mark.one_blender

GAMES_SHIP = ("shaders/", "radtex_addon/export/godot_project/")
ROOT = Path(__file__).resolve().parents[2]
SHADERS = ("*.c", "*.glsl", "*.hlsl", "*.cginc", "*.shader", "*.osl", "*.wgsl", "*.gdshader", "*.gdshaderinc")
SCRIPTS = ("*.gd", "*.cs", "*.template", "*.ts", "*.js", "*.mjs", "*.css", "*.sh", ".ci/run")
SOURCES = ("*.py", "*.toml", *SHADERS, *SCRIPTS)


def sources() -> list[str]:
    command = ["git", "ls-files", "--cached", "--others", "--exclude-standard", *SOURCES]
    listed = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout.splitlines()
    return [name for name in listed if (ROOT / name).exists()]


def test_every_source_names_its_licence_at_the_top() -> None:
    found = sources()
    assert len(found) > 500
    assert [name for name in found if not says_its_licence(name)] == []


def says_its_licence(name: str) -> bool:
    head = (ROOT / name).read_text(encoding="utf-8").splitlines()[:4]
    licence = "MIT" if name.startswith(GAMES_SHIP) else "GPL-3.0-or-later"
    wanted = ("SPDX-FileCopyrightText: 2026 RadTex authors", f"SPDX-License-Identifier: {licence}")
    return all(any(line.removesuffix(" */").endswith(words) for line in head) for words in wanted)
