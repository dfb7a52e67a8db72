# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What rooms are built of: walls with holes, boxes, turned profiles, their materials, sky, sun and cameras.

Lengths are metres, z is up, and a room stands on z = 0.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from math import radians
from typing import Any, TypeAlias, cast

import bmesh
import bpy
import numpy as np
from mathutils import Euler, Vector

from ..assets.drawn import Image, image_texture
from ..fidelity.scenes.materials import assign, connect, principled, shader
from ..fidelity.scenes.meshes import Faces, Vertices, joined, lathe, link, mesh_object

Place: TypeAlias = tuple[float, float, float]
Box: TypeAlias = tuple[Place, Place]  # its lowest and its highest corner
Hole: TypeAlias = tuple[float, float, float, float]  # from, to along the wall; from, to in height
Colour: TypeAlias = tuple[float, float, float]

THICKNESS = 0.15  # of walls
_SUN_ANGLE = radians(0.53)
_SEGMENTS = 48  # around a turned profile
_FILLED = 0.9  # of a box's UV square, by its largest face


def start() -> None:
    """Empty the open file, for Cycles with Blender's own settings."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    cast(Any, bpy.context.scene).render.engine = "CYCLES"


def light_outside(
    towards: Place, sun: float, sky: float, ground: Colour = (0.22, 0.24, 0.18), warm: Colour = (1, 0.9, 0.76)
) -> None:
    """A sky that is white at the horizon and blue above, over a ground, and a sun that shines `towards`.

    `sun` is its irradiance, `sky` the radiance of the horizon.
    """
    scene: Any = bpy.context.scene
    world: Any = bpy.data.worlds.new("Sky")
    if world.node_tree is None:  # Blender 4.5; later every world has one
        world.use_nodes = True
    tree = world.node_tree
    background = next(node for node in tree.nodes if node.type == "BACKGROUND")
    ramp, split = tree.nodes.new("ShaderNodeValToRGB"), tree.nodes.new("ShaderNodeSeparateXYZ")
    span = tree.nodes.new("ShaderNodeMapRange")
    span.inputs["From Min"].default_value = -1
    elements = ramp.color_ramp.elements
    elements[0].position, elements[0].color = 0.485, (*ground, 1)
    elements[1].position, elements[1].color = 0.515, (0.92, 0.95, 1.0, 1)
    zenith = elements.new(0.85)
    zenith.color = (0.28, 0.48, 0.9, 1)
    coordinates = tree.nodes.new("ShaderNodeTexCoord")
    tree.links.new(coordinates.outputs["Generated"], split.inputs["Vector"])
    tree.links.new(split.outputs["Z"], span.inputs["Value"])
    tree.links.new(span.outputs["Result"], ramp.inputs["Fac"])
    tree.links.new(ramp.outputs["Color"], background.inputs["Color"])
    background.inputs["Strength"].default_value = sky
    scene.world = world
    lamp: Any = bpy.data.lights.new("Sun", "SUN")
    lamp.energy, lamp.angle, lamp.color = sun, _SUN_ANGLE, warm
    item = bpy.data.objects.new("Sun", lamp)
    item.rotation_euler = Vector(towards).to_track_quat("-Z", "Y").to_euler()
    link(item)


def spot(name: str, place: Place, target: Place, watts: float, degrees: float, radius: float = 0.03) -> None:
    """A spot lamp of a warm white."""
    lamp: Any = bpy.data.lights.new(name, "SPOT")
    lamp.energy, lamp.spot_size, lamp.spot_blend = watts, radians(degrees), 0.4
    lamp.shadow_soft_size, lamp.color = radius, (1, 0.86, 0.68)
    item = bpy.data.objects.new(name, lamp)
    item.location = place
    item.rotation_euler = (Vector(target) - Vector(place)).to_track_quat("-Z", "Y").to_euler()
    link(item)


def cameras(views: Sequence[tuple[Place, Place]], degrees: float) -> None:
    """Add view0, view1 and so on, each from a place towards another, heads level, of one angle of view."""
    scene: Any = bpy.context.scene
    for number, (place, target) in enumerate(views):
        data: Any = bpy.data.cameras.new(f"view{number}")
        data.sensor_fit, data.angle, data.clip_start = "HORIZONTAL", radians(degrees), 0.01
        item = bpy.data.objects.new(data.name, data)
        item.location = place
        item.rotation_euler = (Vector(place) - Vector(target)).to_track_quat("Z", "Y").to_euler()
        link(item)
        scene.camera = scene.camera or item


def wall(
    name: str,
    start_at: tuple[float, float],
    end: tuple[float, float],
    height: float,
    holes: Sequence[Hole] = (),
) -> Any:
    """A wall from one corner to another, whose room lies to the left of that way; THICKNESS to the right.

    Holes go through it.
    """
    first, last = Vector((*start_at, 0)), Vector((*end, 0))
    along = (last - first).normalized()
    outwards = Vector((along.y, -along.x, 0)) * THICKNESS
    ways = sorted({0.0, (last - first).length, *(side for hole in holes for side in hole[:2])})
    heights = sorted({0.0, height, *(side for hole in holes for side in hole[2:])})
    corners = [first + along * way + outwards * layer for layer in (0, 1) for way in ways]
    vertices: Vertices = [(corner.x, corner.y, up) for corner in corners for up in heights]
    item: Any = mesh_object(name, vertices, _wall_faces(ways, heights, holes), smooth=False)
    _remove_loose_vertices(item)
    return item


def _wall_faces(ways: list[float], heights: list[float], holes: Sequence[Hole]) -> Faces:
    """The faces of a grid of boxes without those in holes; vertices by layer, then way, then height."""

    def filled(i: int, k: int) -> bool:
        if not (0 <= i < len(ways) - 1 and 0 <= k < len(heights) - 1):
            return False
        way, up = (ways[i] + ways[i + 1]) / 2, (heights[k] + heights[k + 1]) / 2
        return not any(a < way < b and c < up < d for a, b, c, d in holes)

    faces: Faces = []
    for i, k in np.ndindex(len(ways) - 1, len(heights) - 1):
        if not filled(i, k):
            continue
        corners = ((i, k), (i, k + 1), (i + 1, k + 1), (i + 1, k))
        inner = [a * len(heights) + b for a, b in corners]
        outer = [index + len(ways) * len(heights) for index in inner]
        faces += [tuple(inner), tuple(outer[::-1])]
        for side, beside in enumerate(((i - 1, k), (i, k + 1), (i + 1, k), (i, k - 1))):
            if not filled(*beside):
                a, b = side, (side + 1) % 4
                faces.append((inner[b], inner[a], outer[a], outer[b]))
    return faces


def _remove_loose_vertices(item: Any) -> None:
    """Drop a mesh's vertices that no face has."""
    used = {index for face in item.data.polygons for index in face.vertices}
    changed = bmesh.new()
    changed.from_mesh(item.data)
    bmesh.ops.delete(changed, geom=[one for one in changed.verts if one.index not in used], context="VERTS")
    changed.to_mesh(item.data)
    changed.free()


