# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the batch prints: no name drives a terminal, and a closed or full output loses no result."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import bpy
import pytest

from tests.blender import stage
from tests.blender.batch_process import BAKE, Batch

pytestmark = pytest.mark.one_blender

_NAME = "Ca\x1b[31mrd\x9b\u202e\a\nradtex: done"
_TINY = ("--layout", "buckets", "--texels", "8", "--bucket", "2", "--samples", "1")


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A .blend whose names are hostile."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.ops.mesh.primitive_plane_add(size=2)
    context: Any = bpy.context
    context.object.name = _NAME
    context.object.data.materials.append(stage.material("white\x1b]0;x\a", "ShaderNodeBsdfDiffuse"))
    missing: Any = bpy.data.images.new("gone\x1b[2J", 1, 1)
    missing.source, missing.filepath_raw = "FILE", "/nowhere/\x1b[2J.png"
    node = context.object.data.materials[0].node_tree.nodes.new("ShaderNodeTexImage")
    node.image = missing
    stage.world()
    path = tmp_path_factory.mktemp("room") / "ro\x1b[31mom.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)
    return path


@pytest.mark.parametrize("style", ["bar", "json"])
@pytest.mark.parametrize("command", ["bake", "prepare"])
def test_no_name_drives_a_terminal(command: str, style: str, room: Path, out: Path, batch: Batch) -> None:
    words = [] if command == "bake" else [command]
    ended = batch(*words, room, "--object", _NAME, *_TINY, "--out", out, "--progress", style)
    assert ended.code == 0, ended.err
    for line in (ended.out + ended.err).split("\n"):
        assert line.isprintable(), ascii(line)
        assert not line.startswith("radtex: done")
    if style == "json":
        assert {json.loads(line).get("object", _NAME) for line in ended.out.splitlines()} == {_NAME}
    else:
        assert r"Ca\x1b[31mrd\x9b\u202e\x07\nradtex: done" in ended.out


def test_errors_quote_names_and_drive_nothing(room: Path, out: Path, batch: Batch) -> None:
    for words in (
        (room, "--object", "\x1b[31mNobody\u202e", "--out", out),
        (room.with_name("\x1b[2J\u2066.blend"), "--object", "A", "--out", out),
        (room, "--object", _NAME, "--out", out, "--device", "\x1b[2J"),
        ("report", out / "\x9b2J", "--scene", room),
    ):
        ended = batch(*words)
        assert ended.code == 2
        assert all(map(str.isprintable, ended.err.splitlines())), ascii(ended.err)


@pytest.mark.skipif(sys.platform == "win32", reason="a shell of POSIX closes and fills outputs")
@pytest.mark.parametrize(
    ("how", "style", "code"),
    [(">&-", "none", 1), ("2>/dev/full", "bar", 0)],
)
def test_a_lost_output_loses_no_bake(how: str, style: str, code: int, room: Path, out: Path) -> None:
    script = f'exec "$0" "$@" {how}'
    command = ["bash", "-c", script, sys.executable, BAKE, str(room), "--object", _NAME, *_TINY]
    ended = subprocess.run(
        [*command, "--out", str(out), "--progress", style], capture_output=True, text=True, check=False
    )
    assert ended.returncode == code, ended.stderr
    assert len(list(out.iterdir())) == 2, "the atlas and its sidecar"
    if code and "2>" not in how:
        (said,) = [line for line in ended.stderr.splitlines() if "warning" not in line]
        assert said.startswith("radtex: the standard output cannot be written (")
        assert "all files are complete" in said
    else:
        assert ended.stderr == ""


@pytest.mark.skipif(sys.platform == "win32", reason="a shell of POSIX closes and fills outputs")
def test_help_that_cannot_be_printed_is_no_success() -> None:
    command = ["bash", "-c", 'exec "$0" "$@" >/dev/full', sys.executable, BAKE, "--help"]
    ended = subprocess.run(command, capture_output=True, text=True, check=False)
    assert ended.returncode == 1
    assert ended.stderr.startswith("radtex: the standard output cannot be written (")
    assert ended.stderr.count("\n") == 1
