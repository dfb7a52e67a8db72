# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Seven scenes to measure bakes by, each with cameras to tune on and cameras that no choice is tuned on.

Everywhere a checkered floor lies close below the object and coloured things stand beside it, seen reflected
with parallax, under an HDRI that Blender ships.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import cos, pi, radians, sin
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np
import numpy.typing as npt
from mathutils import Vector

SUBJECT = "Subject"
PIXELS = 192  # of a picture's side

Points = npt.NDArray[np.float64]

_FILL = 0.8  # of the frame, by the object's longer side
_DISTANCE = 5.0  # of the cameras, from the object's middle


@dataclass(frozen=True)
class Stage:
    """A built scene: its name, the object to bake, and the cameras."""

    name: str
    subject: bpy.types.Object
    tuning: tuple[bpy.types.Object, ...]
    held_out: tuple[bpy.types.Object, ...]


def metal(roughness: float) -> Stage:
    """A gold head between two balls and a box."""
    _start("courtyard.exr", strength=0.9, turn=40)
    bpy.ops.mesh.primitive_monkey_add()
    head = _subject(_made())
    subdivision: Any = head.modifiers.new("Subdivision", "SUBSURF")
    subdivision.levels = subdivision.render_levels = 2
    bpy.ops.object.shade_smooth()
    _wear(head, _principled("Gold", (0.9, 0.6, 0.22), Metallic=1.0, Roughness=roughness))
    return _finish(f"metal_{round(100 * roughness):02d}", head)


def ceramic() -> Stage:
    """A lidded jar, dark blue waves on white under a clear coat, lit by the sky of a forest and a lamp."""
    _start("forest.exr", strength=0.8, turn=200)
    jar = _subject(_mesh_object("Jar", *_lathe(_jar_profile(), segments=88), smooth=True))
    glaze = _principled("Glaze", (0.8, 0.8, 0.8), Roughness=0.25, Coat_Weight=1.0, Coat_Roughness=0.08)
    _colour_by(glaze, _waves(glaze.node_tree), ((0.45, (0.012, 0.03, 0.17)), (0.5, (0.72, 0.73, 0.7))))
    _wear(jar, glaze)
    _lamp((1.8, -2.2, 2.8), size=0.6, watts=60)
    return _finish("ceramic", jar)


def textured() -> Stage:
    """A waxy blob of clear-cut patches."""
    _start("sunset.exr", strength=0.8, turn=120)
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=6)
    blob = _subject(_made())
    _displace(blob)
    bpy.ops.object.shade_smooth()
    wax = _principled(
        "Wax", (0.8, 0.8, 0.8), Roughness=0.6, Subsurface_Weight=0.2, Subsurface_Radius=(0.2, 0.1, 0.06)
    )
    patches = ((0.3, (0.75, 0.2, 0.08)), (0.42, (0.78, 0.68, 0.45)), (0.6, (0.08, 0.3, 0.33)))
    _colour_by(wax, _patches(wax.node_tree), patches)
    _wear(blob, wax)
    _lamp((-2.4, -1.8, 2.6), size=0.8, watts=70)
    return _finish("textured", blob)


def glass() -> Stage:
    """A clear pebble, in which everything behind it is seen upside down."""
    _start("interior.exr", strength=0.5, turn=100)
    bpy.ops.mesh.primitive_uv_sphere_add(segments=96, ring_count=48)
    pebble = _subject(_made())
    place = _places(pebble)
    place *= (1.0, 0.8, 0.85)
    place[:, 0] *= 1 + 0.22 * place[:, 2]
    place[:, 2] += 0.12 * place[:, 0] ** 2
    _move_to(pebble, place)
    bpy.ops.object.shade_smooth()
    clear = _principled("Glass", (0.98, 1, 0.99), Transmission_Weight=1.0, IOR=1.45, Roughness=0.03)
    _wear(pebble, clear)
    return _finish("glass", pebble)


def mechanical() -> Stage:
    """A gear of flat faces, its steel tempered to colours."""
    _start("city.exr", strength=0.55, turn=60)
    gear = _subject(_mesh_object("Gear", *_gear(), smooth=False))
    gear.rotation_euler = (radians(62), 0, radians(18))
    steel = _principled(
        "Steel",
        (0.62, 0.6, 0.58),
        Metallic=1.0,
        Roughness=0.15,
        Thin_Film_Thickness=400.0,
        Thin_Film_IOR=1.4,
    )
    _wear(gear, steel)
    return _finish("mechanical", gear)


