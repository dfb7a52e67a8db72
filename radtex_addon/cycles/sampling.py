# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the shared layout is fitted to: light in many directions, what mirror rays meet, the diffuse colour.

All three are the portal's rays, aimed at known points of their cells. Each capture takes a scratch scene of
its own, which it fills with its apparatus.
"""

from __future__ import annotations

from collections.abc import Generator
from pathlib import Path

import bpy
import numpy as np

from ..bake.light_samples import LightSamples, Meetings, cells_of, spread_shifts
from ..bake.plan import CapturePlan, Tile
from ..bake.progress import Progress, Stage
from ..bake.spec import Kind
from ..core.arrays import Bools, Floats
from ..core.gutter import dilate, nearest_covered
from .portal import Aim, PortalCapture
from .settings import first_hit_only

_TILE_PIXELS = 3 << 20
_ITSELF = 1  # the baked object's index; the others' is 0
_DIFFUSE = ("use_pass_diffuse_direct", "use_pass_diffuse_indirect", "use_pass_diffuse_color")
# Blender 5's names of passes, and 4.5's
_NAMES = {
    "direct": ("Diffuse Direct", "DiffDir"),
    "indirect": ("Diffuse Indirect", "DiffInd"),
    "colour": ("Diffuse Color", "DiffCol"),
    "index": ("Object Index", "IndexOB"),
}

Passes = dict[str, Floats]


def capture_samples(
    scene: bpy.types.Scene, plan: CapturePlan, hidden: Bools, seed: int, folder: Path
) -> Generator[Progress, None, LightSamples]:
    """Trace one path in each of the plan's cells.

    `hidden` (K, m, m) marks directions, by coarser cells, that no viewer sees. Yields progress in texels.
    Raises BakeError where Cycles fails.
    """
    count, cells = len(plan.texel), plan.layout.bucket**2
    aim = Aim(spread_shifts(count, seed), _DIFFUSE)
    capture = PortalCapture(scene, plan, Kind.RADIANCE, 1, seed, folder, aim)
    radiance, diffuse = (np.empty((count, cells, 3), dtype=np.float16) for _ in range(2))
    colour = np.empty((count, 3), dtype=np.float32)
    for tile in _tiles(plan):
        first = tile.first_row * plan.columns
        yield Progress(Stage.CAPTURE, first, count)
        passes = capture.render_passes(tile)
        part = slice(first, first + len(passes["Combined"]))
        own = _pass(passes, "colour")
        light = (_pass(passes, "direct") + _pass(passes, "indirect")) * own
        radiance[part] = _half(passes["Combined"][..., :3]).reshape(-1, cells, 3)
        diffuse[part] = _half(light).reshape(-1, cells, 3)
        colour[part] = own.reshape(-1, cells, 3).mean(axis=1)
    yield Progress(Stage.CAPTURE, count, count)
    square = aim.square(plan.layout.bucket)
    unseen = np.take_along_axis(hidden.reshape(count, -1), cells_of(square, hidden.shape[1]), axis=1)
    return LightSamples(plan, square, radiance, diffuse, colour, ~unseen)


def capture_meetings(
    scene: bpy.types.Scene, baked: bpy.types.Object, plan: CapturePlan, seed: int, folder: Path
) -> Meetings:
    """Find what a mirror-bound ray from each of the plan's cells meets; `baked` is the scene's own object."""
    for item in scene.objects:
        item.pass_index = 0
    baked.pass_index = _ITSELF
    cells = plan.layout.bucket**2
    aim = Aim(spread_shifts(len(plan.texel), seed + 1), ("use_pass_position", "use_pass_object_index"))
    capture = PortalCapture(scene, plan, Kind.REFLECTION, 1, seed, folder, aim)
    first_hit_only(scene)
    tiles = [capture.render_passes(tile) for tile in _tiles(plan)]
    point = np.concatenate([tile["Position"][..., :3] for tile in tiles]).reshape(-1, cells, 3)
    index = np.concatenate([_pass(tile, "index")[..., 0] for tile in tiles]).reshape(-1, cells)
    return Meetings(
        square=aim.square(plan.layout.bucket),
        point=point,
        nothing=(point == 0).all(axis=-1),  # the world's position is none
        itself=np.abs(index - _ITSELF) < 0.5,
    )


def capture_colour(scene: bpy.types.Scene, plan: CapturePlan, seed: int, folder: Path) -> Floats:
    """The diffuse colour along the normal, for a plan of one cell a bucket: (H, W, 3), gutter filled."""
    layout = plan.layout
    shift = np.full((len(plan.texel), 2), 0.6)  # the very middle has no azimuth
    capture = PortalCapture(scene, plan, Kind.RADIANCE, 1, seed, folder, Aim(shift, _DIFFUSE))
    first_hit_only(scene)
    flat = np.zeros((layout.height * layout.width, 3), dtype=np.float32)
    for tile in _tiles(plan):
        flat[plan.texels_of(tile)] = _pass(capture.render_passes(tile), "colour").reshape(-1, 3)
    covered = np.zeros(len(flat), dtype=bool)
    covered[plan.texel] = True
    image = flat.reshape(layout.height, layout.width, 3)
    dilate(image, nearest_covered(covered.reshape(image.shape[:2])))
    return image


def _tiles(plan: CapturePlan) -> list[Tile]:
    rows = max(1, _TILE_PIXELS // (plan.columns * plan.layout.bucket**2))
    return [Tile(row, min(rows, plan.rows - row)) for row in range(0, plan.rows, rows)]


def _pass(passes: Passes, name: str) -> Floats:
    return next(passes[known][..., :3] for known in _NAMES[name] if known in passes)


def _half(light: Floats) -> Floats:
    limited: Floats = np.clip(light, 0, 65504).astype(np.float16)
    return limited
