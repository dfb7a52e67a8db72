# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A gallery hall of 12 x 8 x 4 m: pictures under spots, statues, benches, a polished floor, a skylight."""

from __future__ import annotations

from math import cos, pi, radians, sin
from typing import Any

import bpy
import numpy as np

from ..assets.drawn import Image
from ..fidelity.scenes.meshes import Faces, mesh_object
from .building import (
    THICKNESS,
    Box,
    Colour,
    ball,
    boxes,
    cameras,
    dressed,
    framed,
    light_outside,
    noise_image,
    painted,
    painting,
    pictured,
    place,
    plain,
    shell,
    skirting,
    spot,
    start,
    turned,
    unfold,
    wood,
)

WIDTH, DEPTH, HEIGHT = 12.0, 8.0, 4.0
_X, _Y = WIDTH / 2, DEPTH / 2
_SKYLIGHT: Box = ((-3.6, -1.1, HEIGHT), (3.6, 1.1, HEIGHT + 0.35))
_DOOR = (-0.9, 0.9, 0.0, 2.4)  # in the west: from its middle, then z
_SEED = 8
_ANGLE = 70.0
_VIEWS = (
    ((5.2, -3.1, 1.62), (-3.4, 1.5, 1.35)),
    ((-5.2, 0.3, 1.6), (4.0, -0.1, 1.25)),
    ((0.9, -2.6, 1.55), (-0.7, 3.9, 1.45)),
    ((-4.4, 3.1, 1.5), (1.8, -3.0, 1.2)),
    ((2.05, 0.35, 1.12), (5.2, 3.2, 1.35)),  # sits on a bench
    ((-1.8, 1.6, 1.65), (-5.6, -3.4, 1.2)),
)


def gallery() -> None:
    """Build the hall in a new file, with cameras view0 to view5."""
    start()
    chance = np.random.default_rng(_SEED)
    light_outside((0.35, 0.3, -0.9), sun=9.0, sky=4.0)
    _build_hall(chance)
    _hang_pictures(chance)
    _stand_statues()
    _set_benches()
    cameras(_VIEWS, _ANGLE)


def _build_hall(chance: np.random.Generator) -> None:
    parts = shell(WIDTH, DEPTH, HEIGHT, {"West": [(_Y + _DOOR[0], _Y + _DOOR[1], *_DOOR[2:])]})
    unfold(parts["Floor"], 1)
    dressed(parts["Floor"], pictured("Terrazzo", _terrazzo(chance), 0.1))
    white = plain("Gallery White", (0.8, 0.8, 0.78), 0.65)
    for name in ("North", "South", "West"):
        dressed(parts[name], white)
    dressed(parts["East"], plain("Dark Red", (0.32, 0.07, 0.06), 0.6))
    bpy.data.objects.remove(parts["Ceiling"])
    dressed(_ceiling(), plain("Ceiling", (0.82, 0.82, 0.8), 0.8))
    ways = [(-_X, -_Y), (_X, -_Y), (_X, _Y), (-_X, _Y)]
    door: Box = ((-_X, _DOOR[0] - 0.08, 0.0), (-_X, _DOOR[1] + 0.08, 1.0))
    grey = plain("Grey Lacquer", (0.3, 0.3, 0.3), 0.3)
    dressed(skirting("Skirting", ways, [door], high=0.12), grey)
    low, high = _DOOR[0], _DOOR[1]
    sides: list[Box] = [
        ((-_X, low - 0.08, 0.0), (-_X + 0.03, low, 2.48)),
        ((-_X, high, 0.0), (-_X + 0.03, high + 0.08, 2.48)),
        ((-_X, low, 2.4), (-_X + 0.03, high, 2.48)),
    ]
    dressed(boxes("Door Frame", *sides), grey)
    leaves: list[Box] = [
        ((-_X - 0.1, low, 0.0), (-_X - 0.06, -0.004, 2.4)),
        ((-_X - 0.1, 0.004, 0.0), (-_X - 0.06, high, 2.4)),
    ]
    oak = wood("Oak", (0.28, 0.17, 0.09), (0.46, 0.3, 0.17), 0.3, along=(9, 9, 1))
    dressed(boxes("Doors", *leaves, bevel=0.004), oak)


