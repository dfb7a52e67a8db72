# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Capture single paths: light in many directions, and where paths end.

All captures use the portal's rays, aimed at known points of their cells. Each needs a scratch scene of its
own, to which it adds its planes and camera.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from functools import cached_property, partial
from pathlib import Path
from typing import TypeAlias

import bpy
import numpy as np

from ..bake.light_samples import (
    EndSamples,
    LightSamples,
    cells_of,
    spread_shifts,
)
from ..bake.piece_store import NO_STORE, Arrays, PieceStore, in_shares
from ..bake.plan import CapturePlan, Tile
from ..bake.progress import Progress, Stage
from ..bake.thumbnail import Thumbnail
from ..core import large_arrays
from ..core.arrays import Bools, Floats
from ..settings.kinds import Kind
from .passes import Passes, attributes_of, colour_of, light_of, raw_light_of
from .path_ends import TURNS, PathEnds, any_dark, from_directions
from .portal import Aim, PortalCapture, SheetCapture

TILE_PIXELS = 3 << 20
LIGHT, ENDS = "light", "ends"  # pieces begin with these and a hyphen
_TEXELS_AT_ONCE = 1 << 12
LOBES = {"diffuse": "diffuse", "mirrored": "glossy", "through": "transmission"}  # Cycles's names
DIFFUSE, MIRRORED, THROUGH = map(attributes_of, LOBES.values())
EMISSION = attributes_of("emission")
EMITTED = (None, 0)  # what the light of ends' sheets is that are rendered elsewhere: see `PathEnds`

# All passes of a sheet: of LIGHT (0), or of ENDS by the number of the EMITTED light; then the sheet's number
Sheets: TypeAlias = Callable[[int, int], Passes]
_Capture: TypeAlias = PortalCapture | SheetCapture


def light_aim(plan: CapturePlan, seed: int, glows: bool = False) -> Aim:
    """How the rays of light are aimed; where the surface `glows`, they tell what it emits."""
    passes = DIFFUSE + THROUGH + (EMISSION if glows else ())
    return Aim(spread_shifts(len(plan.texel), seed), passes)


def ends_aim(plan: CapturePlan, seed: int) -> Aim:
    """How the rays are aimed that find where paths end."""
    return Aim(spread_shifts(len(plan.texel), seed + 2), MIRRORED + THROUGH)


def show_sheets(scene: bpy.types.Scene, plan: CapturePlan, aim: Aim, seed: int, folder: Path) -> None:
    """Set a scene up for all sheets of a capture: it renders any of them, as `PortalCapture` says."""
    PortalCapture(scene, plan, Kind.RADIANCE, 1, seed, folder, aim, whole=True)


def capture_samples(
    scene: bpy.types.Scene,
    plan: CapturePlan,
    hidden: Bools,
    seed: int,
    folder: Path,
    store: PieceStore = NO_STORE,
    thumbnail: Thumbnail | None = None,
    sheets: Sheets | None = None,
    glows: bool = False,
) -> Generator[Progress, None, LightSamples]:
    """Trace one path in each of the plan's cells.

    `hidden` (K, m, m) marks hidden cells, on a coarser grid. `sheets` that were rendered elsewhere take the
    place of renders. Where the surface `glows`, what it emits is told apart. Yields progress in texels.
    Raises BakeError where Cycles fails.
    """
    count, cells = len(plan.texel), plan.layout.bucket**2
    aim = light_aim(plan, seed, glows)
    capture: _Capture
    if sheets is None:
        capture = PortalCapture(scene, plan, Kind.RADIANCE, 1, seed, folder, aim)
    else:
        capture = SheetCapture(plan, partial(sheets, 0))
    kinds = (*LOBES, "emitted") if glows else tuple(LOBES)
    samples: Arrays = {name: large_arrays.empty((count, cells, 3), np.float16) for name in kinds}
    samples["colour"] = np.empty((count, 3), dtype=np.float32)
    tiles = tiles_of(plan)
    names = [_name(LIGHT, tile) for tile in tiles]
    for number in in_shares(store, names):
        tile = tiles[number]
        first = tile.first_row * plan.columns
        yield Progress(Stage.CAPTURE, first, count)
        found = store.get_or_make(names[number], partial(_trace_light, capture, tile, cells, glows))
        for name, whole in samples.items():
            whole[first : first + len(found[name])] = found[name]
        if thumbnail is not None:
            light = np.sum([found[lobe].mean(axis=1, dtype=np.float32) for lobe in LOBES], axis=0)
            thumbnail.add(plan.layout, plan.texels_of(tile), light)
    yield Progress(Stage.CAPTURE, count, count)
    square = aim.squares(plan.layout.bucket)
    return LightSamples(plan, square, seen=_seen(square, hidden), **samples)


def _seen(square: Floats, hidden: Bools) -> Bools:
    """Which samples at bucket coordinates (K, S, 2) are in cells that are not `hidden` (K, m, m): (K, S)."""
    seen = large_arrays.empty(square.shape[:2], bool)
    for first in range(0, len(seen), _TEXELS_AT_ONCE):
        some = slice(first, first + _TEXELS_AT_ONCE)
        cell = cells_of(square[some], hidden.shape[1])
        seen[some] = ~np.take_along_axis(hidden[some].reshape(len(cell), -1), cell, axis=1)
    return seen


