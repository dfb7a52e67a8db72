# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the layers of surroundings let sharp rays end, and what their pictures know of places.

Places and offsets are from the middle of the surroundings, (N, 3); a place of NaN is the world's.
"""

from __future__ import annotations

from typing import cast

import numpy as np

from ....core.arrays import Bools, Floats
from .environment import Around, Lit

SAME = 0.12  # of a ray's length: ends that are closer to each other are one place
SHARP = 1e-9  # a width² that is none
_SOLID = 0.5  # alpha from which on a layer shows something
_CORNER = 6.0  # times a square lamp's variance: the square of the angle to its corner
_LEAST_RATIO, _MOST_RATIO = 1 / 16, 4.0  # as the layers have it


def shown_ends(around: Around, offset: Floats, axis: Floats) -> Floats:
    """Where rays from offsets along unit axes (N, 3) end by what the layers show: places (N, 3)."""
    found = np.full(offset.shape, np.nan, dtype=np.float32)
    sharp = np.full(len(axis), SHARP, dtype=np.float32)
    for layer in around.layers:
        met, _, cover = layer.shape.meet(offset, axis, sharp)
        met = met.astype(np.float32)
        solid = (cover > _SOLID) & (layer.pictures.sharp(met)[3] > _SOLID)
        found[solid] = layer.shape.seen_at(met[solid])
    return found


def light_of(
    around: Around, offset: Floats, axis: Floats, place: Floats, variance: Floats
) -> tuple[Floats, Bools]:
    """The light (3, N) that rays bring of the places (N, 3) where they end, and of which it is known (N,).

    It is known of the world, and of places that one of the pictures shows; it is blurred by variances (N,),
    without lamps.
    """
    light = around.world.look(axis, variance)
    known = np.isnan(place[:, 0])
    light[:, ~known] = 0
    length = np.linalg.norm(place - offset, axis=1)
    for layer in around.layers:
        away = np.nan_to_num(place - layer.shape.eye)
        distance = np.maximum(np.linalg.norm(away, axis=1), 1e-9)
        direction = (away / distance[:, None]).astype(np.float32)
        apart = np.linalg.norm(layer.shape.seen_at(direction) - place, axis=1)
        ratio = np.clip(length / distance, _LEAST_RATIO, _MOST_RATIO)
        some = np.flatnonzero(~known & (apart < SAME * np.minimum(length, distance)))
        wide = (variance * ratio**2).astype(np.float32)[some]
        seen = layer.pictures.look(direction[some], wide)
        solid = seen[3] > _SOLID
        light[:, some[solid]] = (seen[:3] / np.maximum(seen[3], _SOLID))[:, solid]
        known[some[solid]] = True
    return cast(Floats, light), known


def lamp_light(
    around: Around,
    offset: Floats,
    axis: Floats,
    place: Floats,
    variance: Floats,
    lit: Lit | None = None,
) -> tuple[Floats, Bools]:
    """The light (3, N) of lamps before the places (N, 3) where rays end, and which rays meet one (N,).

    `lit` as for `Around.look`.
    """
    light, met = np.zeros((3, len(axis)), dtype=np.float32), np.zeros(len(axis), dtype=bool)
    length = np.linalg.norm(place - offset, axis=1)
    for lamp in around.lamps:
        towards = lamp.place - offset
        distance = np.linalg.norm(towards, axis=1)
        before = ~(length < distance)  # the world's is NaN
        seen = 1.0 if lit is None or not lamp.behind else lit.most(lamp, offset)
        light += np.where(before, lamp.light(offset, axis, variance) * seen, 0)
        squared = 2 * (1 - (axis * towards).sum(axis=1) / distance)
        nearer = float((lamp.place**2).sum()) / distance**2
        met |= before & (squared < _CORNER * lamp.variance * nearer)
    return light, met
