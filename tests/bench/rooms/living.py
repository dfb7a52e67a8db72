# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A furnished living room of 5.2 x 4.2 x 2.7 m: a window with sun and sky, glossy parquet, a wall mirror."""

from __future__ import annotations

from math import cos, pi, radians, sin
from typing import Any

import numpy as np

from ..assets.drawn import Image
from ..fidelity.scenes.meshes import Faces, Vertices, mesh_object
from .building import (
    Box,
    Colour,
    ball,
    boxes,
    cameras,
    cord,
    dressed,
    fabric,
    framed,
    glowing,
    light_outside,
    noise_image,
    painted,
    painting,
    parquet,
    pictured,
    place,
    plain,
    shell,
    skirting,
    start,
    text,
    turned,
    unfold,
    wood,
)

WIDTH, DEPTH, HEIGHT = 5.2, 4.2, 2.7
_X, _Y = WIDTH / 2, DEPTH / 2
_WINDOW = (-1.2, 1.2, 0.75, 2.3)  # in the north: x, then z
_DOOR = (1.25, 2.1, 0.0, 2.05)  # in the south
_SEED = 5
_ANGLE = 70.0
_VIEWS = (
    ((2.25, -1.75, 1.55), (-1.6, 0.9, 0.95)),
    ((-1.3, -1.75, 1.6), (1.9, 1.1, 0.95)),
    ((-1.85, -0.35, 1.12), (2.4, 0.35, 0.85)),  # sits on the sofa
    ((0.3, 1.65, 1.5), (-0.1, -2.1, 0.95)),
    ((0.95, 0.85, 1.1), (-2.3, -0.6, 0.75)),  # sits in the armchair
    ((0.75, -1.8, 1.5), (-0.35, 2.0, 0.85)),
)


def living() -> None:
    """Build the room in a new file, with cameras view0 to view5."""
    start()
    chance = np.random.default_rng(_SEED)
    light_outside((0.42, -0.75, -0.62), sun=14.0, sky=4.0)
    _build_shell(chance)
    _add_window_and_door()
    _seat(chance)
    _furnish_east(chance)
    _add_lamp()
    _add_small_things()
    _add_plant(chance)
    cameras(_VIEWS, _ANGLE)


def _build_shell(chance: np.random.Generator) -> None:
    parts = shell(
        WIDTH,
        DEPTH,
        HEIGHT,
        {
            "North": [(_X + _WINDOW[0], _X + _WINDOW[1], *_WINDOW[2:])],
            "South": [(_X - _DOOR[1], _X - _DOOR[0], *_DOOR[2:])],
        },
    )
    unfold(parts["Floor"], 1)
    oak = pictured("Parquet", parquet(chance, (WIDTH + 0.3, DEPTH + 0.3), (1.1, 0.13)), 0.18)
    dressed(parts["Floor"], oak)
    dressed(parts["Ceiling"], plain("Ceiling", (0.85, 0.84, 0.82), 0.7))
    cream = plain("Wall Paint", (0.74, 0.70, 0.62), 0.6)
    for name in ("South", "East", "West"):
        dressed(parts[name], cream)
    dressed(parts["North"], plain("Blue Paint", (0.33, 0.42, 0.47), 0.55))
    ways = [(-_X, -_Y), (_X, -_Y), (_X, _Y), (-_X, _Y)]
    door: Box = ((_DOOR[0] - 0.07, -_Y, 0.0), (_DOOR[1] + 0.07, -_Y, 1.0))
    dressed(skirting("Skirting", ways, [door]), _white())


def _white() -> Any:
    return plain("White Lacquer", (0.82, 0.81, 0.79), 0.3)