SCENES: dict[str, Callable[[], Stage]] = {
    "metal_05": lambda: metal(0.05),
    "metal_20": lambda: metal(0.2),
    "metal_50": lambda: metal(0.5),
    "ceramic": ceramic,
    "textured": textured,
    "glass": glass,
    "mechanical": mechanical,
}


def _start(hdri: str, strength: float, turn: float) -> None:
    """Empty the open file; light it by an HDRI, turned by degrees about the vertical."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = cast(bpy.types.Scene, bpy.context.scene)
    cast(Any, scene.render).engine = "CYCLES"
    scene.render.resolution_x = scene.render.resolution_y = PIXELS
    scene.render.resolution_percentage = 100
    cycles = cast(Any, scene).cycles
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    folder: str = cast(Any, bpy.utils).system_resource("DATAFILES", path="studiolights/world")
    world = bpy.data.worlds.new("World")
    if world.node_tree is None:  # Blender 4.5; later every world has one
        world.use_nodes = True
    tree = world.node_tree
    background = next(node for node in tree.nodes if node.type == "BACKGROUND")
    environment = tree.nodes.new("ShaderNodeTexEnvironment")
    environment.image = bpy.data.images.load(str(Path(folder, hdri)))
    mapping = tree.nodes.new("ShaderNodeMapping")
    mapping.inputs["Rotation"].default_value = (0, 0, radians(turn))
    coordinates = tree.nodes.new("ShaderNodeTexCoord")
    tree.links.new(coordinates.outputs["Generated"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs["Vector"], environment.inputs["Vector"])
    tree.links.new(environment.outputs["Color"], background.inputs["Color"])
    background.inputs["Strength"].default_value = strength
    scene.world = world


def _finish(name: str, subject: bpy.types.Object) -> Stage:
    """Lay the floor, set the near things and the cameras about the subject."""
    corners = _world_corners(subject)
    floor = float(corners[:, 2].min()) - 0.06
    bpy.ops.mesh.primitive_plane_add(size=14, location=(0, 0, floor))
    _wear(_made(), _checker(tiles=28))
    _ball((95, 1.75), 0.42, floor, (0.75, 0.06, 0.05))
    _ball((-64, 1.85), 0.36, floor, (0.06, 0.2, 0.75))
    bpy.ops.mesh.primitive_cube_add(size=0.62, rotation=(0, 0, radians(25)))
    box = _made()
    box.location = (*_around(0, 1.85), floor + 0.31)
    _wear(box, _principled("Box", (0.1, 0.5, 0.12), Roughness=0.4))
    middle = Vector(((corners.min(axis=0) + corners.max(axis=0)) / 2).tolist())
    seen = [Vector(corner) for corner in corners.tolist()]
    cameras = [
        _camera(f"{kind} {index}", azimuth, elevation, middle, seen)
        for kind, views in (
            ("tuning", ((-32, 16), (152, 38))),
            ("held out", ((42, 30), (-112, 9))),
        )
        for index, (azimuth, elevation) in enumerate(views, 1)
    ]
    cast(bpy.types.Scene, bpy.context.scene).camera = cameras[0]
    return Stage(name, subject, tuple(cameras[:2]), tuple(cameras[2:]))


def _camera(
    name: str, azimuth: float, elevation: float, middle: Vector, seen: Sequence[Vector]
) -> bpy.types.Object:
    """A camera that looks at the points from an azimuth (degrees from -Y) and elevation, filled by them."""
    away = Vector((*_around(azimuth, cos(radians(elevation))), sin(radians(elevation))))
    place = middle + away * _DISTANCE
    aim = middle
    half = 1.0
    for _ in range(4):  # each aim turns the frame a little
        rotation = (aim - place).to_track_quat("-Z", "Y")
        local = [rotation.inverted() @ (point - place) for point in seen]
        across = [(point.x / -point.z, point.y / -point.z) for point in local]
        low, high = np.min(across, axis=0), np.max(across, axis=0)
        half = float(max(high - low)) / 2
        centre = (low + high) / 2
        aim = place + rotation @ Vector((float(centre[0]), float(centre[1]), -1.0))
    data = bpy.data.cameras.new(name)
    data.sensor_width = 36
    data.lens = 18 * _FILL / half
    camera = bpy.data.objects.new(name, data)
    camera.location = place
    camera.rotation_euler = (aim - place).to_track_quat("-Z", "Y").to_euler()
    _link(camera)
    return camera


def _world_corners(subject: bpy.types.Object) -> Points:
    """The evaluated mesh's vertices in world space, (V, 3)."""
    graph = bpy.context.evaluated_depsgraph_get()
    evaluated = subject.evaluated_get(graph)
    place = _places(evaluated)
    matrix = np.array(evaluated.matrix_world)
    moved: Points = place @ matrix[:3, :3].T + matrix[:3, 3]
    return moved


