# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The bench of rooms (tests/bench/rooms): its page of three.js with light maps, against path tracing."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from tests.bench.assets import three_scene
from tests.bench.assets.views import Pictures, bounds_inside, scene_cameras
from tests.bench.fidelity.scenes.materials import principled
from tests.bench.rooms.building import Box, boxes, cameras, dressed, shell, start
from tests.bench.rooms.light_maps import write_lit_page
from tests.real.exhibit import decibels
from tests.real.web import Site

PIXELS, SAMPLES = 64, 64
TEXELS, LIGHT_SAMPLES = 16000, 32
SIZE = (3.0, 3.6, 2.4)
LEAST = 28.0  # dB
LAMP = (0.5, -0.4, 1.9)


def build_matt_room() -> None:
    """A closed room with a lamp, a white table whose colour nodes compute, and a box; nothing is glossy."""

    def matt(name: str, colour: tuple[float, float, float]) -> Any:
        return principled(name, colour, Roughness=1.0, Specular_IOR_Level=0.0)

    start()
    walls = shell(*SIZE, {})
    paint = {"Floor": (0.6, 0.4, 0.25), "Ceiling": (0.8, 0.8, 0.8), "East": (0.7, 0.2, 0.1)}
    for name, wall in walls.items():
        dressed(wall, matt(name, paint.get(name, (0.7, 0.7, 0.7))))
    table: Box = ((-0.6, 0.2, 0.5), (0.5, 1.0, 0.6))
    computed = matt("Computed", (0, 0, 0))
    tree: Any = computed.node_tree
    rgb = tree.nodes.new("ShaderNodeRGB")
    rgb.outputs[0].default_value = (0.2, 0.5, 0.3, 1)
    tree.links.new(rgb.outputs[0], tree.nodes["Principled BSDF"].inputs["Base Color"])
    dressed(boxes("Table", table), computed)
    dressed(boxes("Box", ((-1.2, -0.5, 0.0), (-0.6, 0.1, 0.7)), bevel=0.03), matt("Box", (0.8, 0.8, 0.8)))
    lamp: Any = bpy.data.lights.new("Lamp", "POINT")
    lamp.energy, lamp.shadow_soft_size = 60.0, 0.15
    item = bpy.data.objects.new("Lamp", lamp)
    item.location = LAMP
    collection: Any = bpy.context.collection
    collection.objects.link(item)
    cameras([((1.2, -1.5, 1.5), (-0.6, 0.6, 0.7))], 70.0)


def test_a_matt_room_looks_as_in_cycles(web: Site, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its light is all in light maps, of the right strength; the probe adds nothing."""
    monkeypatch.setattr(three_scene, "HEIGHT", 64)
    monkeypatch.setattr(three_scene, "SAMPLES", 4)
    build_matt_room()
    file = tmp_path / "room.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(file))
    low, high = bounds_inside(scene_cameras(PIXELS))
    assert np.allclose(high - low, SIZE, atol=1e-3)
    pictures = Pictures(file, tmp_path, SAMPLES)
    view = scene_cameras(PIXELS)
    maps = write_lit_page(pictures, web.folder / "lit-room", TEXELS, LIGHT_SAMPLES)
    assert sum(one.width * one.height for one in maps) == pytest.approx(TEXELS, rel=0.25)
    (picture,) = three_scene.pictures_by_three(web, "lit-room", view)
    traced = pictures.traced(view[0])
    found = decibels(picture, traced, np.ones(traced.shape[:2], bool))
    print(f"light maps in three.js: {found:.1f} dB, {picture.mean() / traced.mean():.3f} of the light")
    assert found > LEAST
    assert picture.mean() == pytest.approx(traced.mean(), rel=0.04)