def _add_window_and_door() -> None:
    low_x, high_x, low_z, high_z = _WINDOW
    y, wide = _Y, 0.055
    bars: list[Box] = [
        ((low_x, y + 0.04, low_z), (low_x + wide, y + 0.11, high_z)),
        ((high_x - wide, y + 0.04, low_z), (high_x, y + 0.11, high_z)),
        ((low_x + wide, y + 0.04, low_z), (high_x - wide, y + 0.11, low_z + wide)),
        ((low_x + wide, y + 0.04, high_z - wide), (high_x - wide, y + 0.11, high_z)),
        ((-0.03, y + 0.045, low_z + wide), (0.03, y + 0.105, high_z - wide)),
    ]
    sill: Box = ((low_x - 0.08, y - 0.16, low_z - 0.035), (high_x + 0.08, y, low_z))
    pole: Box = ((-1.75, y - 0.105, 2.43), (1.75, y - 0.08, 2.455))
    stone = plain("Stone", (0.62, 0.6, 0.56), 0.25)
    window = boxes("Window", *bars, sill, pole, bevel=0.006)
    painted(window, (_white(), len(bars)), (stone, 1), (_brass(), 1))
    low_x, high_x, _, high_z = _DOOR
    y = -_Y
    sides: list[Box] = [
        ((low_x - 0.07, y, 0.0), (low_x, y + 0.02, high_z + 0.07)),
        ((high_x, y, 0.0), (high_x + 0.07, y + 0.02, high_z + 0.07)),
        ((low_x, y, high_z), (high_x, y + 0.02, high_z + 0.07)),
    ]
    dressed(boxes("Door Frame", *sides, bevel=0.004), _white())
    leaf: list[Box] = [
        ((low_x, y - 0.1, 0.0), (high_x, y - 0.06, high_z)),
        ((low_x + 0.12, y - 0.061, 0.2), (high_x - 0.12, y - 0.05, 0.9)),
        ((low_x + 0.12, y - 0.061, 1.05), (high_x - 0.12, y - 0.05, 1.9)),
    ]
    handle: list[Box] = [
        ((low_x + 0.05, y - 0.06, 0.98), (low_x + 0.075, y - 0.01, 1.005)),
        ((low_x + 0.05, y - 0.02, 0.982), (low_x + 0.18, y - 0.003, 1.003)),
    ]
    paint = plain("Door Paint", (0.5, 0.55, 0.5), 0.35)
    painted(boxes("Door", *leaf, *handle, bevel=0.004), (paint, len(leaf)), (_brass(), len(handle)))
    dressed(_curtain(), plain("Linen", (0.66, 0.58, 0.46), 0.9))


def _brass() -> Any:
    return plain("Brass", (0.85, 0.62, 0.3), 0.22, Metallic=1.0)


def _curtain() -> Any:
    """Two wavy sheets, left and right of the window."""
    vertices: Vertices = []
    faces: Faces = []
    for begin in (-1.68, 1.16):
        first, columns, rows = len(vertices), 61, 8
        for row in range(rows):
            high = 0.02 + (2.43 - 0.02) * row / (rows - 1)
            for column in range(columns):
                share = column / (columns - 1)
                wave = sin(2 * pi * 6 * share + 0.25 * row) * (0.042 - 0.002 * row)
                vertices.append((begin + 0.52 * share, _Y - 0.095 + wave, high))
        for row in range(rows - 1):
            for column in range(columns - 1):
                a = first + row * columns + column
                faces.append((a, a + 1, a + columns + 1, a + columns))
    return mesh_object("Curtain", vertices, faces, smooth=True)