def _trace_light(capture: _Capture, tile: Tile, cells: int, glows: bool) -> Arrays:
    passes = capture.render_passes(tile)
    diffuse, through = _light(passes, "diffuse"), _light(passes, "through")
    mirrored = passes.whole[..., :3] - diffuse - through
    lobes = {"diffuse": diffuse, "mirrored": mirrored, "through": through}
    if glows:
        lobes["emitted"] = light_of(passes, "emission")
    found: Arrays = {name: _half(light).reshape(-1, cells, 3) for name, light in lobes.items()}
    found["colour"] = colour_of(passes, "diffuse").reshape(-1, cells, 3).mean(axis=1)
    return found


def capture_ends(
    ends: PathEnds,
    plan: CapturePlan,
    seed: int,
    folder: Path,
    store: PieceStore = NO_STORE,
    sheets: Sheets | None = None,
) -> EndSamples:
    """Find where a path from each of the plan's cells ends, and how much of it the object lets through.

    `sheets` that were rendered elsewhere take the place of renders in the EMITTED lights. Raises BakeError
    where Cycles fails.
    """
    count, cells = len(plan.texel), plan.layout.bucket**2
    aim = ends_aim(plan, seed)
    capture = _EndsCapture(ends, plan, seed, folder, aim, sheets)
    parts: Arrays = {}
    tiles = tiles_of(plan)
    names = [_name(ENDS, tile) for tile in tiles]
    for number in in_shares(store, names):
        first = tiles[number].first_row * plan.columns
        found = store.get_or_make(names[number], partial(_trace_ends, capture, tiles[number]))
        for name, part in found.items():
            if name not in parts:
                parts[name] = large_arrays.empty((count, cells, 3), np.float16)
            whole = parts[name]
            whole[first : first + len(part)] = part.reshape(len(part), cells, 3)
    return EndSamples(plan, aim.squares(plan.layout.bucket), **parts)


class _EndsCapture:
    """Renders tiles in one light after another, or takes them from `sheets` where these have that light."""

    def __init__(
        self, ends: PathEnds, plan: CapturePlan, seed: int, folder: Path, aim: Aim, sheets: Sheets | None
    ) -> None:
        self._ends, self._plan, self._aim = ends, plan, aim
        self._seed, self._folder, self._sheets = seed, folder, sheets

    def render_passes(self, tile: Tile, turn: int | None) -> Passes:
        """A tile's passes in the light of directions at a turn, or in white light if None."""
        if self._sheets is not None and turn in EMITTED:
            return SheetCapture(self._plan, partial(self._sheets, EMITTED.index(turn))).render_passes(tile)
        renders = self._renders
        if turn is None:
            self._ends.emit_white()
        else:
            self._ends.emit_directions(turn)
        with self._ends.named_alike():
            return renders.render_passes(tile)

    @cached_property
    def _renders(self) -> PortalCapture:
        return PortalCapture(
            self._ends.scene, self._plan, Kind.RADIANCE, 1, self._seed, self._folder, self._aim
        )


def _trace_ends(capture: _EndsCapture, tile: Tile) -> Arrays:
    white = capture.render_passes(tile, None)
    weights = {lobe: raw_light_of(white, LOBES[lobe]) for lobe in ("mirrored", "through")}
    deep = any(any_dark(weight) for weight in weights.values())  # colours with an almost black channel
    emitted = [capture.render_passes(tile, turn) for turn in range(TURNS if deep else 1)]
    found: Arrays = {}
    for lobe, weight in weights.items():
        coded = [raw_light_of(passes, LOBES[lobe]) for passes in emitted]  # directions, not colours
        end = from_directions(coded, weight)
        found[f"{lobe}_weight"] = np.maximum(white.in_rec709(weight), 0).astype(np.float16)
        found[f"{lobe}_end"] = end.astype(np.float16)
    return found


def _name(what: str, tile: Tile) -> str:
    return f"{what}-{tile.first_row:06d}"


def straight_shifts(count: int) -> Floats:
    """Shifts that aim almost along the normal: the exact middle of a bucket has no azimuth."""
    return np.broadcast_to(np.float64(0.51), (count, 2))


def tiles_of(plan: CapturePlan, samples: int = 1) -> list[Tile]:
    """The tiles in which a plan of so many `samples` for each ray is rendered."""
    rows = rows_of_tiles(plan.columns, plan.layout.bucket, samples)
    return [Tile(row, min(rows, plan.rows - row)) for row in range(0, plan.rows, rows)]


def rows_of_tiles(columns: int, bucket: int, samples: int = 1) -> int:
    """The rows of each tile, but the last, of a plan of so many columns of buckets."""
    return max(1, TILE_PIXELS // (columns * bucket**2 * samples))


def _light(passes: Passes, lobe: str) -> Floats:
    return light_of(passes, LOBES[lobe])


def _half(light: Floats) -> Floats:
    """Light as half floats, limited to their range; NaN, which faulty shaders return, becomes black."""
    limited: Floats = np.clip(np.nan_to_num(light, nan=0.0), 0, 65504).astype(np.float16)
    return limited