def shell(width: float, depth: float, height: float, holes: Mapping[str, Sequence[Hole]]) -> dict[str, Any]:
    """Floor, Ceiling and walls North, East, South, West (y up is north) of a room about the origin, by name.

    The holes of a wall are told from its left corner, as one sees it from inside.
    """
    x, y, more = width / 2, depth / 2, THICKNESS
    ways = {  # northern and southern walls cover the others' ends
        "South": ((-x - more, -y), (x + more, -y)),
        "East": ((x, -y), (x, y)),
        "North": ((x + more, y), (-x - more, y)),
        "West": ((-x, y), (-x, -y)),
    }
    found = {
        "Floor": boxes("Floor", ((-x - more, -y - more, -0.1), (x + more, y + more, 0.0))),
        "Ceiling": boxes("Ceiling", ((-x - more, -y - more, height), (x + more, y + more, height + 0.1))),
    }
    for name, (begin, end) in ways.items():
        long = float(np.hypot(end[0] - begin[0], end[1] - begin[1]))
        beyond = more if name in {"North", "South"} else 0.0
        turned_round = [(long - beyond - b, long - beyond - a, c, d) for a, b, c, d in holes.get(name, ())]
        found[name] = wall(f"Wall {name}", begin, end, height, turned_round)
    return found


def boxes(name: str, *parts: Box, bevel: float = 0.0, segments: int = 2) -> Any:
    """One object of boxes, their edges rounded by a bevel's width."""
    item: Any = mesh_object(name, *joined(*(_box(*part) for part in parts)), smooth=False)
    if bevel:
        round_off(item, bevel, segments)
    return item


def painted(item: Any, *materials: tuple[bpy.types.Material, int]) -> Any:
    """An object of `boxes`, so many of them of each material in turn; the object."""
    numbers = np.repeat(np.arange(len(materials)), [6 * count for _, count in materials])
    for material, _ in materials:
        assign(item, material)
    item.data.polygons.foreach_set("material_index", numbers.astype(np.int32))
    return item