def _seat(chance: np.random.Generator) -> None:
    frame: list[Box] = [
        ((-2.5, -1.0, 0.1), (-1.62, 1.0, 0.3)),
        ((-2.5, -0.84, 0.3), (-2.28, 0.84, 0.8)),
        ((-2.5, -1.0, 0.3), (-1.62, -0.84, 0.6)),
        ((-2.5, 0.84, 0.3), (-1.62, 1.0, 0.6)),
    ]
    feet = [
        ((x - 0.03, y - 0.03, 0.0), (x + 0.03, y + 0.03, 0.1)) for x in (-2.44, -1.68) for y in (-0.94, 0.94)
    ]
    cloth = fabric("Sofa Cloth", (0.16, 0.27, 0.30))
    sofa = boxes("Sofa", *frame, *feet, bevel=0.03, segments=4)
    painted(sofa, (cloth, len(frame)), (_walnut(), len(feet)))
    cushions: list[Box] = [
        ((-2.27, -0.83, 0.305), (-1.6, -0.005, 0.45)),
        ((-2.27, 0.005, 0.305), (-1.6, 0.83, 0.45)),
        ((-2.27, -0.8, 0.455), (-2.08, -0.01, 0.86)),
        ((-2.27, 0.01, 0.455), (-2.08, 0.8, 0.86)),
    ]
    dressed(boxes("Sofa Cushions", *cushions, bevel=0.05, segments=5), fabric("Cushion", (0.2, 0.33, 0.36)))
    pillow = boxes("Pillow", ((-0.2, -0.07, -0.2), (0.2, 0.07, 0.2)), bevel=0.065, segments=5)
    pillow.location, pillow.rotation_euler = (-1.97, 0.55, 0.66), (radians(10), radians(-20), radians(80))
    dressed(pillow, fabric("Ochre Cloth", (0.62, 0.36, 0.08)))
    chair: list[Box] = [
        ((-0.36, -0.36, 0.16), (0.36, 0.36, 0.42)),
        ((-0.36, 0.24, 0.42), (0.36, 0.4, 0.84)),
        ((-0.42, -0.34, 0.16), (-0.3, 0.38, 0.58)),
        ((0.3, -0.34, 0.16), (0.42, 0.38, 0.58)),
    ]
    legs = [
        ((x - 0.035, y - 0.035, 0.0), (x + 0.035, y + 0.035, 0.17))
        for x in (-0.3, 0.3)
        for y in (-0.28, 0.32)
    ]
    armchair = place(boxes("Armchair", *chair, *legs, bevel=0.034, segments=5), (0.95, 0.98, 0.0), -50)
    painted(armchair, (fabric("Red Cloth", (0.45, 0.12, 0.08)), len(chair)), (_walnut(), len(legs)))
    rug = boxes("Rug", ((-1.45, -1.2, 0.0), (0.35, 1.2, 0.012)))
    unfold(rug, 1)
    dressed(rug, pictured("Rug", _rug(chance), 0.95))
    top = boxes("Table Top", ((-1.1, -0.55, 0.4), (-0.4, 0.55, 0.415)), bevel=0.003)
    dressed(top, plain("Glass", (0.93, 0.97, 0.95), 0.0, Transmission_Weight=1.0, IOR=1.5))
    stands: list[Box] = [
        ((x - 0.018, y - 0.018, 0.012), (x + 0.018, y + 0.018, 0.4))
        for x in (-1.0, -0.5)
        for y in (-0.45, 0.45)
    ]
    rails: list[Box] = [((-0.982, y - 0.012, 0.36), (-0.518, y + 0.012, 0.399)) for y in (-0.45, 0.45)]
    metal = plain("Black Steel", (0.12, 0.12, 0.13), 0.35, Metallic=1.0)
    dressed(boxes("Table Legs", *stands, *rails), metal)


def _walnut() -> Any:
    return wood("Walnut", (0.09, 0.045, 0.022), (0.24, 0.13, 0.07), 0.32, along=(9, 1, 9))


