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
SHADERS = ("*.glsl", "*.hlsl", "*.cginc", "*.shader", "*.osl", "*.wgsl", "*.gdshader", "*.gdshaderinc")
SOURCES = (
    "*.py",
    "*.toml",
    *SHADERS,
    "*.gd",
    "*.cs",
    "*.template",
    "*.ts",
    "*.js",
    "*.mjs",
    "*.css",
    "*.sh",
    ".ci/run",
)


def sources() -> list[str]:
    command = ["git", "ls-files", "--cached", "--others", "--exclude-standard", *SOURCES]
    listed = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout.splitlines()
    return [name for name in listed if (ROOT / name).exists()]


@pytest.mark.parametrize("name", sources())
def test_a_source_names_its_licence_at_the_top(name: str) -> None:
    head = (ROOT / name).read_text(encoding="utf-8").splitlines()[:4]
    licence = "MIT" if name.startswith(GAMES_SHIP) else "GPL-3.0-or-later"
    said = [line.removesuffix(" */") for line in head]
    assert any(line.endswith("SPDX-FileCopyrightText: 2026 RadTex authors") for line in said)
    assert any(line.endswith(f"SPDX-License-Identifier: {licence}") for line in said)