def round_off(item: Any, width: float, segments: int = 2) -> None:
    """Round an object's edges by a modifier."""
    rounding = item.modifiers.new("Bevel", "BEVEL")
    rounding.width, rounding.segments, rounding.limit_method = width, segments, "ANGLE"
    rounding.harden_normals = True
    for face in item.data.polygons:
        face.use_smooth = True


def _box(low: Place, high: Place) -> tuple[Vertices, Faces]:
    vertices = [(x, y, z) for z in (low[2], high[2]) for y in (low[1], high[1]) for x in (low[0], high[0])]
    faces: Faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (1, 3, 7, 5), (3, 2, 6, 7), (2, 0, 4, 6)]
    return vertices, faces


def unfold(item: Any, face: int) -> None:
    """Give a box UVs: one face has most of the square, upright as the box stands; the others lie above it."""
    layer = item.data.uv_layers.new(name="UVMap")
    others = [polygon for polygon in item.data.polygons if polygon.index != face]
    spots = {polygon.index: (0.2 * number + 0.01, _FILLED + 0.01) for number, polygon in enumerate(others)}
    for polygon in item.data.polygons:
        corners = np.array([item.data.vertices[index].co for index in polygon.vertices])
        normal = polygon.normal
        right = Vector((0, 0, 1)).cross(normal) if abs(normal.z) < 0.5 else Vector((1, 0, 0))
        up = normal.cross(right)
        flat = np.stack([corners @ np.array(right), corners @ np.array(up)], axis=1)
        unit = (flat - flat.min(axis=0)) / np.ptp(flat, axis=0)
        low, size = ((0, 0), (1, _FILLED)) if polygon.index == face else (spots[polygon.index], (0.18, 0.08))
        for loop, uv in zip(polygon.loop_indices, unit * size + low, strict=True):
            layer.data[loop].uv = uv.tolist()


def turned(name: str, profile: Sequence[tuple[float, float]], place: Place, tip: float = 0.0) -> Any:
    """A profile of (radius, height) turned about the vertical, at a place."""
    item: Any = mesh_object(name, *lathe(np.array(profile), _SEGMENTS, tip), smooth=True)
    item.location = place
    item.data.set_sharp_from_angle(angle=radians(50))
    return item


