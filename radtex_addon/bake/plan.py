# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Pack the covered texels, so that no ray is spent on a texel that no island touches.

All captures use one virtual image of `columns` x `rows` buckets, which holds the covered texels in the
atlas's row order. It is cut into sheets of equal height, each a picture with its own seed; their size is in
the specification, so that a farm renders the same ones. A tile is a band of a sheet's rows: one render call.
Cycles seeds its rays by pixel, so where a sheet is cut into tiles does not change the result: tile heights
may follow memory and render time.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from ..core import large_arrays
from ..core.arrays import Bools, Floats, Ints, blocks
from ..core.atlas import AtlasLayout
from ..core.errors import InputError
from ..core.frame import orthonormal_frame
from ..core.gutter import Nearest, dilate, nearest_covered
from ..core.surface import ray_offset
from ..core.texel_map import TexelMap

MIN_IMAGE_SIDE = 4  # Blender renders no smaller picture, in pixels
MAX_IMAGE_SIDE = 65536  # Blender's limit for a render's width and height, in pixels
SHEET = 2048  # default side of a sheet in pixels

_SPREAD = 0x9E3779B1  # step between sheets' seeds: 2^32 over the golden ratio
_SEEDS = 1 << 23  # a farm sets seeds by keyframes: single floats, to which Blender adds 0.5


@dataclass(frozen=True)
class Tile:
    """Rows first_row … first_row + rows - 1 of the packed image, or of a sheet."""

    first_row: int
    rows: int

    @property
    def end(self) -> int:
        """The row after the last one."""
        return self.first_row + self.rows