def _terrazzo(chance: np.random.Generator) -> Image:
    """Slabs of light stone with dark and red chips, 1.2 m wide: (H, W, 3)."""
    height, width = 1660, 2460
    y, x = np.meshgrid(np.arange(height) / 200, np.arange(width) / 200, indexing="ij")
    chips = noise_image(chance, (height, width), (height // 6, width // 6))
    other = noise_image(chance, (height, width), (height // 9, width // 9))
    stone = (
        np.array([0.66, 0.63, 0.58]) * (0.9 + 0.2 * noise_image(chance, (height, width), (20, 30)))[..., None]
    )
    stone = np.where((chips > 0.78)[..., None], (0.3, 0.29, 0.28), stone)
    stone = np.where((other > 0.82)[..., None], (0.52, 0.3, 0.24), stone)
    joint = (x % 1.2 < 0.012) | (y % 1.2 < 0.012)
    found: Image = np.clip(np.where(joint[..., None], (0.34, 0.33, 0.32), stone), 0, 1)
    return found


def _ceiling() -> Any:
    """Slabs around the skylight, whose sides reach above them, and beams below the sky."""
    (x, y, z), (to_x, to_y, top) = _SKYLIGHT
    out_x, out_y, up = _X + THICKNESS, _Y + THICKNESS, HEIGHT + 0.12
    parts: list[Box] = [
        ((-out_x, -out_y, z), (out_x, y, up)),
        ((-out_x, to_y, z), (out_x, out_y, up)),
        ((-out_x, y, z), (x, to_y, up)),
        ((to_x, y, z), (out_x, to_y, up)),
        ((x - 0.1, y - 0.1, up), (to_x + 0.1, y, top)),
        ((x - 0.1, to_y, up), (to_x + 0.1, to_y + 0.1, top)),
        ((x - 0.1, y, up), (x, to_y, top)),
        ((to_x, y, up), (to_x + 0.1, to_y, top)),
    ]
    parts += [((at - 0.03, y, top - 0.1), (at + 0.03, to_y, top)) for at in (-1.8, 0.0, 1.8)]
    return boxes("Ceiling", *parts)


def _hang_pictures(chance: np.random.Generator) -> None:
    gold = plain("Gilt", (0.83, 0.6, 0.25), 0.3, Metallic=1.0)
    black = plain("Black Frame", (0.03, 0.03, 0.03), 0.25)
    walls = (  # along x or y, the turn from towards -y, and the places
        ("North", 0.0, (-4.2, -1.4, 1.4, 4.2)),
        ("South", 180.0, (-3.6, 0.0, 3.6)),
        ("East", -90.0, (-2.0, 1.6)),
    )
    number = 0
    for wall, turn, places in walls:
        for at in places:
            number += 1
            wide, high = float(chance.uniform(0.9, 1.7)), float(chance.uniform(0.8, 1.4))
            pixels = painting(chance, (round(500 * high), round(500 * wide)))
            item = framed(f"Picture {number}", wide, high, pixels, gold if number % 2 else black)
            where = {"North": (at, _Y, 1.6), "South": (at, -_Y, 1.6), "East": (_X, at, 1.6)}[wall]
            place(item, where, turn)
            into = {"North": (0, -1), "South": (0, 1), "East": (-1, 0)}[wall]
            lamp = (where[0] + 1.5 * into[0], where[1] + 1.5 * into[1], HEIGHT - 0.16)
            spot(f"Spot {number}", lamp, where, 120.0, 48.0)
    rails: list[Box] = [
        ((-5.4, _Y - 1.53, HEIGHT - 0.1), (5.4, _Y - 1.49, HEIGHT - 0.06)),
        ((-5.4, -_Y + 1.49, HEIGHT - 0.1), (5.4, -_Y + 1.53, HEIGHT - 0.06)),
    ]
    dressed(boxes("Spot Rails", *rails), black)


def _stand_statues() -> None:
    stone: Colour = (0.72, 0.7, 0.66)
    marble = plain("Marble", stone, 0.35)
    plaster = plain("Pedestal", (0.75, 0.75, 0.73), 0.5)
    places = ((-2.6, -0.4), (0.2, 0.3), (3.3, -1.2), (4.3, 2.2))
    for number, (x, y) in enumerate(places):
        stand = boxes(f"Pedestal {number + 1}", ((-0.25, -0.25, 0.0), (0.25, 0.25, 0.95)), bevel=0.008)
        dressed(place(stand, (x, y, 0.0), 12.0 * number), plaster)
    bpy.ops.mesh.primitive_monkey_add(size=0.62, location=(-2.6, -0.4, 1.26))
    head: Any = bpy.context.object
    head.name, head.rotation_euler = "Head", (radians(-12), 0, radians(-60))
    head.modifiers.new("Subdivision", "SUBSURF").render_levels = 2
    head.modifiers["Subdivision"].levels = 2
    head.data.polygons.foreach_set("use_smooth", [True] * len(head.data.polygons))
    dressed(head, marble)
    knot = _knot("Bronze Knot", 2, 3)
    knot.location = (0.2, 0.3, 1.335)
    dressed(knot, plain("Bronze", (0.62, 0.38, 0.2), 0.25, Metallic=1.0))
    steel = plain("Polished Steel", (0.75, 0.76, 0.78), 0.06, Metallic=1.0)
    dressed(ball("Steel Ball", 0.28, (3.3, -1.2, 1.23)), steel)
    vase = [(0.1, 0.0), (0.2, 0.12), (0.23, 0.28), (0.16, 0.46), (0.08, 0.56), (0.075, 0.62), (0.12, 0.68)]
    vase += [(0.11, 0.68), (0.065, 0.62), (0.07, 0.55)]
    glaze = plain("Celadon", (0.2, 0.42, 0.32), 0.25, Coat_Weight=1.0, Coat_Roughness=0.05)
    dressed(turned("Large Vase", vase, (4.3, 2.2, 0.95)), glaze)
    tall = _knot("Lacquer Knot", 3, 5)
    tall.scale, tall.location = (2.0, 2.0, 2.0), (-4.2, 1.2, 0.785)
    tall.rotation_euler = (radians(90), 0, radians(35))
    dressed(tall, plain("Red Lacquer", (0.55, 0.04, 0.03), 0.15))


def _knot(name: str, p: int, q: int) -> Any:
    """A tube along a torus knot, about 0.7 high."""
    around, rings = 16, 220
    angle = 2 * pi * np.arange(rings) / rings
    radius = 0.2 + 0.085 * np.cos(q * angle)
    line = np.stack([radius * np.cos(p * angle), 0.1 * np.sin(q * angle), radius * np.sin(p * angle)], axis=1)
    line *= 1.2
    along = np.roll(line, -1, axis=0) - np.roll(line, 1, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    side = np.cross(along, line)
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    up = np.cross(side, along)
    vertices = [
        tuple((line[k] + 0.042 * (cos(turn) * side[k] + sin(turn) * up[k])).tolist())
        for k in range(rings)
        for turn in 2 * pi * np.arange(around) / around
    ]
    faces: Faces = []
    for k in range(rings):
        here, there = k * around, (k + 1) % rings * around
        for m in range(around):
            after = (m + 1) % around
            faces.append((here + m, there + m, there + after, here + after))
    return mesh_object(name, vertices, faces, smooth=True)


def _set_benches() -> None:
    leather = plain("Black Leather", (0.035, 0.033, 0.03), 0.4)
    steel = plain("Brushed Steel", (0.6, 0.6, 0.62), 0.3, Metallic=1.0)
    for number, (x, y, turn) in enumerate(((1.9, 0.9, 90.0), (-1.2, -2.0, 0.0))):
        legs: list[Box] = [((at - 0.03, -0.2, 0.0), (at + 0.03, 0.2, 0.36)) for at in (-0.6, 0.6)]
        seat: Box = ((-0.8, -0.24, 0.36), (0.8, 0.24, 0.46))
        bench = boxes(f"Bench {number + 1}", seat, *legs, bevel=0.02, segments=4)
        painted(place(bench, (x, y, 0.0), turn), (leather, 1), (steel, len(legs)))
    post = [(0.15, 0.0), (0.15, 0.015), (0.02, 0.03), (0.02, 0.9), (0.035, 0.92), (0.035, 0.96)]
    for number, y in enumerate((-1.1, 1.1)):
        brass = plain(f"Brass {number + 1}", (0.85, 0.62, 0.3), 0.15, Metallic=1.0)
        dressed(turned(f"Post {number + 1}", post, (-5.35, y * 1.25, 0.0)), brass)
