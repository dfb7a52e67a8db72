# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes of objects that share or split an atlas, and how near a finished bake comes to path tracing."""

from __future__ import annotations

from dataclasses import dataclass
from math import radians
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np
import numpy.typing as npt
from mathutils import Vector

from radtex_addon.formats.sidecar_file import SidecarFile
from radtex_addon.report.finished_bake import read_bake
from radtex_addon.report.gbuffer import Array, BakedSurface, CameraRays
from radtex_addon.report.metrics import Mask, Picture
from radtex_addon.scene.preview_file import baked_copy
from tests.bench.fidelity.rendering import Rendering, render
from tests.bench.fidelity.scenes import Stage
from tests.bench.fidelity.scenes.materials import assign, checker, principled
from tests.bench.fidelity.scenes.meshes import made, move_to, places
from tests.bench.fidelity.scenes.stage import start
from tests.blender.surroundings import sample_sky_coarsely

PIXELS, _REFERENCE = 96, 24  # of a path-traced picture's side, and its samples


def pair() -> Stage:
    """A ball of gold with a red cap beside a box of blue and gold, whose slots are in other orders."""
    _start()
    gold = principled("Gold", (0.9, 0.6, 0.2), Metallic=1.0, Roughness=0.12)
    red = principled("Red", (0.6, 0.03, 0.02), Roughness=0.5)
    blue = principled("Blue", (0.03, 0.08, 0.6), Roughness=0.25)
    _add_ball(48, 24, 0.5, (-0.52, 0, 0.5))
    ball = _named("Ball", gold, red)
    _paint(ball, 1, lambda middle, _: middle[:, 2] > 0.25)
    bpy.ops.object.shade_smooth()
    bpy.ops.mesh.primitive_cube_add(size=0.8, location=(0.5, 0.1, 0.4), rotation=(0, 0, 0.4))
    box = _named("Box", blue, gold, red)
    _paint(box, 1, lambda _, normal: normal[:, 0] < -0.5)
    _paint(box, 2, lambda _, normal: normal[:, 2] > 0.5)
    return _finished("pair", ball)


def corner() -> Stage:
    """One object of two materials that mirror one another: a gold ball on a polished table of blue."""
    _start()
    gold = principled("Gold", (0.9, 0.6, 0.2), Metallic=1.0, Roughness=0.12)
    blue = principled("Blue", (0.05, 0.12, 0.7), Metallic=1.0, Roughness=0.2)
    _add_ball(48, 24, 0.42, (0, 0, 0.55))
    ball = _named("Corner", gold)
    bpy.ops.object.shade_smooth()
    bpy.ops.mesh.primitive_cube_add(size=1, location=(0, 0, 0.05))
    table = _named("Table", blue)
    table.scale = (1.5, 1.5, 0.1)
    bpy.ops.object.transform_apply(scale=True)
    ball.select_set(True)
    cast(Any, bpy.context.view_layer).objects.active = ball
    bpy.ops.object.join()
    return _finished("corner", ball)


def detailed() -> Stage:
    """A ball of gold with bumps and a blue belt, "High", and a coarser smooth ball around it, "Low"."""
    _start()
    gold = principled("Gold", (0.9, 0.6, 0.2), Metallic=1.0, Roughness=0.15)
    blue = principled("Blue", (0.03, 0.08, 0.6), Roughness=0.3)
    _add_ball(128, 64, 0.6, (0, 0, 0.62))
    high = _named("High", gold, blue)
    place = places(high)
    around, rise = np.arctan2(place[:, 1], place[:, 0]), np.arcsin(np.clip(place[:, 2] / 0.6, -1, 1))
    bump = 0.02 * np.sin(8 * around) * np.sin(6 * rise) * np.cos(rise)
    move_to(high, place * (1 + bump[:, None] / 0.6))
    _paint(high, 1, lambda middle, _: np.abs(middle[:, 2]) < 0.11)
    bpy.ops.object.shade_smooth()
    _add_ball(32, 16, 0.61, (0, 0, 0.62))
    low = _named("Low")
    bpy.ops.object.shade_smooth()
    return _finished("detailed", low)


def _start() -> None:
    start("sunset.exr", strength=0.6, turn=30)
    sample_sky_coarsely()


