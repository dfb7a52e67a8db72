# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Assets drawn by a seed: parts that are stuck into each other, each with a material of images.

They are as assets are sold: clean UVs, and colour, normal, roughness and metal in images of 1,024 pixels.
"""

from __future__ import annotations

from collections.abc import Callable
from math import cos, pi, sin
from typing import Any, TypeAlias

import bpy
import numpy as np
import numpy.typing as npt
from mathutils import Euler, Vector

from ..fidelity.scenes.stage import start, world_corners

Image: TypeAlias = npt.NDArray[np.floating[Any]]

PIXELS = 1024  # of an image's side
_HDRIS = ("studio.exr", "city.exr", "forest.exr")
_MOST_PARTS = 8
_LENS = 60.0


def draw_asset(seed: int) -> list[bpy.types.Object]:
    """Build the asset of a seed in a new scene with a floor, and cameras view0 to view2: its parts."""
    chance = np.random.default_rng(seed)
    start(_HDRIS[seed % len(_HDRIS)], float(chance.uniform(0.7, 1.2)), float(chance.uniform(0, 360)))
    parts: list[bpy.types.Object] = []
    for number in range(int(chance.integers(2, _MOST_PARTS + 1))):
        part = _SHAPES[int(chance.integers(len(_SHAPES)))]()
        part.name = f"Part {number + 1}"
        _place(part, parts, chance)
        _dress(part, chance)
        parts.append(part)
    bpy.context.view_layer.update()
    corners = np.concatenate([world_corners(part) for part in parts])
    _lay_floor(float(corners[:, 2].min()), chance)
    _set_cameras(corners, chance)
    return parts


def _made(**settings: Any) -> Any:
    item: Any = bpy.context.object
    for face in item.data.polygons:
        face.use_smooth = True
    return item


def _ball() -> Any:
    bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, radius=0.5)
    return _made()


def _ring() -> Any:
    bpy.ops.mesh.primitive_torus_add(
        major_radius=0.45, minor_radius=0.16, major_segments=72, minor_segments=24, generate_uvs=True
    )
    return _made()


def _tube() -> Any:
    bpy.ops.mesh.primitive_cylinder_add(vertices=64, radius=0.3, depth=1.0)
    return _with_sharp_edges(_made())


def _cone() -> Any:
    bpy.ops.mesh.primitive_cone_add(vertices=64, radius1=0.45, radius2=0.12, depth=0.9)
    return _with_sharp_edges(_made())


def _box() -> Any:
    bpy.ops.mesh.primitive_cube_add(size=0.8)
    return _with_sharp_edges(_made())


def _head() -> Any:
    bpy.ops.mesh.primitive_monkey_add(size=0.9)
    item = _made()
    item.modifiers.new("Subdivision", "SUBSURF").render_levels = 2
    return item


def _ribbon() -> Any:
    """A sheet with a thickness, bent: its rim is a narrow island."""
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=40, y_subdivisions=8, size=1)
    item = _made()
    for vertex in item.data.vertices:
        vertex.co.y *= 0.35
        vertex.co.z = 0.18 * sin(2.5 * pi * vertex.co.x)
    item.modifiers.new("Thickness", "SOLIDIFY").thickness = 0.05
    return item


_SHAPES: tuple[Callable[[], Any], ...] = (_ball, _ring, _tube, _cone, _box, _head, _ribbon)


def _with_sharp_edges(item: Any) -> Any:
    item.modifiers.new("Bevel", "BEVEL").width = 0.02
    item.data.set_sharp_from_angle(angle=0.6)
    return item


def _place(part: bpy.types.Object, before: list[bpy.types.Object], chance: np.random.Generator) -> None:
    """Turn a part, and stick it into one of those that are there `before` it."""
    part.rotation_euler = Euler(chance.uniform(-pi, pi, 3).tolist())
    size = float(chance.uniform(0.45, 1.0))
    part.scale = (size, size, size)
    if before:
        other = before[int(chance.integers(len(before)))]
        away = chance.normal(size=3)
        away /= np.linalg.norm(away)
        apart = 0.45 * (size + other.scale[0]) * float(chance.uniform(0.6, 0.95))
        part.location = other.location + Vector((apart * away).tolist())


def _dress(part: Any, chance: np.random.Generator) -> None:
    """Give a part a material of images, as a glTF file has it."""
    height = _height(chance)
    low, high = np.sort(chance.uniform(0.08, 0.75, 2))
    metal = (
        _noise(chance, 6) > 0.5 if chance.random() < 0.5 else np.full_like(height, chance.random() < 0.3)
    ) * 1.0
    roughness = low + (high - low) * (_height(chance) > 0.5) + 0.04 * (_noise(chance, 32) - 0.5)
    one, two = chance.uniform(0.03, 0.9, (2, 3))
    share = _height(chance)[..., None]
    colour = (one * share + two * (1 - share)) * (0.9 + 0.2 * _noise(chance, 64)[..., None])
    material = bpy.data.materials.new(part.name)
    if material.node_tree is None:  # Blender 4.5; later every material has one
        material.use_nodes = True
    tree: Any = material.node_tree
    principled = next(node for node in tree.nodes if node.type == "BSDF_PRINCIPLED")
    rough = np.stack([np.ones_like(height), np.clip(roughness, 0.05, 1), metal], axis=-1)
    texture = {
        "colour": image_texture(tree, f"{part.name} colour", np.clip(colour, 0, 1), "sRGB"),
        "rough": image_texture(tree, f"{part.name} roughness and metal", rough, "Non-Color"),
        "normal": image_texture(tree, f"{part.name} normal", _normals(height), "Non-Color"),
    }
    split, bumps = tree.nodes.new("ShaderNodeSeparateColor"), tree.nodes.new("ShaderNodeNormalMap")
    tree.links.new(texture["rough"].outputs["Color"], split.inputs[0])
    tree.links.new(texture["normal"].outputs["Color"], bumps.inputs["Color"])
    tree.links.new(texture["colour"].outputs["Color"], principled.inputs["Base Color"])
    tree.links.new(split.outputs["Green"], principled.inputs["Roughness"])
    tree.links.new(split.outputs["Blue"], principled.inputs["Metallic"])
    tree.links.new(bumps.outputs["Normal"], principled.inputs["Normal"])
    part.data.materials.clear()
    part.data.materials.append(material)


def image_texture(tree: Any, name: str, pixels: Image, space: str) -> Any:
    """A node of a packed image of `pixels` (H, W, 3 or 4) in its colour space, the lowest row first."""
    height, width, channels = pixels.shape
    image: Any = bpy.data.images.new(name, width, height, alpha=channels == 4)
    image.colorspace_settings.name = space
    whole = [pixels] if channels == 4 else [pixels, np.ones_like(pixels[..., :1])]
    rgba = np.concatenate(whole, axis=-1).astype(np.float32)
    image.pixels.foreach_set(rgba.ravel())
    image.pack()
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image = image
    return node


def _noise(chance: np.random.Generator, cells: int) -> Image:
    """Smooth noise in 0..1 that repeats at the image's edges, with `cells` along its side."""
    grid = chance.random((cells, cells))
    place = np.arange(PIXELS) / PIXELS * cells
    low = place.astype(int)
    part = place - low
    part = part * part * (3 - 2 * part)
    rows = grid[low] * (1 - part[:, None]) + grid[(low + 1) % cells] * part[:, None]
    found: Image = rows[:, low] * (1 - part) + rows[:, (low + 1) % cells] * part
    return found


