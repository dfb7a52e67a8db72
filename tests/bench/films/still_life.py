# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A still life in soft studio light: a glazed teapot, a copper kettle, a vase of lustre glass, fruit."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, pi, radians, sin
from typing import Any, cast

import bpy
import numpy as np
from mathutils import Vector

from ..fidelity.scenes.materials import assign, colour_by, patches, principled
from ..fidelity.scenes.meshes import (
    Faces,
    Points,
    Vertices,
    joined,
    lathe,
    made,
    mesh_object,
    smooth_curve,
)
from ..fidelity.scenes.stage import start

_AROUND = 96  # vertices around what is turned
_TUBE = 24  # and around a spout or a handle
_FLOOR_SIZE = 120.0

Place = tuple[float, float, float]

POTS = ("Teapot", "Vase", "Kettle")  # what is baked for the picture


@dataclass(frozen=True)
class Light:
    """An HDRI and its strength, and for the lamps to the left and to the right, their sides and watts.

    `paper` is the ground's grey; `metal`, `glaze` and `coat`, which lies on the glaze, are roughness.
    """

    hdri: str
    strength: float
    left: tuple[float, float, float]
    right: tuple[float, float, float]
    paper: float
    metal: float
    glaze: float
    coat: float


CRISP = Light("studio.exr", 0.45, (3.2, 4.0, 520), (1.4, 3.6, 320), 0.46, metal=0.3, glaze=0.4, coat=0.18)
SOFT = Light("city.exr", 0.26, (5.0, 5.0, 560), (3.0, 4.5, 330), 0.23, metal=0.33, glaze=0.5, coat=0.25)


def studio_light(light: Light) -> None:
    """Empty the open file; two wide lamps, and a little of an HDRI."""
    start(light.hdri, strength=light.strength, turn=20)
    scene = cast(Any, bpy.context.scene)
    scene.cycles.max_bounces = 6
    _lamp("Key", (-4.2, -2.2, 4.6), light.left, (1.0, 0.93, 0.84))
    _lamp("Rim", (4.0, 3.0, 3.4), light.right, (0.8, 0.9, 1.0))


def orbit_scene() -> bpy.types.Object:
    """The film's: the teapot, which is returned, and fruit near it."""
    studio_light(SOFT)
    bpy.ops.mesh.primitive_plane_add(size=_FLOOR_SIZE)
    assign(made(), _paper(SOFT))
    tangerine((1.3, -0.75, 0), 0.34)
    tangerine((-1.05, 0.95, 0), 0.3)
    tangerine((-0.55, 1.45, 0), 0.26)
    return teapot(SOFT, turn=-30)


def hero_scene() -> None:
    """The picture's: teapot, vase and kettle before a backdrop, and fruit."""
    studio_light(CRISP)
    _sweep(_paper(CRISP))
    teapot(CRISP, (0, 0, 0), turn=-28)
    vase(CRISP, (-1.75, 0.55, 0))
    kettle(CRISP, (1.75, -0.35, 0), turn=-24)
    tangerine((0.92, -1.15, 0), 0.33)
    tangerine((-1.0, -1.05, 0), 0.29)
    tangerine((2.75, 0.55, 0), 0.33)