@dataclass(frozen=True)
class CapturePlan:
    """Where rays start, and the orientation of their buckets, for every covered texel.

    `texel` (K,) is the flat index j * width + i of each covered texel. The five fields are (rows, columns, 3)
    float32 in world space, row-major in the order of `texel`; the last row is filled up with the last texel.
    `own_offset` (rows, columns, 1) is each texel's distance from the surface to where its rays start; None if
    it is the same for all. A sheet has about `sheet`² pixels.
    """

    layout: AtlasLayout
    texel: Ints
    position: Floats
    tangent: Floats
    bitangent: Floats
    normal: Floats
    facet: Floats
    own_offset: Floats | None = None
    sheet: int = field(default=SHEET, kw_only=True)

    @property
    def sheet_rows(self) -> int:
        """Rows of every sheet; the last sheet may reach beyond the plan's last row."""
        n = self.layout.bucket
        most = max(_least(n), self.sheet**2 // (self.columns * n * n))
        return max(_least(n), -(-self.rows // -(-self.rows // most)))

    @property
    def sheets(self) -> int:
        """The number of sheets."""
        return -(-self.rows // self.sheet_rows)

    def window(self, values: npt.NDArray[Any], sheet: int) -> npt.NDArray[Any]:
        """A sheet's rows of values (rows, columns, C): (sheet_rows, columns, C), padded with the last."""
        first = sheet * self.sheet_rows
        rows = np.minimum(np.arange(first, first + self.sheet_rows), self.rows - 1)
        return values[rows]

    def in_sheets(self, tile: Tile) -> Iterator[tuple[int, Tile]]:
        """The sheets that a tile touches, each with the tile's part in it, counted in the sheet's rows."""
        row, height = tile.first_row, self.sheet_rows
        while row < tile.end:
            sheet, first = divmod(row, height)
            rows = min(height - first, tile.end - row)
            yield sheet, Tile(first, rows)
            row += rows

    @cached_property
    def offset(self) -> Floats:
        """How far from the surface rays start, in scene units: (rows, columns, 1) float32."""
        if self.own_offset is not None:
            return self.own_offset
        return np.full((self.rows, self.columns, 1), ray_offset(self.position), dtype=np.float32)

    @property
    def rows(self) -> int:
        return int(self.position.shape[0])

    @property
    def columns(self) -> int:
        return int(self.position.shape[1])

    @property
    def points(self) -> Floats:
        """The texels' positions, without the padding: (K, 3)."""
        return self.position.reshape(-1, 3)[: len(self.texel)]

    @property
    def normals(self) -> Floats:
        """The texels' normals, without the padding: (K, 3)."""
        return self.normal.reshape(-1, 3)[: len(self.texel)]

    @property
    def frames(self) -> Floats:
        """The texels' tangents, bitangents and normals, without the padding: (K, 3, 3)."""
        axes = (self.tangent, self.bitangent, self.normal)
        return np.stack([axis.reshape(-1, 3)[: len(self.texel)] for axis in axes], axis=1)

    @cached_property
    def covered(self) -> Bools:
        """Where the plan's texels lie: (H, W)."""
        return self.placed(np.ones(len(self.texel), dtype=bool))

    @cached_property
    def _nearest(self) -> Nearest:
        return nearest_covered(self.covered)

    def moved_to(self, points: Floats) -> CapturePlan:
        """The same with rays that start at other points (K, 3)."""
        flat = large_arrays.empty((self.rows * self.columns, 3))
        flat[: len(points)], flat[len(points) :] = points, points[-1]
        return replace(self, position=flat.reshape(self.position.shape))

    def placed(self, values: npt.NDArray[Any], gutter: bool = False) -> npt.NDArray[Any]:
        """Put the texels' values (K, ...) at their places in the atlas: (H, W, ...) of the same dtype.

        Elsewhere 0, or with `gutter` the value of the nearest texel.
        """
        height, width = self.layout.height, self.layout.width
        flat = large_arrays.zeros((height * width, *values.shape[1:]), values.dtype)
        flat[self.texel] = values
        image = flat.reshape(height, width, *values.shape[1:])
        return dilate(image, self._nearest) if gutter else image

    def texels_of(self, tile: Tile) -> Ints:
        """Flat indices of the tile's texels: (k,), without the padding of the last row."""
        first = tile.first_row * self.columns
        return self.texel[first : first + tile.rows * self.columns]


def plan_of_some(plan: CapturePlan, chosen: Bools) -> CapturePlan:
    """The plan of only the texels where `chosen` (K,) is True; at least one must be."""
    return plan_of_picked(plan, np.flatnonzero(chosen))


def plan_of_picked(plan: CapturePlan, picked: Ints) -> CapturePlan:
    """The plan of the texels with the numbers `picked` (N,), at least one, as often as they come."""
    rows, columns = _shape(len(picked), plan.layout.bucket, plan.sheet)
    padded = picked[np.minimum(np.arange(rows * columns), len(picked) - 1)]

    def pack(values: Floats) -> Floats:
        packed = large_arrays.taken(values.reshape(plan.rows * plan.columns, -1), padded)
        return packed.reshape(rows, columns, -1)

    return CapturePlan(
        plan.layout,
        plan.texel[picked],
        pack(plan.position),
        pack(plan.tangent),
        pack(plan.bitangent),
        pack(plan.normal),
        pack(plan.facet),
        None if plan.own_offset is None else pack(plan.own_offset),
        sheet=plan.sheet,
    )


def plan_capture(
    texels: TexelMap, bucket: int, without: Ints | None = None, sheet: int = SHEET
) -> CapturePlan:
    """Pack a texel map's covered texels for sheets of about `sheet`² pixels, leaving out `without`.

    `without` are flat indices of texels. Raises InputError if no texel is left.
    """
    height, width = texels.triangle.shape
    texel = np.flatnonzero(texels.triangle >= 0)
    if without is not None:
        texel = np.setdiff1d(texel, without, assume_unique=True)
    if not len(texel):
        raise InputError("the UV layer covers no texel: give the bake more texels, or unwrap the mesh again")
    rows, columns = _shape(len(texel), bucket, sheet)
    padded = texel[np.minimum(np.arange(rows * columns), len(texel) - 1)]

    def pack(values: Floats) -> Floats:
        flat = values.reshape(height * width, -1)
        packed = large_arrays.from_blocks(len(padded), lambda some: flat[padded[some]].astype(np.float32))
        return packed.reshape(rows, columns, -1)

    normal, tangent, sign = pack(texels.normal), pack(texels.tangent), pack(texels.sign[..., None])
    bitangent = _orthonormal(normal, tangent, sign)
    layout = AtlasLayout(width, height, bucket)
    return CapturePlan(
        layout,
        texel,
        pack(texels.position),
        tangent,
        bitangent,
        normal,
        pack(texels.facet),
        None if texels.offset is None else pack(texels.offset[..., None]),
        sheet=sheet,
    )


def _orthonormal(normal: Floats, tangent: Floats, sign: Floats) -> Floats:
    """Make the frames' normals and tangents orthonormal, in place; their bitangents (rows, columns, 3)."""
    bitangent = large_arrays.empty(normal.shape)
    frames = [one.reshape(-1, 3) for one in (tangent, bitangent, normal)]
    for some in blocks(len(frames[0])):
        found = orthonormal_frame(frames[2][some], frames[0][some], sign.reshape(-1)[some])
        for kept, axis in zip(frames, found, strict=True):
            kept[some] = axis
    return bitangent


def sheet_seed(seed: int, sheet: int) -> int:
    """The seed that Cycles gets for a sheet; the first sheet has the bake's own."""
    return (seed + sheet * _SPREAD) % _SEEDS if sheet else seed


def _least(bucket: int) -> int:
    """The fewest buckets along a side that make a picture that Blender can render."""
    return -(-MIN_IMAGE_SIDE // bucket)


def _shape(count: int, bucket: int, sheet: int) -> tuple[int, int]:
    """Rows and columns of the packed image of `count` texels."""
    least = _least(bucket)
    columns = _columns(count, least, max(least, min(sheet, MAX_IMAGE_SIDE) // bucket))
    return max(least, -(-count // columns)), columns


def _columns(count: int, least: int, most: int) -> int:
    """Columns of a nearly square grid for `count` texels with the fewest empty places, `most` at most."""
    square = min(int(np.ceil(np.sqrt(count))), most)
    candidates = np.arange(max(least, square // 2), max(least, min(most, 2 * square)) + 1)
    waste, rows = -count % candidates, -(-count // candidates)
    stretched = np.maximum(rows, candidates) > 5 * np.minimum(rows, candidates)
    return int(candidates[np.lexsort((np.abs(candidates - square), waste, stretched))[0]])