def _height(chance: np.random.Generator) -> Image:
    """A pattern in 0..1: bands, tiles, spots or noise."""
    kind, count = int(chance.integers(4)), int(chance.integers(4, 14))
    turn = np.arange(PIXELS) / PIXELS * 2 * pi * count
    across, along = np.meshgrid(turn, turn)
    if kind == 0:
        wave = np.sin(across)
    elif kind == 1:
        wave = np.sin(across) * np.sin(along)
    elif kind == 2:
        wave = 2 * (np.cos(across) + np.cos(along) > 0.7) - 1.0
    else:
        return _noise(chance, count)
    found: Image = 0.5 + 0.5 * np.clip(3 * wave, -1, 1)
    return found


def _normals(height: Image) -> Image:
    """The normal map of a height, colours in 0..1."""
    slope = 6.0
    along = (np.roll(height, -1, axis=1) - np.roll(height, 1, axis=1)) * slope
    across = (np.roll(height, -1, axis=0) - np.roll(height, 1, axis=0)) * slope
    normal = np.stack([-along, -across, np.ones_like(height)], axis=-1)
    found: Image = 0.5 + 0.5 * normal / np.linalg.norm(normal, axis=-1, keepdims=True)
    return found


def _lay_floor(height: float, chance: np.random.Generator) -> None:
    bpy.ops.mesh.primitive_plane_add(size=8, location=(0, 0, height - 1e-3))
    floor: Any = bpy.context.object
    floor.name = "Floor"
    material = bpy.data.materials.new("Floor")
    if material.node_tree is None:
        material.use_nodes = True
    principled: Any = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    principled.inputs["Base Color"].default_value = (*chance.uniform(0.1, 0.6, 3).tolist(), 1)
    principled.inputs["Roughness"].default_value = float(chance.uniform(0.2, 0.7))
    floor.data.materials.append(material)


def _set_cameras(corners: npt.NDArray[np.float64], chance: np.random.Generator) -> None:
    middle = (corners.min(axis=0) + corners.max(axis=0)) / 2
    radius = float(np.linalg.norm(corners - middle, axis=1).max())
    first = float(chance.uniform(0, 2 * pi))
    for number in range(3):
        side, up = first + number * 2.2, float(chance.uniform(0.1, 0.6))
        away = Vector((cos(side) * cos(up), sin(side) * cos(up), sin(up)))
        data = bpy.data.cameras.new(f"view{number}")
        data.lens = _LENS
        camera = bpy.data.objects.new(f"view{number}", data)
        camera.location = Vector(middle.tolist()) + away * (2.4 * radius)
        camera.rotation_euler = away.to_track_quat("Z", "Y").to_euler()
        bpy.context.scene.collection.objects.link(camera)