def teapot(light: Light, place: Place = (0, 0, 0), turn: float = 0.0) -> bpy.types.Object:
    """A teapot of stoneware under a running glaze, from teal to amber, its spout towards +x."""
    body = np.array(
        [
            (0.05, 0.0), (0.4, 0.0), (0.47, 0.03), (0.66, 0.2), (0.84, 0.5), (0.86, 0.78), (0.72, 1.08),
            (0.48, 1.22), (0.4, 1.25), (0.41, 1.29), (0.44, 1.31), (0.4, 1.36), (0.26, 1.44), (0.12, 1.48),
            (0.09, 1.53), (0.14, 1.6), (0.15, 1.66), (0.1, 1.72), (0.03, 1.74),
        ]
    )  # fmt: skip
    spout = np.array([(0.62, 0.42), (0.96, 0.54), (1.14, 0.82), (1.24, 1.12), (1.4, 1.3), (1.46, 1.34)])
    handle = np.array(
        [(-0.6, 1.14), (-0.88, 1.3), (-1.2, 1.22), (-1.3, 0.9), (-1.16, 0.58), (-0.92, 0.42), (-0.7, 0.4)]
    )
    shapes = joined(
        lathe(smooth_curve(body), _AROUND, tip=0.005),
        tube(smooth_curve(spout), (0.25, 0.18, 0.13, 0.1, 0.08, 0.075, 0.035)),
        tube(smooth_curve(handle), (0.09, 0.09, 0.08, 0.075, 0.075, 0.075, 0.08)),
    )
    item = _placed(mesh_object("Teapot", *shapes, smooth=True), place, turn)
    glaze = principled(
        "Glaze", (0.1, 0.3, 0.3), Roughness=light.glaze, Coat_Weight=1.0, Coat_Roughness=light.coat
    )
    steps = (
        (0.0, (0.16, 0.065, 0.02)),
        (0.3, (0.012, 0.085, 0.1)),
        (0.62, (0.02, 0.2, 0.2)),
        (0.85, (0.3, 0.2, 0.07)),
        (1.0, (0.42, 0.2, 0.05)),
    )
    colour_by(glaze, _running(glaze, 1.74), steps)
    assign(item, glaze)
    return item


def vase(light: Light, place: Place = (0, 0, 0)) -> bpy.types.Object:
    """A slender vase of lustre glass: metal under a film whose colour turns with the view."""
    keys = np.array(
        [
            (0.05, 0.0), (0.3, 0.0), (0.36, 0.03), (0.44, 0.2), (0.62, 0.62), (0.66, 0.95), (0.52, 1.3),
            (0.27, 1.62), (0.19, 1.9), (0.2, 2.15), (0.3, 2.36), (0.36, 2.42), (0.33, 2.44), (0.24, 2.36),
            (0.14, 2.15), (0.13, 1.9), (0.13, 1.6), (0.05, 1.55),
        ]
    )  # fmt: skip
    item = _placed(mesh_object("Vase", *lathe(smooth_curve(keys), _AROUND, tip=0.0), smooth=True), place, 0)
    film = {"Thin_Film_Thickness": 430.0, "Thin_Film_IOR": 1.9}
    assign(item, principled("Lustre", (0.42, 0.4, 0.46), Metallic=1.0, Roughness=light.metal, **film))
    return item


def kettle(light: Light, place: Place = (0, 0, 0), turn: float = 0.0) -> bpy.types.Object:
    """A small pot of satin copper with a bail handle."""
    keys = np.array(
        [
            (0.05, 0.0), (0.5, 0.0), (0.58, 0.03), (0.62, 0.12), (0.6, 0.45), (0.5, 0.68), (0.36, 0.76),
            (0.33, 0.79), (0.34, 0.82), (0.28, 0.87), (0.12, 0.91), (0.06, 0.93), (0.05, 0.96), (0.1, 1.02),
            (0.09, 1.08), (0.02, 1.1),
        ]
    )  # fmt: skip
    angles = np.linspace(radians(-4), radians(184), 11)
    bail = np.stack([0.5 * np.cos(angles), 0.68 + 0.66 * np.sin(angles)], axis=1)
    spout = np.array([(0.48, 0.3), (0.74, 0.42), (0.84, 0.6), (0.96, 0.72)])
    shapes = joined(
        lathe(smooth_curve(keys), _AROUND, tip=0.004),
        tube(smooth_curve(spout), (0.14, 0.1, 0.07, 0.05, 0.02)),
        tube(smooth_curve(bail), (0.035,) * 11),
    )
    item = _placed(mesh_object("Kettle", *shapes, smooth=True), place, turn)
    assign(item, principled("Copper", (0.86, 0.42, 0.24), Metallic=1.0, Roughness=light.metal))
    return item