def ball(name: str, radius: float, place: Place) -> Any:
    """A smooth ball about a place."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, radius=radius, location=place)
    item: Any = bpy.context.object
    item.name = item.data.name = name
    item.data.polygons.foreach_set("use_smooth", [True] * len(item.data.polygons))
    return item


def place(item: Any, where: Place, turn: float = 0.0) -> Any:
    """Move an object to a place, turned about the vertical by degrees; the object."""
    item.location, item.rotation_euler = where, Euler((0, 0, radians(turn)))
    return item


def dressed(item: Any, *materials: bpy.types.Material) -> Any:
    """The object, with these materials in its slots."""
    for material in materials:
        assign(item, material)
    return item


def plain(name: str, colour: Colour, roughness: float, **inputs: object) -> bpy.types.Material:
    """A material of one colour and roughness."""
    return principled(name, colour, Roughness=roughness, **inputs)


def pictured(name: str, pixels: Image, roughness: float, **inputs: object) -> bpy.types.Material:
    """A material coloured by an image (H, W, 3 or 4) of sRGB values, the lowest row first.

    A fourth channel is its alpha.
    """
    material = principled(name, (1, 1, 1), Roughness=roughness, **inputs)
    texture = image_texture(material.node_tree, name, pixels, "sRGB")
    connect(material, "Base Color", texture.outputs["Color"])
    if pixels.shape[2] == 4:
        connect(material, "Alpha", texture.outputs["Alpha"])
    return material


def fabric(name: str, colour: Colour, scale: float = 60.0) -> bpy.types.Material:
    """A rough cloth whose colour varies by noise over the object."""
    material = principled(name, colour, Roughness=0.85, Sheen_Weight=0.15)
    dark: Colour = cast(Colour, tuple(0.72 * value for value in colour))
    _between(material, _noise(material, (scale, scale, scale), 3.0), dark, colour, (0.35, 0.65))
    return material


def wood(
    name: str, dark: Colour, light: Colour, roughness: float, along: Place = (1, 9, 9)
) -> bpy.types.Material:
    """Wood whose grain runs along the axis of the smallest of three scales, from noise over the object."""
    material = principled(name, light, Roughness=roughness)
    scales: Place = cast(Place, tuple(2.2 * value for value in along))
    _between(material, _noise(material, scales, 4.0), dark, light, (0.3, 0.7))
    return material


def glowing(name: str, colour: Colour, radiance: float) -> bpy.types.Material:
    """A material that emits light, and reflects little."""
    return principled(name, (0.8, 0.8, 0.8), Emission_Color=(*colour, 1), Emission_Strength=radiance)


def _noise(material: bpy.types.Material, scales: Place, detail: float) -> Any:
    """A socket of noise over the object, at other scales along each axis."""
    tree: Any = material.node_tree
    noise, mapping = tree.nodes.new("ShaderNodeTexNoise"), tree.nodes.new("ShaderNodeMapping")
    mapping.inputs["Scale"].default_value = scales
    noise.inputs["Scale"].default_value, noise.inputs["Detail"].default_value = 1.0, detail
    coordinates = tree.nodes.new("ShaderNodeTexCoord")
    tree.links.new(coordinates.outputs["Object"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs["Vector"], noise.inputs["Vector"])
    return noise.outputs[0]


def _between(
    material: bpy.types.Material, value: Any, low: Colour, high: Colour, span: tuple[float, float]
) -> None:
    """Colour a material between two colours by a value from one to the other of `span`."""
    tree: Any = material.node_tree
    ramp = tree.nodes.new("ShaderNodeValToRGB")
    for element, position, colour in zip(ramp.color_ramp.elements, span, (low, high), strict=True):
        element.position, element.color = position, (*colour, 1)
    tree.links.new(value, ramp.inputs["Fac"])
    tree.links.new(ramp.outputs["Color"], shader(material).inputs["Base Color"])


def noise_image(chance: np.random.Generator, shape: tuple[int, int], cells: tuple[int, int]) -> Image:
    """Smooth noise in 0..1 of a shape (H, W), with so many cells along its height and width."""
    grid = chance.random((cells[0] + 1, cells[1] + 1))
    sides = []
    for count, cell in zip(shape, cells, strict=True):
        where = (np.arange(count) + 0.5) / count * cell
        low = where.astype(int)
        part = where - low
        sides.append((low, part * part * (3 - 2 * part)))
    (row, down), (column, right) = sides
    rows = grid[row] * (1 - down[:, None]) + grid[row + 1] * down[:, None]
    found: Image = rows[:, column] * (1 - right) + rows[:, column + 1] * right
    return found


def parquet(chance: np.random.Generator, size: tuple[float, float], plank: tuple[float, float]) -> Image:
    """Planks (H, W, 3) of a length and width along x, over a floor of `size`, 400 pixels a metre."""
    width, height = (round(400 * side) for side in size)
    grain = 0.5 * noise_image(chance, (height, width), (height // 4, max(width // 120, 1)))
    grain += 0.5 * noise_image(chance, (height, width), (height // 10, max(width // 300, 1)))
    y, x = np.meshgrid((np.arange(height) + 0.5) / 400, (np.arange(width) + 0.5) / 400, indexing="ij")
    row = (y / plank[1]).astype(int)
    shift = chance.random(row.max() + 1) * plank[0]
    moved = x + shift[row]
    number = (moved / plank[0]).astype(int)
    tone = chance.random((row.max() + 1, number.max() + 1))[row, number]
    dark, light = np.array([0.42, 0.27, 0.16]), np.array([0.72, 0.53, 0.35])
    share = np.clip(0.15 + 0.55 * tone + 0.55 * (grain - 0.5), 0, 1)[..., None]
    apart = np.minimum(
        np.minimum(y % plank[1], plank[1] - y % plank[1]),
        np.minimum(moved % plank[0], plank[0] - moved % plank[0]),
    )
    joint = np.where(apart < 0.0016, 0.45, 1.0)[..., None]
    planks: Image = (dark + (light - dark) * share) * joint
    return planks


def painting(chance: np.random.Generator, shape: tuple[int, int]) -> Image:
    """An abstract picture (H, W, 3): soft fields of colour, some bands and discs, and a painter's grain."""
    height, width = shape
    y, x = np.meshgrid(np.linspace(0, 1, height), np.linspace(0, 1, width), indexing="ij")
    one, two, three = _muted(chance.uniform(0.1, 0.95, (3, 3)))
    share = noise_image(chance, shape, (4, 3))[..., None]
    found = one * share + two * (1 - share)
    for _ in range(int(chance.integers(2, 6))):
        colour, at = _muted(chance.uniform(0.05, 1, 3)), chance.uniform(0.15, 0.85, 2)
        size = chance.uniform(0.05, 0.25)
        inside = np.hypot((x - at[0]) * width / height, y - at[1]) < size
        found = np.where(inside[..., None], 0.25 * found + 0.75 * colour, found)
    for level in chance.uniform(0.1, 0.9, int(chance.integers(1, 4))):
        found = np.where((np.abs(y - level) < chance.uniform(0.01, 0.06))[..., None], three, found)
    grain = noise_image(chance, shape, (height // 3, width // 3))[..., None]
    painted_over: Image = np.clip(found * (0.88 + 0.24 * grain), 0, 1)
    return painted_over


def _muted(colours: Image) -> Image:
    """Colours (..., 3) half way to grey."""
    found: Image = 0.5 * colours + 0.5 * colours.mean(axis=-1, keepdims=True)
    return found


def framed(name: str, wide: float, high: float, picture: Image, frame: bpy.types.Material) -> Any:
    """A picture in a frame that hangs towards -y, its middle at the origin: an object of two materials."""
    rim, deep = 0.035, 0.03
    x, z = wide / 2, high / 2
    parts: list[Box] = [
        ((-x, -0.018, -z), (x, 0.0, z)),
        ((-x - rim, -deep, -z - rim), (-x, 0.0, z + rim)),
        ((x, -deep, -z - rim), (x + rim, 0.0, z + rim)),
        ((-x, -deep, z), (x, 0.0, z + rim)),
        ((-x, -deep, -z - rim), (x, 0.0, -z)),
    ]
    item = boxes(name, *parts)
    layer = item.data.uv_layers.new(name="UVMap")
    for face in item.data.polygons:
        face.material_index = int(face.index >= 6)
        for loop in face.loop_indices:
            co = item.data.vertices[item.data.loops[loop].vertex_index].co
            layer.data[loop].uv = ((co.x + x) / wide, (co.z + z) / high) if face.index == 2 else (0.0, 0.0)
    return dressed(item, pictured(name, picture, 0.35), frame)


def text(name: str, letters: str, size: float, depth: float) -> Any:
    """Letters that stand towards -y, a text object."""
    curve: Any = bpy.data.curves.new(name, "FONT")
    curve.body, curve.size, curve.extrude, curve.align_x = letters, size, depth, "CENTER"
    curve.bevel_depth = 0.002
    item = bpy.data.objects.new(name, curve)
    item.rotation_euler = (radians(90), 0, 0)
    link(item)
    return item


def cord(name: str, places: Sequence[Place], radius: float) -> Any:
    """A round cord through places, a curve object."""
    curve: Any = bpy.data.curves.new(name, "CURVE")
    curve.dimensions, curve.bevel_depth, curve.bevel_resolution = "3D", radius, 2
    line = curve.splines.new("BEZIER")
    line.bezier_points.add(len(places) - 1)
    for point, where in zip(line.bezier_points, places, strict=True):
        point.co = where
        point.handle_left_type = point.handle_right_type = "AUTO"
    item = bpy.data.objects.new(name, curve)
    link(item)
    return item


def skirting(
    name: str, corners: Sequence[tuple[float, float]], gaps: Sequence[Box], high: float = 0.08
) -> Any:
    """Boards along a closed way of corners, the room to their left; none where boxes of `gaps` are."""
    deep = 0.016
    parts: list[Box] = []
    for (x, y), (to_x, to_y) in pairwise([*corners, corners[0]]):
        along = np.sign([to_x - x, to_y - y])
        inwards = np.array([-along[1], along[0]]) * deep
        ends = np.array([(x, y), (to_x, to_y)])
        for begin, end in _between_gaps(ends, gaps):
            points = np.array([begin, end, begin + inwards, end + inwards])
            low, top = points.min(axis=0), points.max(axis=0)
            parts.append(((low[0], low[1], 0.0), (top[0], top[1], high)))
    return boxes(name, *parts)


def _between_gaps(ends: Image, gaps: Sequence[Box]) -> list[tuple[Image, Image]]:
    length = float(np.abs(ends[1] - ends[0]).sum())
    along = (ends[1] - ends[0]) / length
    cuts = []
    for low, high in gaps:
        corners = np.array([low[:2], high[:2]]) - ends[0]
        across = corners @ np.array([-along[1], along[0]])
        if across.min() < 0.05 and across.max() > -0.05:
            cuts.append(sorted((corners @ along).tolist()))
    at, found = 0.0, []
    for begin, end in sorted(cuts):
        if end < 0 or begin > length:
            continue
        found.append((ends[0] + along * at, ends[0] + along * max(begin, at)))
        at = end
    found.append((ends[0] + along * at, ends[1]))
    return [(begin, end) for begin, end in found if np.abs(end - begin).sum() > 1e-6]
