# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes that are killed and gone on with: real processes, and files that are the same to the last bit."""

from __future__ import annotations

import hashlib
import json
import os
import random
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import bpy
import pytest

from radtex_addon.bake.spec import BakeSpec
from tests.blender import stage
from tests.blender.batch_process import BAKE

context: Any = bpy.context  # to the stubs, every pointer may be None

PLAIN = ("--uv", "UVMap", "--texels", "24", "--bucket", "16", "--samples", "1", "--memory", "16")
SHARED = ("--layout", "shared", "--texels", "20", "--bucket", "4", "--samples", "1")
QUICK = BakeSpec(texels=16, bucket=4, samples=1)
FOLDER = "Ball.radiance.radtex-unfinished"


def fill_scene() -> None:
    """A shiny ball on a floor, under a lamp and a grey sky."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    stage.world()
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=2)
    context.object.name = "Ball"
    shiny = stage.material("shiny", "ShaderNodeBsdfAnisotropic", Color=(0.9, 0.6, 0.3, 1), Roughness=0.2)
    context.object.data.materials.append(shiny)
    bpy.ops.mesh.primitive_plane_add(size=6, location=(0, 0, -1))
    context.object.name = "Floor"
    floor = stage.material("floor", "ShaderNodeBsdfDiffuse", Color=(0.2, 0.5, 0.8, 1))
    context.object.data.materials.append(floor)
    bpy.ops.object.light_add(type="POINT", location=(2, 1, 3))
    context.object.name = "Lamp"
    context.object.data.energy = 200


@pytest.fixture(autouse=True)
def scene() -> None:
    fill_scene()


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> Path:
    fill_scene()
    path = tmp_path_factory.mktemp("room") / "room.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)
    return path


@pytest.fixture
def out(tmp_path: Path) -> Path:
    return tmp_path / "out"


def digests(folder: Path) -> dict[str, str]:
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in folder.iterdir()}


# processes that are killed


class Running:
    """A batch process, from the moment at which its bake begins."""

    def __init__(self, room: Path, out: Path, temporary: Path, *arguments: str) -> None:
        temporary.mkdir(exist_ok=True)
        command = [sys.executable, BAKE, str(room), "--object", "Ball", "--out", str(out), *arguments]
        self.process = subprocess.Popen(
            [*command, "--progress", "json"],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env={**os.environ, "TMPDIR": str(temporary)},
        )
        assert self.process.stdout is not None
        self.first = json.loads(self.process.stdout.readline() or "{}")
        self.since = time.monotonic()

    def end(self) -> float:
        """Wait for its end, which must be a good one; returns the seconds since it began to bake."""
        said, err = self.process.communicate(timeout=120)
        assert self.process.returncode == 0, (said, err)
        assert err == ""
        return time.monotonic() - self.since

    def kill_after(self, seconds: float) -> bool:
        """SIGKILL; False where it was done by then."""
        try:
            self.process.wait(seconds)
        except subprocess.TimeoutExpired:
            self.process.kill()
        self.process.communicate()
        assert self.process.returncode in (0, -9)
        return self.process.returncode == -9


@pytest.mark.skipif(sys.platform == "win32", reason="there are no signals")
@pytest.mark.parametrize(("arguments", "kills"), [(PLAIN, 20), (SHARED, 4)], ids=["plain", "shared"])
def test_files_are_the_same_however_often_the_bake_was_killed(
    room: Path, tmp_path: Path, arguments: tuple[str, ...], kills: int
) -> None:
    chance = random.Random(7)
    expected = tmp_path / "uninterrupted"
    seconds = Running(room, expected, tmp_path / "temporary", *arguments).end()
    left, bakes, went_on = kills, 0, 0
    while left:
        out = tmp_path / f"out {bakes}"
        bakes += 1
        for _ in range(min(5, left)):
            went_on += any((out / FOLDER).glob("*.piece"))
            running = Running(room, out, tmp_path / "temporary", *arguments, "--resume")
            left -= running.kill_after(chance.uniform(0.2, 0.9) * seconds)
            if is_done(out):
                break
        else:
            Running(room, out, tmp_path / "temporary", *arguments, "--resume").end()
        assert digests(out) == digests(expected)
    assert went_on > kills // 4, "kills came too early to leave anything"


def is_done(out: Path) -> bool:
    return (out / "Ball.radiance.json").exists() and not (out / FOLDER).exists()