def tangerine(place: Place, radius: float = 0.36) -> bpy.types.Object:
    """A fruit, flattened a little."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=24, radius=radius)
    bpy.ops.object.shade_smooth()
    item = made()
    item.name = "Tangerine"
    item.scale = (1, 1, 0.88)
    item.location = (place[0], place[1], place[2] + 0.88 * radius)
    assign(item, principled("Peel", (0.9, 0.27, 0.02), Roughness=0.42))
    return item


def tube(path: Points, radii: tuple[float, ...]) -> tuple[Vertices, Faces]:
    """A pipe along a curve (P, 2) in the xz plane; radii at even steps along it, the ends closed."""
    along = np.gradient(path, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    radius = np.interp(np.linspace(0, 1, len(path)), np.linspace(0, 1, len(radii)), radii)
    vertices: Vertices = []
    for (x, z), (dx, dz), r in zip(path.tolist(), along.tolist(), radius.tolist(), strict=True):
        for k in range(_TUBE):
            a = 2 * pi * k / _TUBE
            vertices.append((x - dz * r * cos(a), r * sin(a), z + dx * r * cos(a)))
    faces: Faces = []
    for ring in range(len(path) - 1):
        for k in range(_TUBE):
            here, after = ring * _TUBE + k, ring * _TUBE + (k + 1) % _TUBE
            faces.append((here, here + _TUBE, after + _TUBE, after))
    last = (len(path) - 1) * _TUBE
    faces += [tuple(range(_TUBE)), tuple(last + k for k in reversed(range(_TUBE)))]
    return vertices, faces


def _running(material: bpy.types.Material, height: float) -> Any:
    """A socket that goes from 0 at an object's foot to 1 at `height`, as glaze runs."""
    tree = cast(Any, material.node_tree)
    split = tree.nodes.new("ShaderNodeSeparateXYZ")
    tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["Object"], split.inputs[0])
    scaled = tree.nodes.new("ShaderNodeMath")
    scaled.operation = "MULTIPLY_ADD"
    tree.links.new(split.outputs["Z"], scaled.inputs[0])
    scaled.inputs[1].default_value = 1 / height
    ragged = tree.nodes.new("ShaderNodeMath")
    ragged.operation = "MULTIPLY_ADD"
    tree.links.new(patches(tree), ragged.inputs[0])
    ragged.inputs[1].default_value, ragged.inputs[2].default_value = 0.5, -0.25
    tree.links.new(ragged.outputs[0], scaled.inputs[2])
    return scaled.outputs[0]


def _lamp(name: str, place: Place, shine: tuple[float, float, float], colour: Place) -> None:
    """A softbox that shines at the still life's middle."""
    data: Any = bpy.data.lights.new(name, "AREA")
    data.shape, data.size, data.size_y, data.energy, data.color = "RECTANGLE", *shine, colour
    item: Any = bpy.data.objects.new(name, data)
    item.location = place
    item.rotation_euler = (Vector(place) - Vector((0, 0, 0.7))).to_track_quat("Z", "Y").to_euler()
    cast(Any, bpy.context.scene).collection.objects.link(item)


def _placed(item: bpy.types.Object, place: Place, turn: float) -> bpy.types.Object:
    item.location, item.rotation_euler = place, (0, 0, radians(turn))
    return item


def _sweep(paper: bpy.types.Material, behind: float = 4.5, radius: float = 4.0, wide: float = 40.0) -> None:
    """A studio's backdrop: the floor bends up to a wall far behind, seen as one."""
    angles = np.linspace(0, pi / 2, 17)
    bend = np.stack([behind + radius * np.sin(angles), radius * (1 - np.cos(angles))], axis=1)
    curve = [(-30.0, 0.0), *bend.tolist(), (behind + radius, 16.0)]
    vertices = [(x, y, z) for y, z in curve for x in (-wide / 2, wide / 2)]
    faces: Faces = [(2 * k, 2 * k + 1, 2 * k + 3, 2 * k + 2) for k in range(len(curve) - 1)]
    assign(mesh_object("Backdrop", vertices, faces, smooth=True), paper)


def _paper(light: Light) -> bpy.types.Material:
    """A warm grey."""
    grey = light.paper
    return principled("Paper", (grey, 0.91 * grey, 0.826 * grey), Roughness=0.75)