def _rug(chance: np.random.Generator) -> Image:
    """Diamonds inside two borders, woven: (H, W, 3)."""
    height, width = 960, 720
    y, x = np.meshgrid((np.arange(height) + 0.5) / 400, (np.arange(width) + 0.5) / 400, indexing="ij")
    edge = np.minimum(np.minimum(x, 1.8 - x), np.minimum(y, 2.4 - y))
    diamond = (np.abs(x % 0.3 - 0.15) + np.abs(y % 0.4 - 0.2) * 0.75) < 0.1
    wool = np.where(diamond[..., None], (0.72, 0.45, 0.3), (0.86, 0.8, 0.68))
    wool = np.where((edge < 0.16)[..., None], (0.35, 0.16, 0.13), wool)
    wool = np.where(((edge > 0.05) & (edge < 0.08))[..., None], (0.86, 0.8, 0.68), wool)
    woven = 0.8 + 0.3 * noise_image(chance, (height, width), (height // 3, width // 3))
    found: Image = np.clip(wool * woven[..., None], 0, 1)
    return found


def _furnish_east(chance: np.random.Generator) -> None:
    cabinet: list[Box] = [
        ((2.16, -0.85, 0.12), (2.56, 1.05, 0.74)),
        ((2.145, -0.84, 0.14), (2.16, -0.215, 0.72)),
        ((2.145, -0.205, 0.14), (2.16, 0.415, 0.72)),
        ((2.145, 0.425, 0.14), (2.16, 1.04, 0.72)),
    ]
    feet = [
        ((x - 0.02, y - 0.02, 0.0), (x + 0.02, y + 0.02, 0.12)) for x in (2.22, 2.5) for y in (-0.75, 0.95)
    ]
    oak = wood("Oak", (0.3, 0.18, 0.09), (0.5, 0.33, 0.18), 0.28, along=(9, 1, 9))
    board = boxes("Sideboard", *cabinet, *feet, bevel=0.005)
    painted(board, (oak, len(cabinet)), (_brass(), len(feet)))
    mirror = boxes("Mirror", ((_X - 0.014, -0.5, 1.0), (_X - 0.004, 0.7, 1.95)))
    dressed(mirror, plain("Silver", (0.94, 0.95, 0.95), 0.0, Metallic=1.0))
    rim: list[Box] = [
        ((_X - 0.03, -0.56, 0.94), (_X, -0.5, 2.01)),
        ((_X - 0.03, 0.7, 0.94), (_X, 0.76, 2.01)),
        ((_X - 0.03, -0.5, 1.95), (_X, 0.7, 2.01)),
        ((_X - 0.03, -0.5, 0.94), (_X, 0.7, 1.0)),
    ]
    dressed(boxes("Mirror Frame", *rim), _walnut())
    black = plain("Black Frame", (0.03, 0.03, 0.03), 0.3)
    sizes = (("Picture Left", 0.6, 0.8, -0.5), ("Picture Right", 0.5, 0.5, 0.4))
    for name, wide, high, at in sizes:
        item = framed(name, wide, high, painting(chance, (round(800 * high), round(800 * wide))), black)
        place(item, (-_X, at, 1.5), 90)
    large = framed("Picture Large", 1.3, 0.85, painting(chance, (560, 860)), _walnut())
    place(large, (-0.9, -_Y, 1.5), 180)


def _add_lamp() -> None:
    x, y = -2.15, 1.55
    stand = [(0.15, 0.0), (0.15, 0.015), (0.02, 0.03), (0.012, 0.06), (0.012, 1.42), (0.02, 1.43)]
    dressed(turned("Lamp Stand", stand, (x, y, 0.0)), plain("Steel", (0.6, 0.6, 0.62), 0.25, Metallic=1.0))
    shade = [(0.24, 1.36), (0.15, 1.66), (0.147, 1.66), (0.237, 1.36)]
    dressed(_open_turned("Lamp Shade", shade, (x, y, 0.0)), plain("Paper", (0.88, 0.8, 0.66), 0.8))
    dressed(ball("Bulb", 0.045, (x, y, 1.5)), glowing("Warm Light", (1.0, 0.72, 0.42), 220.0))
    way = [(x, y - 0.14, 0.006), (x - 0.15, y - 0.35, 0.006), (-2.55, y - 0.3, 0.006)]
    dressed(cord("Lamp Cord", way, 0.004), plain("Rubber", (0.03, 0.03, 0.03), 0.5))


def _open_turned(name: str, profile: list[tuple[float, float]], where: tuple[float, float, float]) -> Any:
    """A closed profile turned about the vertical: a ring, open in the middle."""
    count, segments = len(profile), 64
    vertices = [
        (radius * cos(2 * pi * k / segments), radius * sin(2 * pi * k / segments), high)
        for k in range(segments)
        for radius, high in profile
    ]
    faces: Faces = []
    for k in range(segments):
        for index in range(count):
            after, beside = (index + 1) % count, (k + 1) % segments
            faces.append(
                (k * count + index, beside * count + index, beside * count + after, k * count + after)
            )
    item: Any = mesh_object(name, vertices, faces, smooth=True)
    item.data.set_sharp_from_angle(angle=radians(50))
    item.location = where
    return item


def _add_small_things() -> None:
    chrome = plain("Chrome", (0.9, 0.9, 0.92), 0.03, Metallic=1.0)
    dressed(ball("Chrome Ball", 0.17, (0.62, -0.62, 0.17)), chrome)
    vase = [
        (0.05, 0.0),
        (0.085, 0.06),
        (0.1, 0.14),
        (0.075, 0.24),
        (0.035, 0.31),
        (0.03, 0.35),
        (0.042, 0.37),
    ]
    vase += [(0.037, 0.37), (0.026, 0.35), (0.03, 0.3)]
    glaze = plain("Glaze", (0.08, 0.2, 0.42), 0.3, Coat_Weight=1.0, Coat_Roughness=0.04)
    dressed(turned("Vase", vase, (2.36, -0.62, 0.742)), glaze)
    bowl = [
        (0.05, 0.0),
        (0.06, 0.01),
        (0.13, 0.06),
        (0.15, 0.085),
        (0.146, 0.088),
        (0.125, 0.065),
        (0.05, 0.02),
    ]
    dressed(turned("Bowl", bowl, (-0.72, 0.2, 0.4155)), plain("Stoneware", (0.8, 0.76, 0.68), 0.25))
    colours: tuple[Colour, ...] = ((0.5, 0.09, 0.07), (0.08, 0.2, 0.14), (0.75, 0.6, 0.25), (0.1, 0.14, 0.35))
    volumes: list[Box] = []
    at = 0.5
    for number in range(8):
        thick, high = 0.025 + 0.012 * (number * 5 % 4), 0.2 + 0.02 * (number * 3 % 4)
        volumes.append(((2.3, at, 0.7405), (2.46, at + thick, 0.7405 + high)))
        at += thick + 0.002
    books = boxes("Books", *volumes, bevel=0.003)
    for number, colour in enumerate(colours):
        dressed(books, plain(f"Book {number + 1}", colour, 0.5))
    for face in books.data.polygons:
        face.material_index = face.index // 6 % len(colours)
    lying: list[Box] = [
        ((-0.95, -0.36, 0.4155), (-0.72, -0.05, 0.443)),
        ((-0.93, -0.33, 0.4435), (-0.72, -0.08, 0.466)),
    ]
    magazines = place(boxes("Magazines", *lying, bevel=0.002), (0.02, 0.0, 0.0))
    dressed(magazines, plain("Cover", (0.7, 0.68, 0.62), 0.2))
    letters = text("Letters", "HOME", 0.2, 0.02)
    letters.rotation_euler = (radians(90), 0, radians(-90))
    letters.location = (2.3, 0.1, 0.742)
    dressed(letters, _brass())


def _add_plant(chance: np.random.Generator) -> None:
    x, y = 2.12, 1.62
    pot = [(0.14, 0.0), (0.17, 0.15), (0.19, 0.34), (0.175, 0.34), (0.165, 0.3)]
    dressed(turned("Plant Pot", pot, (x, y, 0.0)), plain("Terracotta", (0.5, 0.2, 0.1), 0.7))
    vertices: Vertices = []
    faces: Faces = []
    uvs: list[tuple[float, float]] = []
    for number in range(26):
        side, rise, long = 2.4 * number, float(chance.uniform(0.5, 1.35)), float(chance.uniform(0.5, 0.85))
        _add_leaf(vertices, faces, uvs, side, rise, long)
    item: Any = mesh_object("Leaves", vertices, faces, smooth=True)
    layer = item.data.uv_layers.new(name="UVMap")
    for loop in item.data.loops:
        layer.data[loop.index].uv = uvs[loop.vertex_index]
    item.location = (x, y, 0.28)
    dressed(item, pictured("Leaf", _leaf_image(chance), 0.4))


def _add_leaf(
    vertices: Vertices,
    faces: Faces,
    uvs: list[tuple[float, float]],
    side: float,
    rise: float,
    long: float,
) -> None:
    """A strip that rises at an angle and hangs over; the walls are near, so it is short towards them."""
    first, steps = len(vertices), 7
    out, up = 0.03, 0.0
    reach = 0.55 if cos(side) > 0.2 or sin(side) > 0.2 else 1.0
    for step in range(steps + 1):
        share = step / steps
        angle = rise - 1.5 * share**1.5
        out += reach * long / steps * cos(angle)
        up += long / steps * sin(angle)
        for edge in (-1, 1):
            across = edge * 0.055
            vertices.append(
                (out * cos(side) - across * sin(side), out * sin(side) + across * cos(side), up + 0.01 * edge)
            )
            uvs.append((0.5 + 0.5 * edge, share))
        if step:
            a = first + 2 * step
            faces.append((a - 2, a - 1, a + 1, a))


def _leaf_image(chance: np.random.Generator) -> Image:
    """A pointed leaf with a light middle rib, (H, W, 4): alpha is 0 beside it."""
    height, width = 512, 128
    y, x = np.meshgrid((np.arange(height) + 0.5) / height, (np.arange(width) + 0.5) / width, indexing="ij")
    half = 0.08 + 0.4 * np.sin(np.pi * np.clip(y, 0, 1) ** 1.2) ** 0.8 * (y > 0.08)
    aside = np.abs(x - 0.5)
    green = (
        np.array([0.2, 0.42, 0.14]) + 0.12 * (noise_image(chance, (height, width), (40, 10)) - 0.5)[..., None]
    )
    veins = (aside < 0.02) | (np.abs((y * 14 - aside * 6) % 1 - 0.5) < 0.06)
    found = np.where(veins[..., None], green + 0.12, green)
    return np.concatenate([np.clip(found, 0, 1), (aside < half)[..., None]], axis=-1)
