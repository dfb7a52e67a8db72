# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Each file says its licence: MIT for what runs in games and on pages, GPL for the rest."""

from __future__ import annotations

import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SAYING = {
    ".css",
    ".glsl",
    ".gdshader",
    ".gdshaderinc",
    ".hlsl",
    ".html",
    ".md",
    ".mjs",
    ".js",
    ".osl",
    ".py",
    ".ts",
    ".wgsl",
}
LINE = "SPDX-License-Identifier: "


def test_shaders_are_mit_and_the_rest_is_gpl() -> None:
    command = ["git", "ls-files", "--cached", "--others", "--exclude-standard"]
    names = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout.splitlines()
    files = [ROOT / name for name in names if Path(name).suffix in SAYING and (ROOT / name).is_file()]
    found = {path: said(path) for path in files}
    shaders = ROOT / "shaders"
    assert {path for path, licence in found.items() if licence is None} == set()
    assert {path for path in files if shaders in path.parents and found[path] != "MIT"} == set()


def said(path: Path) -> str | None:
    """The licence in a file's first lines."""
    head = path.read_text(encoding="utf-8").splitlines()[:12]
    lines = [line for line in head if LINE in line]
    return lines[0].split(LINE)[1].split()[0] if lines else None