def _places(item: bpy.types.Object) -> Points:
    mesh = cast(bpy.types.Mesh, item.data)
    place = np.empty(3 * len(mesh.vertices))
    mesh.vertices.foreach_get("co", place)
    return place.reshape(-1, 3)


def _move_to(item: bpy.types.Object, place: Points) -> None:
    mesh = cast(bpy.types.Mesh, item.data)
    mesh.vertices.foreach_set("co", place.ravel())
    mesh.update()


def _displace(blob: bpy.types.Object) -> None:
    """Bulge a unit sphere smoothly."""
    place = _places(blob)
    x, y, z = place.T
    bulge = 0.12 * np.sin(2.4 * x + 1) * np.cos(2.1 * y) + 0.1 * np.sin(3.3 * z + 1.7 * x)
    bulge += 0.05 * np.sin(5 * y + 2 * z) * np.cos(4 * x)
    _move_to(blob, place * (1 + bulge)[:, None])


def _made() -> bpy.types.Object:
    """What the last operator added."""
    return cast(bpy.types.Object, bpy.context.object)


def _subject(item: bpy.types.Object) -> bpy.types.Object:
    item.name = SUBJECT
    return item


def _mesh_object(
    name: str, vertices: list[tuple[float, float, float]], faces: list[tuple[int, ...]], smooth: bool
) -> bpy.types.Object:
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(vertices, [], faces)
    mesh.polygons.foreach_set("use_smooth", [smooth] * len(faces))
    mesh.update()
    item = bpy.data.objects.new(name, mesh)
    _link(item)
    return item


def _jar_profile() -> Points:
    """Radius and height from the foot's middle to the knob's top, (P, 2), as a smooth curve of key points."""
    keys = np.array(
        [
            (0.3, -1.0), (0.46, -1.0), (0.5, -0.95), (0.56, -0.75), (0.82, -0.3), (0.93, 0.1), (0.8, 0.42),
            (0.5, 0.56), (0.44, 0.62), (0.53, 0.67), (0.5, 0.74), (0.26, 0.84), (0.1, 0.88), (0.13, 0.97),
            (0.07, 1.05),
        ]
    )  # fmt: skip
    padded = np.concatenate([keys[:1], keys, keys[-1:]])
    points = [_catmull_rom(padded[k : k + 4], t) for k in range(len(keys) - 1) for t in (0.0, 1 / 3, 2 / 3)]
    return np.array([*points, keys[-1]])


def _catmull_rom(keys: Points, t: float) -> Points:
    """The place at t in [0, 1] between the middle two of four keys, (4, D)."""
    before, start, end, after = keys
    linear = (end - before) * t
    square = (2 * before - 5 * start + 4 * end - after) * t**2
    place: Points = (2 * start + linear + square + (3 * start - before - 3 * end + after) * t**3) / 2
    return place


def _lathe(profile: Points, segments: int) -> tuple[list[tuple[float, float, float]], list[tuple[int, ...]]]:
    """Turn a profile of (radius, height) about z; both ends are closed by a point on the axis."""
    angles = [2 * pi * k / segments for k in range(segments)]
    vertices = [(r * cos(a), r * sin(a), z) for r, z in profile.tolist() for a in angles]
    faces: list[tuple[int, ...]] = []
    for ring in range(len(profile) - 1):
        for k in range(segments):
            a, b = ring * segments + k, ring * segments + (k + 1) % segments
            faces.append((a, b, b + segments, a + segments))
    foot, top = len(vertices), len(vertices) + 1
    vertices += [(0, 0, float(profile[0, 1])), (0, 0, float(profile[-1, 1]) + 0.025)]
    last = (len(profile) - 1) * segments
    for k in range(segments):
        after = (k + 1) % segments
        faces += [(foot, after, k), (top, last + k, last + after)]
    return vertices, faces


def _gear(teeth: int = 14) -> tuple[list[tuple[float, float, float]], list[tuple[int, ...]]]:
    """A gear with a hole, a raised hub and a sunk web, its axis along z."""
    count = 4 * teeth
    section = (  # radius and height around the gear's cross-section; 0 is the toothed contour
        (0.2, 0.32), (0.4, 0.32), (0.4, 0.1), (0.68, 0.1), (0.68, 0.22), (0, 0.22),
        (0, -0.22), (0.68, -0.22), (0.68, -0.1), (0.4, -0.1), (0.4, -0.32), (0.2, -0.32),
    )  # fmt: skip
    vertices = []
    for radius, z in section:
        for k in range(count):
            angle = 2 * pi * k / count
            r = radius or (1.0 if k % 4 < 2 else 0.82)
            vertices.append((r * cos(angle), r * sin(angle), z))
    faces: list[tuple[int, ...]] = []
    for ring in range(len(section)):
        above = (ring + 1) % len(section)
        for k in range(count):
            after = (k + 1) % count
            faces.append((ring * count + k, above * count + k, above * count + after, ring * count + after))
    return vertices, faces


