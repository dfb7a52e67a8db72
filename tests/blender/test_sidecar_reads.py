# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A command reads a bake's sidecar once, however many parts of RadTex ask what is in it."""

from __future__ import annotations

import os
import sys
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import bpy
import pytest

from radtex_addon.cli.main import main
from tests.blender import stage

pytestmark = pytest.mark.one_blender

context: Any = bpy.context  # to the stubs, every pointer may be None

BAKES = {
    "buckets": ("radiance", "--layout buckets --bucket 4"),
    "bits": ("shadow", "--kind shadow --bucket 4"),
    "ambient": ("ao", "--kind ao --bucket 4"),
    "sphere": ("transfer", "--kind transfer --bucket 3"),
    "layered": ("radiance", "--layout layered"),
}


class _Opens:
    """Counts the sidecars that are opened for reading, as Python's audit events tell."""

    def __init__(self) -> None:
        self.counting = False
        self.of = Counter[Path]()
        sys.addaudithook(self._heard)  # for good: a hook cannot be removed

    def _heard(self, event: str, arguments: tuple[Any, ...]) -> None:
        if self.counting and event == "open" and isinstance(arguments[0], str | Path):
            path, writes = Path(arguments[0]), arguments[2] & (os.O_WRONLY | os.O_RDWR)
            if path.suffix == ".json" and not writes:
                self.of[path] += 1

    @contextmanager
    def counted(self) -> Iterator[Counter[Path]]:
        self.of.clear()
        self.counting = True
        try:
            yield self.of
        finally:
            self.counting = False


@pytest.fixture(scope="module")
def opens() -> _Opens:
    return _Opens()


@pytest.fixture(scope="module")
def scene_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    stage.world((0.4, 0.6, 1.0))
    bpy.ops.mesh.primitive_uv_sphere_add(segments=8, ring_count=6)
    context.object.name = "Ball"
    bpy.ops.object.camera_add(location=(0, -5, 0), rotation=(1.57, 0, 0))
    context.scene.camera = context.object
    path = tmp_path_factory.mktemp("scene") / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


def run(line: str) -> None:
    assert main(line.split(), inside_blender=False) == 0, line


@pytest.mark.parametrize("name", BAKES)
def test_a_command_reads_a_sidecar_once(name: str, scene_file: Path, tmp_path: Path, opens: _Opens) -> None:
    kind, options = BAKES[name]
    sidecar = tmp_path / f"Ball.{kind}.json"
    small = f"--texels 16 --samples 2 --uv UVMap {options}"
    with opens.counted() as found:
        run(f"{scene_file} --object Ball --out {tmp_path} --save-preview {small}")
    assert found[sidecar] <= 1, "baked"
    commands = [f"export {sidecar} --to gltf --out {tmp_path / 'gltf'}"]
    if kind == "radiance":
        few = "--pixels 48 --samples 1"
        commands += [
            f"export {sidecar} --to godot --out {tmp_path / 'godot'}",
            f"report {sidecar} --scene {scene_file} --views 1 {few} --out {tmp_path}/page.html",
            f"compare {scene_file} --object Ball --bake {tmp_path} {few} --out {tmp_path}/compared",
        ]
    for command in commands:
        with opens.counted() as found:
            run(command)
        assert found[sidecar] == 1, command
