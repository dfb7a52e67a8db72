# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What is handed over to a worker is looked at: images are files of their own folder, caches are files."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.core.errors import InputError
from radtex_addon.worker.handover import hand_over
from radtex_addon.worker.unsaved_images import load_unsaved, save_unsaved

pytestmark = pytest.mark.one_blender


@pytest.fixture
def painted(tmp_path: Path) -> Path:
    image: Any = bpy.data.images.new("Paint", 3, 2)
    image.pixels = [0.5] * 24
    image.update()
    assert save_unsaved(tmp_path / "images")
    return tmp_path / "images"


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("file", "../secret.npy"),
        ("file", "/etc/passwd"),
        ("file", 7),
        ("name", None),
        ("tiled", "yes"),
        ("more", 1),
    ],
)
def test_a_list_that_leads_elsewhere_is_refused(key: str, value: Any, painted: Path) -> None:
    listed = painted / "images.json"
    (entry,) = json.loads(listed.read_text())
    listed.write_text(json.dumps([entry | {key: value}]))
    with pytest.raises(InputError, match=r"holds no unsaved images .*: hand the scene over again"):
        load_unsaved(painted)


@pytest.mark.parametrize(
    "pixels",
    [
        np.zeros(3, np.uint8),
        np.zeros((2, 3, 9), np.uint8),
        np.zeros((0, 3, 4), np.uint8),
        np.zeros((2, 3, 4)),
    ],
)
def test_pixels_that_are_no_images_are_refused(pixels: Any, painted: Path) -> None:
    np.save(painted / "0.npy", pixels)
    with pytest.raises(InputError, match=r"holds no image"):
        load_unsaved(painted)


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such files")
@pytest.mark.parametrize("name", ["images.json", "0.npy"])
def test_a_pipe_is_not_waited_for(name: str, painted: Path) -> None:
    (painted / name).unlink()
    os.mkfifo(painted / name)
    with pytest.raises(InputError, match="pipe"):
        load_unsaved(painted)


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such files")
def test_of_a_cache_only_files_are_copied(tmp_path: Path) -> None:
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    caches = tmp_path / "blendcache_scene"
    (caches / "deep").mkdir(parents=True)
    (caches / "deep" / "1.bphys").write_bytes(b"cache")
    os.mkfifo(caches / "pipe")
    (caches / "endless").symlink_to("/dev/zero")
    scene: Any = bpy.context.scene
    handed = hand_over(scene, tmp_path / "jobs")
    copied = handed.folder / "blendcache_scene"
    files = [path.relative_to(copied).as_posix() for path in copied.rglob("*") if not path.is_dir()]
    assert files == ["deep/1.bphys"]
