# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lights that a world's picture shows, such as a studio's softboxes and the sun, as lamps.

A picture that is blurred as wide as a lobe knows no longer whether a small light in it stood before or behind
the edge of a floor or a ball: the light spreads below the horizon, and is hidden there. Of a lamp it is asked
where it stands.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ....core.arrays import Bools, Floats
from ....core.octahedron import cell_directions
from ..lookup.environment import Around, Lamp, Pictures

_BRIGHT = 8.0  # times the world's mean radiance: what is brighter belongs to a light
_REACH = 0.2  # radians around a light's middle that are of the same light
_LEAST = 0.01  # of the world's light: what sends less stays in the picture
_FAR = 1e4  # where the world is
_ROUNDS = 3
_MOST = 5  # lamps, those that are there included: preview materials of more overflow the stack of Cycles


def with_world_lights(around: Around, widest: float) -> Around:
    """The same with the brightest small lights of the world as lamps that all layers are before.

    No more than five with those that are there. By how much they are brighter than a bright place of
    the world counts: that is taken out of its picture. Such lamps are round: a light whose width² is above
    the `widest` (see `gloss_maps.widest_blur`) keeps its shape, in the picture.
    """
    size = len(around.world.levels[0])
    direction = cell_directions(size).astype(np.float64)
    solid = 4 * np.abs(direction).sum(axis=1) ** 3 / len(direction)  # of a cell, on the sphere
    radiance = around.world.levels[0].reshape(-1, 3).astype(np.float64)
    brightest = radiance.max(axis=1)
    usual = _BRIGHT * float((brightest * solid).sum()) / (4 * np.pi)
    if not usual:
        return around
    more = radiance * np.maximum(1 - usual / np.maximum(brightest, 1e-12), 0)[:, None]
    total = float((radiance.sum(axis=1) * solid).sum())
    lights: list[Lamp] = []
    left = brightest > usual
    while left.any() and len(lights) + len(around.lamps) < _MOST:
        cells = np.flatnonzero(left)
        sent = more[cells] * solid[cells, None]
        near, middle = _around_brightest(direction[cells], more[cells].sum(axis=1), sent.sum(axis=1))
        left[cells[near]] = False
        lamp = _lamp(direction[cells[near]], sent[near], middle)
        if sent[near].sum() >= _LEAST * total and lamp.variance <= widest:
            radiance[cells[near]] -= more[cells[near]]
            lights.append(lamp)
    if not lights:
        return around
    world = Pictures.of(direction, radiance.astype(np.float32), size)
    return replace(around, world=world, lamps=(*around.lamps, *lights))


def _around_brightest(direction: Floats, radiance: Floats, weight: Floats) -> tuple[Bools, Floats]:
    """Which of unit directions (P, 3) are near the one with most radiance (P,), and their mean by weight."""
    middle = direction[radiance.argmax()]
    for _ in range(_ROUNDS):
        near = direction @ middle > np.cos(_REACH)
        middle = (direction[near] * weight[near, None]).sum(axis=0)
        middle /= np.linalg.norm(middle)
    near = direction @ middle > np.cos(_REACH)
    near[radiance.argmax()] = True
    return near, middle


def _lamp(direction: Floats, sent: Floats, middle: Floats) -> Lamp:
    """The lamp that sends so much light (P, 3) from unit directions (P, 3) around a middle one."""
    weight = sent.sum(axis=1)
    variance = float((2 * (1 - direction @ middle) * weight).sum() / weight.sum() / 2)
    place = (_FAR * middle).astype(np.float32)
    return Lamp(place, sent.sum(axis=0).astype(np.float32), max(variance, 1e-7), behind=True)