def _add_ball(segments: int, rings: int, radius: float, place: tuple[float, float, float]) -> None:
    """Add a ball whose faces come in the same order each time, as Blender's do not."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=segments, ring_count=rings, radius=radius, location=place)
    mesh: Any = made().data
    corners = [tuple(vertex.co) for vertex in mesh.vertices]
    faces = sorted(tuple(face.vertices) for face in mesh.polygons)
    mesh.clear_geometry()
    mesh.from_pydata(corners, [], faces)


def _named(name: str, *materials: bpy.types.Material) -> bpy.types.Object:
    item = made()
    item.name = name
    for material in materials:
        assign(item, material)
    return item


def _paint(item: bpy.types.Object, slot: int, chosen: Any) -> None:
    """Give a slot to the faces that `chosen` marks, of their middles and normals (F, 3) in object space."""
    polygons: Any = cast(bpy.types.Mesh, item.data).polygons
    middle, normal = np.empty(3 * len(polygons)), np.empty(3 * len(polygons))
    polygons.foreach_get("center", middle)
    polygons.foreach_get("normal", normal)
    for index in np.flatnonzero(chosen(middle.reshape(-1, 3), normal.reshape(-1, 3))).tolist():
        polygons[index].material_index = slot


def _finished(name: str, subject: bpy.types.Object) -> Stage:
    """Lay a floor, and set two cameras about the origin."""
    bpy.ops.mesh.primitive_plane_add(size=10, location=(0, 0, -0.04))
    assign(made(), checker(tiles=20))
    cameras = tuple(_camera(f"view {turn}", turn, 22) for turn in (-25, 160))
    cast(bpy.types.Scene, bpy.context.scene).camera = cameras[0]
    return Stage(name, subject, cameras, ())


def _camera(name: str, azimuth: float, elevation: float) -> bpy.types.Object:
    turn, rise = radians(azimuth), radians(elevation)
    away = Vector((np.sin(turn) * np.cos(rise), -np.cos(turn) * np.cos(rise), np.sin(rise)))
    data = bpy.data.cameras.new(name)
    data.lens = 60
    item = cast(bpy.types.Object, bpy.data.objects.new(name, data))
    item.location = Vector((0, 0, 0.4)) + 4 * away
    item.rotation_euler = (-away).to_track_quat("-Z", "Y").to_euler()
    cast(bpy.types.Scene, bpy.context.scene).collection.objects.link(item)
    return item


def looking(camera: Any, pixels: int = PIXELS) -> CameraRays:
    """One ray for each pixel."""
    half = camera.data.sensor_width / 2 / camera.data.lens
    turn = np.array(camera.rotation_euler.to_matrix())
    return CameraRays.of_camera(np.array(camera.location), turn, half, pixels, 1)


@dataclass(frozen=True, eq=False)
class View:
    """What bakes show from a camera beside a path-traced picture, (H, W, 3), and where they are seen."""

    shown: Picture
    expected: Picture
    inside: Mask

    def psnr(self, some: Mask | None = None) -> float:
        """Of the display values where the bakes are seen, or of `some` of these pixels."""
        inside = self.inside if some is None else self.inside & some
        one, other = (np.clip(image[inside], 0, 1) ** (1 / 2.2) for image in (self.shown, self.expected))
        return float(-10 * np.log10(((one - other) ** 2).mean()))

    def save(self, path: Path) -> None:
        """Both pictures, side by side, as a PNG."""
        both = np.concatenate([np.where(self.inside[..., None], self.shown, self.expected), self.expected], 1)
        pixels = np.ones((*both.shape[:2], 4), dtype=np.float32)
        pixels[..., :3] = np.clip(both, 0, 1)
        image: Any = bpy.data.images.new(path.stem, both.shape[1], both.shape[0], float_buffer=True)
        image.pixels.foreach_set(np.ascontiguousarray(pixels[::-1]).ravel())
        image.file_format = "PNG"
        image.save(filepath=str(path))


def view(stage: Stage, camera: bpy.types.Object, sidecars: list[Path]) -> View:
    """The bakes with these sidecars, seen by the camera, each pixel by the bake whose surface is nearest."""
    rays = looking(camera)
    nearest = np.full(len(rays.away), np.inf)
    shown, inside = np.zeros((len(rays.away), 3)), np.zeros(len(rays.away), dtype=bool)
    for sidecar in sidecars:
        distance, light = _lit(sidecar, rays)
        nearer = distance < nearest
        shown[nearer], nearest[nearer] = light[nearer], distance[nearer]
        inside |= np.isfinite(distance)
    expected = _path_traced(stage, camera, sidecars)
    mask: Mask = inside.reshape(PIXELS, PIXELS)
    inner = mask.copy()
    for shift in ((0, 1), (0, -1), (1, 0), (-1, 0)):
        inner &= np.roll(mask, shift, (0, 1))
    return View(shown.reshape(PIXELS, PIXELS, 3), expected, inner)


def _path_traced(stage: Stage, camera: bpy.types.Object, sidecars: list[Path]) -> Picture:
    """The scene, without objects that were baked from another one."""
    facts = [read_bake(SidecarFile.read(sidecar)).sidecar for sidecar in sidecars]
    scene = cast(bpy.types.Scene, bpy.context.scene)
    hidden = [scene.objects[one.object_name] for one in facts if one.source is not None]
    for item in hidden:
        item.hide_render = True
    try:
        picture: Picture = render(stage, camera, Rendering(_REFERENCE, 1, alone=False, pixels=PIXELS))[
            ..., :3
        ]
    finally:
        for item in hidden:
            item.hide_render = False
    return picture


def _lit(sidecar: Path, rays: CameraRays) -> tuple[npt.NDArray[np.float64], Array]:
    """Where rays meet a bake's surface, (N,), infinite where they do not, and the light there (N, 3)."""
    bake = read_bake(SidecarFile.read(sidecar))
    facts = bake.sidecar
    part = None if facts.part is None else facts.part.index
    with baked_copy(bake.preview, facts.surfaces, facts.uv_map, part) as (_, copy):
        surface = BakedSurface(cast(bpy.types.Mesh, copy.data), np.array(copy.matrix_world), facts.uv_map)
    seen = surface.gbuffer(rays, np.full(len(rays.away), 1e9))
    distance = np.linalg.norm(seen.position - rays.origin, axis=1)
    return np.where(seen.hit, distance, np.inf), bake.radiance(seen)