def _around(azimuth: float, distance: float) -> tuple[float, float]:
    """A place on the ground, its azimuth in degrees from -Y towards +X."""
    return sin(radians(azimuth)) * distance, -cos(radians(azimuth)) * distance


def _ball(
    where: tuple[float, float], radius: float, floor: float, colour: tuple[float, float, float]
) -> None:
    bpy.ops.mesh.primitive_uv_sphere_add(
        segments=48, ring_count=24, radius=radius, location=(*_around(*where), floor + radius)
    )
    bpy.ops.object.shade_smooth()
    _wear(_made(), _principled("Ball", colour, Roughness=0.35))


def _lamp(place: tuple[float, float, float], size: float, watts: float) -> None:
    data = cast(bpy.types.AreaLight, bpy.data.lights.new("Lamp", "AREA"))
    data.size, data.energy = size, watts
    lamp = bpy.data.objects.new("Lamp", data)
    lamp.location = place
    lamp.rotation_euler = (-Vector(place)).to_track_quat("-Z", "Y").to_euler()
    _link(lamp)


def _link(item: bpy.types.Object) -> None:
    cast(bpy.types.Scene, bpy.context.scene).collection.objects.link(item)


def _wear(item: bpy.types.Object, material: bpy.types.Material) -> None:
    cast(bpy.types.Mesh, item.data).materials.append(material)


def _principled(name: str, colour: tuple[float, float, float], **inputs: object) -> bpy.types.Material:
    """A material of one Principled shader; inputs by name, blanks as underscores."""
    material = bpy.data.materials.new(name)
    if material.node_tree is None:
        material.use_nodes = True
    shader = _shader(material)
    shader.inputs["Base Color"].default_value = (*colour, 1)
    for key, value in inputs.items():
        shader.inputs[key.replace("_", " ")].default_value = value
    return material


def _shader(material: bpy.types.Material) -> Any:
    return next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")


def _checker(tiles: float) -> bpy.types.Material:
    material = _principled("Checker", (0.4, 0.4, 0.4), Roughness=0.6)
    tree: Any = material.node_tree
    checker = tree.nodes.new("ShaderNodeTexChecker")
    checker.inputs["Color1"].default_value = (0.5, 0.49, 0.46, 1)
    checker.inputs["Color2"].default_value = (0.1, 0.1, 0.12, 1)
    checker.inputs["Scale"].default_value = tiles
    coordinates = tree.nodes.new("ShaderNodeTexCoord")
    tree.links.new(coordinates.outputs["UV"], checker.inputs["Vector"])
    tree.links.new(checker.outputs["Color"], _shader(material).inputs["Base Color"])
    return material


def _waves(tree: Any) -> Any:
    wave = tree.nodes.new("ShaderNodeTexWave")
    wave.bands_direction = "Z"
    for key, value in (("Scale", 0.9), ("Distortion", 6.0), ("Detail", 1.0), ("Detail Scale", 1.6)):
        wave.inputs[key].default_value = value
    tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["Object"], wave.inputs["Vector"])
    return wave.outputs["Fac"]


def _patches(tree: Any) -> Any:
    noise = tree.nodes.new("ShaderNodeTexNoise")
    for key, value in (("Scale", 2.2), ("Detail", 1.5), ("Distortion", 0.8)):
        noise.inputs[key].default_value = value
    tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["Object"], noise.inputs["Vector"])
    return noise.outputs[0]


def _colour_by(
    material: bpy.types.Material, value: Any, steps: Sequence[tuple[float, tuple[float, float, float]]]
) -> None:
    """Colour a material by a value, in steps with clear edges: the colour from each position on."""
    tree: Any = material.node_tree
    ramp = tree.nodes.new("ShaderNodeValToRGB")
    ramp.color_ramp.interpolation = "CONSTANT"
    elements = ramp.color_ramp.elements
    while len(elements) < len(steps):
        elements.new(0.5)
    for element, (position, colour) in zip(elements, ((0.0, steps[0][1]), *steps[1:]), strict=True):
        element.position, element.color = position, (*colour, 1)
    tree.links.new(value, ramp.inputs["Fac"])
    tree.links.new(ramp.outputs["Color"], _shader(material).inputs["Base Color"])
