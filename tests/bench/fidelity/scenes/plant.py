# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A plant: leaves of cards cut out by an alpha texture, which light shines through, in a pot."""

from __future__ import annotations

from math import cos, pi, sin
from typing import Any, cast

import bpy
import numpy as np

from .materials import Pixels, assign, connect, principled, texture, translucent
from .meshes import Faces, Points, Vertices, as_subject, joined, lathe, mesh_object, smooth_curve
from .stage import Stage, finish, lamp, start

_ALONG, _ACROSS = 10, 4  # faces of a leaf's card
_LEAVES = 13
_SIDE = 256  # pixels of the leaf's texture


def plant() -> Stage:
    """Thirteen leaves about the middle of a pot."""
    start("forest.exr", strength=0.9, turn=60)
    leaves = [_leaf(number) for number in range(_LEAVES)]
    pot = lathe(smooth_curve(_POT), segments=64, tip=0.0)
    shape = joined(*leaves, pot)
    item = as_subject(mesh_object("Plant", *shape, smooth=True))
    mesh = cast(bpy.types.Mesh, item.data)
    cards = _LEAVES * _ALONG * _ACROSS
    rings = len(smooth_curve(_POT)) - 1
    earth = np.zeros(len(mesh.polygons), dtype=np.int32)
    earth[cards:] = 1
    earth[cards + 64 * (rings - 3) : cards + 64 * rings] = 2  # what lies within the rim
    earth[cards + 64 * rings + 1 :: 2] = 2  # and its middle
    mesh.polygons.foreach_set("material_index", earth)
    layer: Any = mesh.uv_layers.new(name="UVMap")
    uv = np.zeros((len(mesh.loops), 2))
    uv[: 4 * cards] = np.tile(_card_uv(), (_LEAVES, 1))
    layer.data.foreach_set("uv", uv.ravel())
    assign(item, _leaf_material())
    assign(item, principled("Pot", (0.5, 0.2, 0.1), Roughness=0.5))
    assign(item, principled("Earth", (0.06, 0.035, 0.02), Roughness=0.9))
    lamp((-1.5, 2.2, 2.8), size=0.5, watts=70)
    return finish("plant", item, see_through=True)


_POT = np.array(
    [
        (0.04, -0.95), (0.3, -0.95), (0.36, -0.9), (0.48, -0.4), (0.53, -0.36), (0.53, -0.26), (0.48, -0.24),
        (0.44, -0.3), (0.04, -0.3),
    ]
)  # fmt: skip


def _leaf(number: int) -> tuple[Vertices, Faces]:
    """A card that rises from the pot's middle and bends outwards."""
    turn = number * 2.4  # the golden angle, nearly
    inner = number / _LEAVES
    length, rise, width = 1.15 - 0.35 * inner, 0.55 + 0.8 * inner, 0.34 - 0.08 * inner
    vertices: Vertices = []
    for row in range(_ALONG + 1):
        t = row / _ALONG
        out = 0.05 + length * (t * cos(rise) + 0.25 * t**2)
        up = -0.3 + length * (t * sin(rise) * 1.5 - 0.55 * (1.3 - inner) * t**2)
        for column in range(_ACROSS + 1):
            s = column / _ACROSS - 0.5
            side, lift = s * 2 * width, 0.12 * abs(2 * s)  # a shallow channel
            x, y = out * cos(turn) - side * sin(turn), out * sin(turn) + side * cos(turn)
            vertices.append((x, y, up + lift * sin(pi * t)))
    wide = _ACROSS + 1
    corners = [row * wide + column for row in range(_ALONG) for column in range(_ACROSS)]
    return vertices, [(k, k + 1, k + 1 + wide, k + wide) for k in corners]


def _card_uv() -> Points:
    """UVs of a card's loops, in the order of its faces: (4 faces, 2)."""
    square = np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
    cells = [square + np.array((column, row)) for row in range(_ALONG) for column in range(_ACROSS)]
    return np.concatenate(cells) / (_ACROSS, _ALONG)


def _leaf_material() -> bpy.types.Material:
    leaf = principled("Leaf", (0.1, 0.3, 0.05), Roughness=0.35)
    image = texture(leaf, "Leaf", _leaf_picture())
    connect(leaf, "Base Color", image.outputs["Color"])
    translucent(leaf, 0.35, alpha=image.outputs["Alpha"])
    return leaf


def _leaf_picture() -> Pixels:
    """A serrated leaf with veins and a few holes, (H, W, 4), display values; its tip is up."""
    steps = (np.arange(_SIDE) + 0.5) / _SIDE
    u, v = np.meshgrid(steps * 2 - 1, steps)
    half = 0.95 * np.sin(pi * v**0.8) ** 0.8 * (1 - 0.35 * v) + 0.03
    half = half * (1 + 0.1 * (2 * np.abs((v * 14) % 1 - 0.5) - 0.5))
    inside = np.abs(u) < half
    for x, y, radius in ((0.35, 0.45, 0.09), (-0.3, 0.6, 0.07), (-0.45, 0.3, 0.06)):
        inside &= np.hypot(u - x, 2 * (v - y)) > radius
    veins = np.abs(((v - 0.45 * np.abs(u)) * 9) % 1 - 0.5) < 0.05
    veins |= np.abs(u) < 0.05
    shade = 0.85 + 0.15 * np.cos(9 * v) * np.cos(4 * u)
    green = np.array([0.24, 0.5, 0.14]) * shade[..., None]
    picture = np.empty((_SIDE, _SIDE, 4))
    picture[..., :3] = np.where(veins[..., None], (0.62, 0.74, 0.4), green)
    picture[..., 3] = inside
    return picture
