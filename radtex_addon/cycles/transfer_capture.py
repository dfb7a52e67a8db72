# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The capture of kind `transfer`: the radiance of every texel to its viewers, under one sun after another.

The scene stays loaded, and only the sun turns. The sun has its own light group, whose pass leaves out the
light of materials and instanced lamps.
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np
from mathutils import Vector

from ..bake.piece_store import NO_STORE, Arrays, PieceStore
from ..bake.plan import CapturePlan, Tile
from ..bake.progress import Progress, Stage
from ..bake.thumbnail import Thumbnail
from ..bake.transfer_buckets import sun_directions, sun_radius
from ..core.arrays import Floats
from ..core.errors import BakeError
from ..scene.lights.lamps import take_lamps_away
from ..scene.nodes import open_world
from ..settings.kinds import Kind
from .portal import Aim, PortalCapture

_GROUP = "RadTexSun"
_PASS = f"Combined_{_GROUP}"
MOST = 65504.0  # pieces are half floats


@dataclass(frozen=True, eq=False)
class LitTexels:
    """What V viewers see of K texels: `light` (S, K, V, 3) under each of S suns, `alpha` (K, V); float16."""

    light: Floats
    alpha: Floats


def capture_under_suns(
    scene: bpy.types.Scene,
    plan: CapturePlan,
    shift: Floats,
    suns: int,
    samples: int,
    seed: int,
    folder: Path,
    store: PieceStore = NO_STORE,
    thumbnail: Thumbnail | None = None,
) -> Generator[Progress, None, LitTexels]:
    """Look at each texel of a plan under `sun_directions(suns)`, of irradiance 1.

    Each cell of a bucket is one viewer, at `shift` (K, 2) in the cell (see `transfer_buckets.view_shift`).
    `scene` is a copy of a scratch scene and unusable afterwards; `folder` is for temporary files, the `store`
    stores each render, the `thumbnail` gets the mean of the suns so far. Yields progress in texels times
    suns. Raises BakeError where Cycles fails or returns values that are not numbers.
    """
    scene.world, _ = open_world("RadTex black")
    take_lamps_away(scene)
    sun = _add_sun(scene, sun_radius(suns))
    count, views = len(plan.texel), plan.layout.bucket**2
    capture = PortalCapture(scene, plan, Kind.RADIANCE, samples, seed, folder, Aim(shift))
    height = plan.sheet_rows
    tiles = [Tile(row, min(height, plan.rows - row)) for row in range(0, plan.rows, height)]
    lit = LitTexels(
        np.empty((suns, count, views, 3), dtype=np.float16), np.empty((count, views), dtype=np.float16)
    )
    total = np.zeros((count, 3), dtype=np.float32)
    for number, direction in enumerate(sun_directions(suns)):
        _turn(sun, direction)
        capture.reseed((seed + number) % 2**31)  # otherwise all suns would have the same noise
        for tile in tiles:
            first = tile.first_row * plan.columns
            yield Progress(Stage.CAPTURE, number * count + first, suns * count)
            found = store.get_or_make(
                f"sun-{number:04d}-{tile.first_row:06d}", partial(_trace, capture, tile)
            )
            some = slice(first, first + len(found["alpha"]))
            lit.light[number, some], lit.alpha[some] = found["light"], found["alpha"]
        total += lit.light[number].mean(axis=1, dtype=np.float32)
        if thumbnail is not None:  # as lit by white surroundings, estimated from the suns so far
            thumbnail.add(plan.layout, plan.texel, total * np.float32(4 * np.pi / (number + 1)))
    yield Progress(Stage.CAPTURE, suns * count, suns * count)
    return lit


def _add_sun(scene: bpy.types.Scene, radius: float) -> bpy.types.Object:
    """A sun of irradiance 1 on a plane that faces it, alone in its light group."""
    layer = next(layer for layer in scene.view_layers if layer.use)
    cast(Any, layer).lightgroups.add(name=_GROUP)
    data: Any = bpy.data.lights.new("RadTex sun", "SUN")
    data.energy, data.angle = 1.0, 2 * radius
    sun = bpy.data.objects.new("RadTex sun", data)
    cast(Any, sun).lightgroup = _GROUP
    scene.collection.objects.link(sun)
    return sun


def _turn(sun: bpy.types.Object, direction: Floats) -> None:
    """Let the sun shine from `direction`, by pointing its z axis there."""
    sun.rotation_euler = Vector(direction.tolist()).to_track_quat("Z", "Y").to_euler()


def _trace(capture: PortalCapture, tile: Tile) -> Arrays:
    passes = capture.render_passes(tile)
    light, alpha = passes.in_rec709(passes.raw[_PASS][..., :3]), passes.raw["Combined"][..., 3]
    wrong = int(np.count_nonzero(np.isnan(light)))
    if wrong:
        raise BakeError(
            f"Cycles returned {wrong} values that are not numbers: look for a material that divides by 0"
        )
    return {
        "light": np.clip(light, 0, MOST).astype(np.float16).reshape(len(light), -1, 3),
        "alpha": alpha.astype(np.float16).reshape(len(alpha), -1),
    }
