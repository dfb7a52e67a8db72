# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene drawn by chance: what stands where, of which materials, in which light, seen from where."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..scenes.meshes import as_subject
from ..scenes.stage import Stage, floor_height, start, with_cameras
from .exposure import expose
from .looks import dress
from .objects import draw_object
from .surroundings import HDRIS, draw_cameras, draw_floor, draw_lamps, draw_neighbours

_TRIES = 8
_PREFIX = "lottery-"


def lottery_name(seed: int, number: int) -> str:
    """The name of a scene of the lottery."""
    return f"{_PREFIX}{seed}-{number}"


def is_lottery(name: str) -> bool:
    """Whether a scene's name is one of the lottery's."""
    return name.startswith(_PREFIX)


def lottery(seed: int, number: int) -> Stage:
    """Build the scene of a number among those of a seed; the same at every call.

    A draw whose object is hardly seen, or cannot be lit well, is thrown away for another.
    """
    for attempt in range(_TRIES):
        stage = _draw(np.random.default_rng((seed, number, attempt)))
        if expose(stage):
            return replace(stage, name=lottery_name(seed, number))
    raise RuntimeError(f"{lottery_name(seed, number)}: no draw of {_TRIES} can be lit well")


def _draw(rng: np.random.Generator) -> Stage:
    """A scene whose light is not yet set to an exposure."""
    start(
        HDRIS[rng.integers(len(HDRIS))], strength=float(rng.uniform(0.3, 1)), turn=float(rng.uniform(0, 360))
    )
    item = as_subject(draw_object(rng))
    dress(item, rng)
    floor = floor_height(item) + float(rng.uniform(-0.2, 0.05))
    tuning, held_out = draw_cameras(rng), draw_cameras(rng)
    draw_floor(floor, rng)
    draw_neighbours(floor, held_out, rng)
    draw_lamps(rng)
    return with_cameras("draw", item, tuning, held_out)
