# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The bench of assets (tests/bench/assets): its page of three.js alone, in Chromium, against path tracing."""

from __future__ import annotations

import shutil
from math import pi
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest
from PIL import Image

from radtex_addon.report.gbuffer import eroded
from radtex_addon.report.metrics import Mask
from tests.bench.assets import three_scene
from tests.bench.assets.views import Pictures, rays_of, scene_cameras
from tests.bench.three_cost.__main__ import OURS, TEMPORAL, WAYS, timed
from tests.blender import stage
from tests.blender.image_stage import NAME, crate, texture_set
from tests.real.exhibit import Camera, Exhibit, decibels
from tests.real.web import Site

context: Any = bpy.context  # to the stubs, every pointer may be None
PIXELS, SAMPLES = 64, 16
LEAST = 26.0  # dB of a convex box that has all of its surroundings in the probe
CAMERA = Camera("view0", (3.6, -4.4, 3.2), (0.3, -0.2, 0.5))


def add_camera(camera: Camera) -> None:
    data = bpy.data.cameras.new(camera.name)
    data.lens = 18 / np.tan(np.radians(camera.fovy) / 2)
    item = bpy.data.objects.new(camera.name, data)
    item.matrix_world = camera.matrix
    context.scene.collection.objects.link(item)
    context.view_layer.update()


def shown(web: Site, folder: Path, name: str) -> tuple[Any, Any]:
    """The open scene's first view by three.js and by Cycles."""
    file = folder / "scene.blend"
    add_camera(CAMERA)
    bpy.ops.wm.save_as_mainfile(filepath=str(file))
    pictures = Pictures(file, folder, SAMPLES)
    cameras = scene_cameras(PIXELS)
    three_scene.write_page(pictures, [NAME], web.folder / name)
    (picture,) = three_scene.pictures_by_three(web, name, cameras)
    return picture, pictures.traced(cameras[0])


def inside() -> Mask:
    """Pixels of the box NAME, without its edges, in the first view."""
    graph = context.evaluated_depsgraph_get()
    rays = rays_of(scene_cameras(PIXELS)[0], 1)
    met = [context.scene.ray_cast(graph, rays.origin, away)[4] for away in rays.away]
    seen = np.array([item is not None and item.name == NAME for item in met])
    return eroded(seen.reshape(rays.pixels, rays.pixels))


@pytest.fixture(autouse=True)
def coarse(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(three_scene, "HEIGHT", 128)
    monkeypatch.setattr(three_scene, "SAMPLES", 4)


def test_images_and_the_probe_are_in_their_places(web: Site, tmp_path: Path) -> None:
    """A box of images below a sky that has a colour in each direction."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    stage.hdri(stage.world())
    crate(texture_set())
    picture, traced = shown(web, tmp_path, "physical-crate")
    found = decibels(picture, traced, inside())
    print(f"MeshPhysicalMaterial: {found:.1f} dB")
    assert found > LEAST


def test_lamps_shine_as_in_blender(web: Site, tmp_path: Path) -> None:
    """A sun above a dull sheet, which gives a known light back, and a box that throws a shadow."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    stage.world((0, 0, 0))
    bpy.ops.mesh.primitive_plane_add(size=20)
    context.object.data.materials.append(
        stage.material("Dull", "ShaderNodeBsdfPrincipled", Roughness=1.0, Specular_IOR_Level=0.0)
    )
    bpy.ops.mesh.primitive_cube_add(size=0.5, location=(0.3, -0.2, 0.5))
    context.object.name = NAME
    bpy.ops.object.light_add(type="SUN", rotation=(0.6, 0, 0))
    context.object.data.energy = 2.0
    context.object.data.angle = 0
    picture, traced = shown(web, tmp_path, "physical-sun")
    grey = 0.8 * 2.0 / pi * np.cos(0.6)
    corner = picture[-4:, -4:].mean()
    assert corner == pytest.approx(grey, rel=0.01)
    floor = np.zeros(picture.shape[:2], bool)
    floor[24:] = True  # below the edge of the sheet
    found = decibels(picture, traced, floor)
    print(f"a lamp and its shadow: {found:.1f} dB")
    assert found > LEAST


def test_the_bench_of_costs_draws_the_bake_by_every_material(
    web: Site, exhibit: Exhibit, tmp_path: Path
) -> None:
    shutil.copytree(web.add("layered", exhibit.layered), place := web.folder / "cost")
    times = timed(web, place, side=48, frames=2, looks=tmp_path)
    assert [len(found) for found in times.values()] == [2] * len(WAYS)
    pictures = {}
    for way in WAYS:
        with Image.open(tmp_path / f"cost-{way}.png") as image:
            pictures[way] = np.asarray(image.convert("RGB"), float)
    covered = [(picture.max(axis=2) > 0).mean() for picture in pictures.values()]
    print(dict(zip(WAYS, covered, strict=True)))
    assert min(covered) > 0.3
    far = {way: np.abs(pictures[OURS] - pictures[way]).mean() for way in WAYS if way != OURS}
    print(far)
    noise = far.pop(TEMPORAL)
    assert min(far.values()) > 5
    assert 0 < noise < 5
