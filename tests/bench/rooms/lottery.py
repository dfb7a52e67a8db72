# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rooms drawn by a seed, so that nothing can be tuned on them."""

from __future__ import annotations

from math import cos, pi, sin
from typing import Any

import numpy as np

from .building import (
    THICKNESS,
    Box,
    Colour,
    Hole,
    ball,
    boxes,
    cameras,
    dressed,
    fabric,
    framed,
    glowing,
    light_outside,
    painting,
    parquet,
    pictured,
    place,
    plain,
    shell,
    skirting,
    start,
    turned,
    unfold,
    wood,
)

_ANGLES = (65.0, 75.0)  # of view
_EYES = (1.4, 1.65)  # heights of cameras
_APART = 0.25  # between things, and between them and walls
_TRIES = 200
_VIEWS = 6

Circle = tuple[float, float, float]  # x, y and radius on the floor


def draw_room(seed: int) -> None:
    """Build the room of a seed in a new file, with cameras view0 to view5; the same at every call."""
    start()
    chance = np.random.default_rng(seed)
    width, depth = float(chance.uniform(3.2, 7.0)), float(chance.uniform(3.0, 5.5))
    height = float(chance.uniform(2.4, 3.2))
    _draw_light(chance)
    windows = _draw_windows(chance, width, depth, height)
    parts = shell(width, depth, height, windows)
    _paint(parts, chance, width, depth)
    block = _draw_block(chance, width, depth, height)
    room = _Room(width, depth, block)
    _furnish(room, chance)
    if chance.random() < 0.7:
        _hang(chance, width, depth, windows)
    if chance.random() < 0.6:
        _light_ceiling(chance, height)
    views = [room.draw_view(chance) for _ in range(_VIEWS)]
    cameras(views, float(chance.uniform(*_ANGLES)))


class _Room:
    """The floor of a room, and what of it is taken."""

    def __init__(self, width: float, depth: float, block: Box | None) -> None:
        self.half = np.array([width, depth]) / 2
        self.block = block
        self.taken: list[Circle] = []

    def free(self, x: float, y: float, radius: float) -> bool:
        """Whether a circle is within the room, and off all that is there."""
        if (np.abs([x, y]) + radius > self.half).any():
            return False
        if self.block is not None:
            (low_x, low_y, _), (high_x, high_y, _) = self.block
            beside = np.hypot(max(low_x - x, x - high_x, 0), max(low_y - y, y - high_y, 0))
            if beside < radius:
                return False
        return all(np.hypot(x - a, y - b) > radius + size for a, b, size in self.taken)

    def draw_place(self, chance: np.random.Generator, radius: float) -> tuple[float, float] | None:
        """A free place for a circle, which is taken then; None where none was found."""
        for _ in range(_TRIES):
            x, y = (chance.uniform(-1, 1, 2) * self.half).tolist()
            if self.free(x, y, radius + _APART):
                self.taken.append((x, y, radius))
                return x, y
        return None

    def draw_view(self, chance: np.random.Generator) -> tuple[Any, Any]:
        """From where somebody stands towards what is across the room's middle, a little downwards."""
        for _ in range(_TRIES):
            x, y = (chance.uniform(-1, 1, 2) * self.half).tolist()
            if not self.free(x, y, 0.4) or np.hypot(*(np.array([x, y]) / self.half)) < 0.5:
                continue
            high = float(chance.uniform(*_EYES))
            to_x, to_y = (-0.5 * np.array([x, y]) + 0.3 * self.half * chance.uniform(-1, 1, 2)).tolist()
            if self._sees(x, y, to_x, to_y):
                return (x, y, high), (to_x, to_y, high - 0.45)
        raise RuntimeError("no place for a camera was found")

    def _sees(self, x: float, y: float, to_x: float, to_y: float) -> bool:
        """Whether nothing that fills the room's height stands near by on the way."""
        steps = np.linspace(0, 1, 9)
        return all(
            np.all(np.abs([x + t * (to_x - x), y + t * (to_y - y)]) < self.half)
            and (self.block is None or not _inside(self.block, x + t * (to_x - x), y + t * (to_y - y)))
            for t in steps.tolist()
        )


def _inside(block: Box, x: float, y: float) -> bool:
    return block[0][0] < x < block[1][0] and block[0][1] < y < block[1][1]


def _draw_light(chance: np.random.Generator) -> None:
    side, up = float(chance.uniform(0, 2 * pi)), float(chance.uniform(0.45, 1.0))
    towards = (cos(side) * cos(up), sin(side) * cos(up), -sin(up))
    light_outside(towards, sun=float(chance.uniform(0, 14)), sky=float(chance.uniform(3.5, 6)))


def _draw_windows(
    chance: np.random.Generator, width: float, depth: float, height: float
) -> dict[str, list[Hole]]:
    """One or two windows, in different walls."""
    names = chance.permutation(["South", "East", "North", "West"])[: int(chance.integers(1, 3))]
    found: dict[str, list[Hole]] = {}
    for name in names.tolist():
        long = width if name in {"South", "North"} else depth
        wide = float(chance.uniform(0.4, 0.6)) * long
        begin = float(chance.uniform(0.3, long - wide - 0.3))
        low = float(chance.choice([0.05, 0.8, 0.95]))
        found[name] = [(begin, begin + wide, low, height - float(chance.uniform(0.2, 0.45)))]
    return found


