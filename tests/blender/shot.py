# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Small pictures by Cycles: of light, or of where rays hit the surface and its shading normal there."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from mathutils import Vector

from radtex_addon.core.arrays import Floats
from radtex_addon.core.surface import SurfaceMesh
from radtex_addon.formats.containers.exr import read_render
from tests.blender import stage


def small_picture(scene: Any, folder: Path) -> Floats:
    """What the scene's camera sees by Cycles: (8, 8, 4), linear."""
    scene.render.engine = "CYCLES"
    scene.render.resolution_x = scene.render.resolution_y = 8
    scene.cycles.samples, scene.cycles.use_denoising = 4, False
    scene.view_settings.view_transform = "Raw"
    settings = scene.render.image_settings
    if hasattr(settings, "media_type"):
        settings.media_type = "IMAGE"
    settings.file_format, settings.color_depth = "OPEN_EXR", "32"
    scene.render.filepath = str(folder / "seen.exr")
    bpy.ops.render.render(write_still=True)
    return next(iter(read_render(folder / "seen.exr").values()))


def rendered_surface(folder: Path, at: Sequence[float], size: float) -> tuple[Floats, Floats]:
    """Positions and shading normals (turned to the camera) where 40² rays hit: (R, 3) each."""
    scene: Any = bpy.context.scene
    camera = bpy.data.cameras.new("shot")
    camera.type, camera.ortho_scale = "ORTHO", size
    scene.camera = bpy.data.objects.new("shot", camera)
    scene.collection.objects.link(scene.camera)
    away = Vector((0.55, -0.35, 0.8)).normalized()
    scene.camera.location = Vector(at) + 3 * size * away
    scene.camera.rotation_euler = away.to_track_quat("Z", "Y").to_euler()
    render = scene.render
    render.engine, render.resolution_x, render.resolution_y = "CYCLES", 40, 40
    scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.use_adaptive_sampling = 1, False, False
    layer = scene.view_layers[0]
    layer.use_pass_position = layer.use_pass_normal = True
    layer.material_override = stage.material("diffuse", "ShaderNodeBsdfDiffuse")  # others bend normals
    if hasattr(render.image_settings, "media_type"):
        render.image_settings.media_type = "MULTI_LAYER_IMAGE"
    render.image_settings.file_format, render.image_settings.color_depth = "OPEN_EXR_MULTILAYER", "32"
    render.filepath = str(folder / "shot.exr")
    bpy.ops.render.render(write_still=True)
    layers = read_render(folder / "shot.exr")
    named = {name.rpartition(".")[2]: image.reshape(-1, image.shape[2]) for name, image in layers.items()}
    position, normal = (named[name].astype(np.float64) for name in ("Position", "Normal"))
    hit = np.linalg.norm(normal, axis=1) > 0.5
    return position[hit], normal[hit]


def distance_and_normal(surface: SurfaceMesh, points: Floats) -> tuple[Floats, Floats]:
    """How far the nearest point of the surface lies from each of `points` (R, 3), and its normal there."""
    corners = surface.corner_position
    weights = barycentric(corners[None], points[:, None])
    nearest = np.einsum("rfk,fkc->rfc", weights, corners)
    gaps = np.linalg.norm(nearest - points[:, None], axis=2)
    chosen, rows = gaps.argmin(axis=1), np.arange(len(points))
    unit = surface.normal / np.linalg.norm(
        surface.normal, axis=2, keepdims=True
    )  # Cycles has unit normals there
    normal = np.einsum("rk,rkc->rc", weights[rows, chosen], unit[chosen])
    return gaps[rows, chosen], normal / np.linalg.norm(normal, axis=1, keepdims=True)


def barycentric(corners: Floats, point: Floats) -> Floats:
    """Weights of the nearest point: exact inside a triangle, roughly so outside it."""
    a, b, c = corners[..., 0, :], corners[..., 1, :], corners[..., 2, :]
    u, v, w = b - a, c - a, point - a
    uu, uv, vv = (np.sum(s * t, axis=-1) for s, t in ((u, u), (u, v), (v, v)))
    wu, wv = np.sum(w * u, axis=-1), np.sum(w * v, axis=-1)
    det = np.maximum(uu * vv - uv * uv, 1e-30)
    s, t = (vv * wu - uv * wv) / det, (uu * wv - uv * wu) / det
    weights: Floats = np.clip(np.stack([1 - s - t, s, t], axis=-1), 0, None)
    weights /= weights.sum(axis=-1, keepdims=True)
    return weights
