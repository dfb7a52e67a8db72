# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes are the same files to the last byte, whatever surrounds them (`tests.bench.determinism` is wider)."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import bpy
import pytest

from tests.bench.determinism import scenes
from tests.bench.determinism.__main__ import baked, started
from tests.blender import stage

pytestmark = pytest.mark.one_blender
CHEAP = ["radiance", "layers", "incident", "shadow", "ao", "transfer", "lights", "layered"]


@pytest.mark.skipif(sys.platform != "linux", reason="processes are kept to one core")
def test_hash_seed_cores_memory_folder_and_address_change_no_bit(tmp_path: Path) -> None:
    context: Any = bpy.context
    scenes.build("lamps")
    stage.world((0.2, 0.3, 0.4))  # the sky's picture costs each render its time
    blend = tmp_path / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    assert len([item for item in context.scene.objects if item.type == "LIGHT"]) > 10
    options = ("--uv", "UVMap", "--smaller", "2")
    both = [
        started(blend, CHEAP, tmp_path / "plain", *options),
        started(blend, CHEAP, tmp_path / "an other place", *options, odd=True),
    ]
    plain, odd = map(baked, both)
    assert list(plain) == CHEAP
    assert all(plain.values())
    assert odd == plain