def _draw_colour(chance: np.random.Generator, low: float, high: float) -> Colour:
    tint = chance.uniform(0.75, 1.0, 3) * float(chance.uniform(low, high))
    red, green, blue = tint.tolist()
    return red, green, blue


def _paint(parts: dict[str, Any], chance: np.random.Generator, width: float, depth: float) -> None:
    unfold(parts["Floor"], 1)
    roughness = float(np.exp(chance.uniform(np.log(0.02), np.log(0.7))))
    size = (width + 2 * THICKNESS, depth + 2 * THICKNESS)
    if chance.random() < 0.6:
        plank = (float(chance.uniform(0.4, 1.4)), float(chance.uniform(0.07, 0.2)))
        floor = pictured("Parquet", parquet(chance, size, plank), roughness)
    else:
        floor = plain("Screed", _draw_colour(chance, 0.25, 0.6), roughness)
    dressed(parts["Floor"], floor)
    dressed(parts["Ceiling"], plain("Ceiling", (0.84, 0.84, 0.82), 0.75))
    paint = plain("Wall Paint", _draw_colour(chance, 0.65, 0.9), float(chance.uniform(0.4, 0.75)))
    accent = plain("Accent", _draw_colour(chance, 0.3, 0.8), float(chance.uniform(0.3, 0.7)))
    other = str(chance.choice(["South", "East", "North", "West"]))
    for name in ("South", "East", "North", "West"):
        dressed(parts[name], accent if name == other else paint)
    x, y = width / 2, depth / 2
    if chance.random() < 0.7:
        board = skirting("Skirting", [(-x, -y), (x, -y), (x, y), (-x, y)], [])
        dressed(board, plain("Skirting", (0.8, 0.79, 0.76), 0.3))


def _draw_block(chance: np.random.Generator, width: float, depth: float, height: float) -> Box | None:
    """What makes one room in three an L: a block of masonry that fills a corner."""
    if chance.random() > 1 / 3:
        return None
    x, y = (np.array([width, depth]) / 2).tolist()
    wide, deep = float(chance.uniform(0.25, 0.4)) * width, float(chance.uniform(0.25, 0.4)) * depth
    right, far = bool(chance.random() < 0.5), bool(chance.random() < 0.5)
    low_x, low_y = (x - wide if right else -x), (y - deep if far else -y)
    block: Box = ((low_x, low_y, 0.0), (low_x + wide, low_y + deep, height))
    dressed(boxes("Block", block), plain("Block Paint", _draw_colour(chance, 0.6, 0.85), 0.6))
    return block


def _furnish(room: _Room, chance: np.random.Generator) -> None:
    makers = (_table, _seat, _cabinet, _ball, _jar, _lamp)
    for number in range(int(chance.integers(5, 10))):
        maker = makers[number] if number < 2 else makers[int(chance.integers(len(makers)))]
        maker(room, chance, f"{number + 1}")


def _finish(chance: np.random.Generator, name: str) -> Any:
    """Wood, lacquer, metal or cloth."""
    kind = int(chance.integers(4))
    colour = _draw_colour(chance, 0.1, 0.7)
    rough = float(chance.uniform(0.05, 0.5))
    if kind == 0:
        return wood(name, (0.2, 0.11, 0.06), (0.42, 0.27, 0.15), rough)
    if kind == 1:
        return plain(name, colour, rough, Coat_Weight=1.0, Coat_Roughness=0.05)
    if kind == 2:
        return plain(name, (0.7, 0.7, 0.72), rough, Metallic=1.0)
    return fabric(name, colour)


def _table(room: _Room, chance: np.random.Generator, number: str) -> None:
    wide, deep, high = chance.uniform([0.8, 0.5, 0.4], [1.4, 0.8, 0.75]).tolist()
    where = room.draw_place(chance, float(np.hypot(wide, deep)) / 2)
    if where is None:
        return
    x, y = wide / 2, deep / 2
    legs: list[Box] = [
        ((a - 0.025, b - 0.025, 0.0), (a + 0.025, b + 0.025, high - 0.03))
        for a in (0.04 - x, x - 0.04)
        for b in (0.04 - y, y - 0.04)
    ]
    turn = float(chance.choice([0, 90, chance.uniform(0, 90)]))
    top = boxes(f"Table Top {number}", ((-x, -y, high - 0.03), (x, y, high)), bevel=0.006)
    dressed(place(top, (*where, 0.0), turn), _finish(chance, f"Table Top {number}"))
    stand = place(boxes(f"Table Legs {number}", *legs), (*where, 0.0), turn)
    dressed(stand, _finish(chance, f"Table Legs {number}"))
    size = float(chance.uniform(0.06, 0.14))
    thing = ball(f"Ball on Table {number}", size, (*where, high + size))
    dressed(thing, plain(f"Ball on Table {number}", _draw_colour(chance, 0.3, 0.9), 0.1, Metallic=1.0))


def _seat(room: _Room, chance: np.random.Generator, number: str) -> None:
    wide = float(chance.uniform(0.7, 1.9))
    where = room.draw_place(chance, float(np.hypot(wide, 0.85)) / 2)
    if where is None:
        return
    x = wide / 2
    parts: list[Box] = [
        ((-x, -0.4, 0.1), (x, 0.4, 0.42)),
        ((-x, 0.22, 0.43), (x, 0.42, 0.82)),
        ((-x - 0.12, -0.4, 0.1), (-x - 0.005, 0.42, 0.6)),
        ((x + 0.005, -0.4, 0.1), (x + 0.12, 0.42, 0.6)),
    ]
    item = boxes(f"Seat {number}", *parts, bevel=0.04, segments=4)
    place(item, (*where, -0.1), float(chance.choice([0, 90, 180, 270])))
    dressed(item, fabric(f"Cloth {number}", _draw_colour(chance, 0.15, 0.6)))


def _cabinet(room: _Room, chance: np.random.Generator, number: str) -> None:
    wide, deep, high = chance.uniform([0.5, 0.35, 0.6], [1.3, 0.5, 1.9]).tolist()
    where = room.draw_place(chance, float(np.hypot(wide, deep)) / 2)
    if where is None:
        return
    item = boxes(f"Cabinet {number}", ((-wide / 2, -deep / 2, 0.0), (wide / 2, deep / 2, high)), bevel=0.006)
    place(item, (*where, 0.0), float(chance.choice([0, 90])))
    dressed(item, _finish(chance, f"Cabinet {number}"))


def _ball(room: _Room, chance: np.random.Generator, number: str) -> None:
    size = float(chance.uniform(0.12, 0.35))
    where = room.draw_place(chance, size)
    if where is not None:
        metal = float(chance.choice([0.0, 1.0]))
        look = plain(f"Ball {number}", _draw_colour(chance, 0.3, 0.9), float(chance.uniform(0.03, 0.4)))
        look.node_tree.nodes["Principled BSDF"].inputs["Metallic"].default_value = metal
        dressed(ball(f"Ball {number}", size, (*where, size)), look)


def _jar(room: _Room, chance: np.random.Generator, number: str) -> None:
    where = room.draw_place(chance, 0.25)
    if where is None:
        return
    radii = chance.uniform([0.08, 0.14, 0.06], [0.14, 0.24, 0.12])
    high = float(chance.uniform(0.4, 0.8))
    profile = [(float(radii[0]), 0.0), (float(radii[1]), 0.4 * high), (float(radii[2]), 0.9 * high)]
    profile += [
        (float(radii[2]) + 0.01, high),
        (float(radii[2]) - 0.005, high),
        (float(radii[2]) - 0.02, 0.9 * high),
    ]
    dressed(turned(f"Jar {number}", profile, (*where, 0.0)), _finish(chance, f"Jar {number}"))


def _lamp(room: _Room, chance: np.random.Generator, number: str) -> None:
    where = room.draw_place(chance, 0.2)
    if where is None:
        return
    stand = [(0.14, 0.0), (0.14, 0.02), (0.012, 0.04), (0.012, 1.45)]
    steel = plain(f"Lamp Steel {number}", (0.6, 0.6, 0.62), 0.25, Metallic=1.0)
    dressed(turned(f"Lamp Stand {number}", stand, (*where, 0.0)), steel)
    glow = glowing(f"Lamp Light {number}", (1.0, 0.76, 0.5), float(chance.uniform(6, 14)))
    dressed(ball(f"Lamp Globe {number}", 0.12, (*where, 1.57)), glow)


def _hang(chance: np.random.Generator, width: float, depth: float, windows: dict[str, list[Hole]]) -> None:
    """A picture or a mirror in the middle of each wall without a window."""
    walls = {
        "North": (0.0, depth / 2, 0.0),
        "South": (0.0, -depth / 2, 180.0),
        "East": (width / 2, 0.0, -90.0),
        "West": (-width / 2, 0.0, 90.0),
    }
    frame = plain("Frame", (0.05, 0.045, 0.04), 0.3)
    for name, (x, y, turn) in walls.items():
        if name in windows:
            continue
        wide, high = chance.uniform([0.6, 0.5], [1.4, 1.0]).tolist()
        item = framed(
            f"Picture {name}", wide, high, painting(chance, (round(400 * high), round(400 * wide))), frame
        )
        place(item, (x, y, 1.55), turn)
        if chance.random() < 0.35:
            item.name = f"Mirror {name}"
            item.material_slots[0].material = plain(f"Silver {name}", (0.93, 0.94, 0.94), 0.0, Metallic=1.0)


def _light_ceiling(chance: np.random.Generator, height: float) -> None:
    """A panel below the ceiling that gives light."""
    panel = boxes("Light Panel", ((-0.45, -0.3, height - 0.05), (0.45, 0.3, height - 0.01)))
    dressed(panel, glowing("Panel Light", (1.0, 0.93, 0.84), float(chance.uniform(4, 9))))
