# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Denoise captured cells: for each direction the picture over neighbouring texels, guided by their mean.

The mean of a texel's cells has the noise of all its paths together, so little. It is denoised first, shows
the denoiser every border on the surface, and at the end scales each texel's cells: what is stored keeps that
mean. The means themselves keep their sum over squares of 2 * _REACH + 1 texels.

Texels are denoised in squares of the atlas, each with a margin, so that memory does not grow with the atlas.
Buckets with more cells than there are texels are pictures themselves: these are denoised one by one.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ..core.arrays import Floats, Ints
from ..core.gutter import nearest_covered
from .cells import GAP, Cells
from .hidden_cells import HiddenCells
from .layers import OF_LAYER, WHOLE, Layer
from .piece_store import PieceStore
from .plan import CapturePlan
from .progress import Progress, Stage

_CORE = (32, 128)  # texels along the side of a square that is denoised at once: the least and the most
_MARGIN = 16  # texels around it that the denoiser sees, too
_MOST_PIXELS = 1 << 20  # of a picture that is given to the denoiser, unless one direction has more
_MOST_CELLS = 1 << 21  # denoised at once, margins included, unless the squares are the least
_REACH = 8  # texels: means keep their sum over squares of 2 * _REACH + 1 texels
_MOST_SUM = 1.25  # the most that sums, and
_MOST_MEAN = 4.0  # means are scaled by
_DENOISED = "denoised"  # the array's name in a square's piece
_BYTES_PER_CHANNEL = 12  # of cells that are denoised: as read, as a result, and as stored
_BYTES_PER_CELL = 40  # its light above 0, and as denoised, and their copies
_BYTES_PER_PIXEL = 850  # of a picture in Blender, with its guides and the network
_TINY = 1e-6
_OPAQUE = 1e-4  # alphas that differ by less are not denoised


class Denoiser(Protocol):
    """A denoiser of pictures, such as `cycles.denoiser.ImageDenoiser`."""

    def __call__(self, light: Floats, albedo: Floats, normal: Floats, /) -> Floats:
        """Denoise a picture: all are (H, W, 3) float32, `light` linear, `albedo` 0 to 1, `normal` units."""
        ...


@dataclass(frozen=True, eq=False)
class Picture:
    """Where K points lie in a picture: `place` (K,) flat pixels; `nearest` (H, W), the point that each shows.

    `normal` (K, 3) are the points' normals.
    """

    place: Ints
    nearest: Ints
    normal: Floats

    def shown(self, values: Floats) -> Floats:
        """Values (K, ...) as a picture (H, W, ...)."""
        picture: Floats = values[self.nearest]
        return picture

    def read(self, picture: Floats) -> Floats:
        """The points' values (K, ...) in a picture (H, W, ...)."""
        values: Floats = picture.reshape(-1, *picture.shape[2:])[self.place]
        return values


@dataclass(frozen=True, eq=False)
class _Square:
    """A square of the atlas: the plan's texels around it (k,), which of them are its own, their picture."""

    texels: Ints
    own: Ints
    picture: Picture


def denoise_pictures(values: Floats, picture: Picture, denoiser: Denoiser) -> Floats:
    """Denoise the light (K, M, 3) of K points in M pictures, which show the same points: (K, M, 3) float32.

    Values below 0 are kept as they are. Each point's mean over the pictures is that of the denoised means.
    """
    light = np.maximum(values, 0).astype(np.float32)
    mean = light.mean(axis=1)
    smooth = _denoised_mean(mean, picture, denoiser)
    guide = smooth / (smooth + max(float(smooth.mean()), _TINY))
    height, width = picture.nearest.shape
    count = light.shape[1]
    most = max(1, _MOST_PIXELS // (height * width))
    found = np.empty(light.shape, dtype=np.float32)
    for first in range(0, count, most):
        some = slice(first, min(first + most, count))
        number = some.stop - first
        columns = int(np.ceil(np.sqrt(number)))
        rows = -(-number // columns)
        which = np.minimum(np.arange(rows * columns), number - 1) + first

        def mosaic(shown: Floats, rows: int = rows, columns: int = columns) -> Floats:
            side_by_side = shown.reshape(height, width, rows, columns, 3).transpose(2, 0, 3, 1, 4)
            return np.ascontiguousarray(side_by_side).reshape(rows * height, columns * width, 3)

        guides = (np.tile(picture.shown(field), (rows, columns, 1)) for field in (guide, picture.normal))
        done = denoiser(mosaic(picture.shown(light[:, which])), *guides)
        apart = done.reshape(rows, height, columns, width, 3).transpose(1, 3, 0, 2, 4)
        found[:, some] = picture.read(apart.reshape(height, width, -1, 3)[:, :, :number])
    found = np.maximum(found, 0)
    share = smooth / np.maximum(found.mean(axis=1), _TINY)
    found *= np.clip(share, 1 / _MOST_MEAN, _MOST_MEAN)[:, None]
    least = _least_around(light.min(axis=1), picture)
    most_light = -_least_around(-light.max(axis=1), picture)
    np.clip(found, least[:, None], most_light[:, None], out=found)  # networks overshoot
    return found + np.minimum(values, 0)


def _least_around(values: Floats, picture: Picture) -> Floats:
    """The least of values (K, C) among a point and the eight around it."""
    height, width = picture.nearest.shape
    padded = np.pad(picture.shown(values), ((1, 1), (1, 1), (0, 0)), mode="edge")
    least = padded[1:-1, 1:-1].copy()
    for y in range(3):
        for x in range(3):
            np.minimum(least, padded[y : y + height, x : x + width], out=least)
    return picture.read(least)


def _denoised_mean(mean: Floats, picture: Picture, denoiser: Denoiser) -> Floats:
    """Denoise points' means (K, 3), and scale them by what their surroundings lost or won."""
    shown = picture.shown(mean)
    done = denoiser(shown, np.ones_like(shown), picture.shown(picture.normal))
    smooth = np.maximum(picture.read(done), 0)
    own = np.zeros((2, *shown.shape), dtype=np.float64)
    own.reshape(2, -1, 3)[:, picture.place] = mean, smooth
    before, after = _sums_around(own)
    share = picture.read(before / np.maximum(after, _TINY))
    scaled: Floats = (smooth * np.clip(share, 1 / _MOST_SUM, _MOST_SUM)).astype(np.float32)
    return scaled


def _sums_around(values: Floats) -> Floats:
    """Sums over squares of 2 * _REACH + 1 pixels of (N, H, W, C), cut off at the borders."""
    for axis in (1, 2):
        size = values.shape[axis]
        total = np.insert(values.cumsum(axis=axis), 0, 0, axis=axis)
        place = np.arange(size)
        high, low = np.minimum(place + _REACH + 1, size), np.maximum(place - _REACH, 0)
        values = total.take(high, axis=axis) - total.take(low, axis=axis)
    return values


def window_picture(plan: CapturePlan, rows: slice, columns: slice) -> tuple[Ints, Picture] | None:
    """The plan's texels (k,) in a window of the atlas, and their picture; None if no texel is covered."""
    width = plan.layout.width
    first = np.searchsorted(plan.texel, rows.start * width)
    end = np.searchsorted(plan.texel, rows.stop * width)
    j, i = np.divmod(plan.texel[first:end], width)
    inside = (i >= columns.start) & (i < columns.stop)
    texels = np.flatnonzero(inside) + first
    if not len(texels):
        return None
    j, i = j[inside] - rows.start, i[inside] - columns.start
    number = np.full((rows.stop - rows.start, columns.stop - columns.start), -1, dtype=np.int64)
    number[j, i] = np.arange(len(texels))
    nearest = number[nearest_covered(number >= 0)]
    return texels, Picture(j * number.shape[1] + i, nearest, plan.normals[texels].astype(np.float32))


def square_side(pictures: int) -> int:
    """Texels along the side of a square of cells that are denoised at once, without its margin."""
    return int(np.clip(int((_MOST_CELLS / pictures) ** 0.5) - 2 * _MARGIN, *_CORE))


def denoising_bytes(texels: int, bucket: int, channels: int) -> int:
    """The most memory that denoising an atlas of `texels` on a side takes, in bytes."""
    side = min(texels, square_side(bucket**2) + 2 * _MARGIN)
    cells = side**2 * bucket**2
    of_cell = _BYTES_PER_CHANNEL * channels + _BYTES_PER_CELL
    return cells * of_cell + min(cells, _MOST_PIXELS) * _BYTES_PER_PIXEL


def squares(plan: CapturePlan, pictures: int) -> Iterator[_Square]:
    """The squares of an atlas of so many `pictures` that hold texels, from its first row on."""
    height, width = plan.layout.height, plan.layout.width
    side = square_side(pictures)
    for top in range(0, height, side):
        for left in range(0, width, side):
            rows = slice(max(top - _MARGIN, 0), min(top + side + _MARGIN, height))
            columns = slice(max(left - _MARGIN, 0), min(left + side + _MARGIN, width))
            found = window_picture(plan, rows, columns)
            if found is None:
                continue
            texels, picture = found
            j, i = np.divmod(plan.texel[texels], width)
            own = (j >= top) & (j < top + side) & (i >= left) & (i < left + side)
            if own.any():
                yield _Square(texels, np.flatnonzero(own), picture)


class DenoisedCells(Cells):
    """The denoised cells of a plan's texels, as `Cells`, in pieces of squares."""

    def __init__(self, plan: CapturePlan, store: PieceStore, channels: int) -> None:
        super().__init__(plan, store, channels)
        self._piece = np.zeros(len(plan.texel), dtype=np.int32)  # the number of each texel's piece,
        self._row = np.zeros(len(plan.texel), dtype=np.int32)  # and its row there
        self._pieces = 0

    def add(self, texels: Ints, cells: Floats | None) -> None:
        """Store the denoised cells (k, n, n, C) of texels (k,); None if they are stored already."""
        if cells is not None:
            self._store.keep(self.name(self._pieces), {_DENOISED: np.ascontiguousarray(cells)})
        self._piece[texels], self._row[texels] = self._pieces, np.arange(len(texels))
        self._pieces += 1

    def name(self, number: int) -> str:
        """The name of a piece."""
        return f"denoised-{number:06d}"

    def has(self, texels: Ints) -> bool:
        """Whether the next piece is stored already, with so many texels."""
        kept = self._store.found(self.name(self._pieces))
        n = self._plan.layout.bucket
        found = None if kept is None else kept.get(_DENOISED)
        return found is not None and found.shape == (len(texels), n, n, self.channels)

    def take(self, index: Ints) -> Floats:
        """As `Cells.take`."""
        n = self._plan.layout.bucket
        found: Floats = np.empty((len(index), n, n, self.channels), dtype=np.float32)
        piece, row = self._piece[index], self._row[index]
        for number in np.unique(piece).tolist():
            mine = np.flatnonzero(piece == number)
            mine = mine[np.argsort(row[mine], kind="stable")]
            for run in np.split(mine, np.flatnonzero(np.diff(row[mine]) > GAP) + 1):
                first = int(row[run[0]])
                count = int(row[run[-1]]) - first + 1
                rows = self._store.rows(self.name(number), _DENOISED, first, count)
                found[run] = rows[row[run] - first]
        return found


def denoise_cells(
    plan: CapturePlan,
    cells: Cells,
    store: PieceStore,
    hidden: HiddenCells | None,
    denoiser: Denoiser,
    layers: tuple[Layer, ...] = (),
) -> Generator[Progress, None, DenoisedCells]:
    """Denoise all `cells` of a plan; `layers` are those whose channels follow the first four.

    Yields progress in texels. Alpha is denoised where it is not the same everywhere, and normals are not.
    """
    found = DenoisedCells(plan, store, cells.channels)
    count, done = len(plan.texel), 0
    pictures = plan.layout.bucket**2 > count
    for square in _buckets(plan) if pictures else squares(plan, plan.layout.bucket**2):
        yield Progress(Stage.DENOISE, done, count)
        own = square.texels[square.own]
        new = None
        if not found.has(own):
            values = cells.take(square.texels)
            if hidden is not None:
                _cover_hidden(values, hidden, square.texels)
            new = _denoised(values, square.picture, denoiser, layers, pictures)[square.own]
        found.add(own, new)
        done += len(own)
    yield Progress(Stage.DENOISE, count, count)
    return found


def _buckets(plan: CapturePlan) -> Iterator[_Square]:
    """Groups of texels whose buckets are denoised as pictures."""
    n, count = plan.layout.bucket, len(plan.texel)
    cell = np.arange(n * n)
    up = np.tile(np.array([0, 0, 1], dtype=np.float32), (n * n, 1))
    picture = Picture(cell, cell.reshape(n, n), up)
    most = max(1, _MOST_CELLS // (n * n))
    for first in range(0, count, most):
        texels = np.arange(first, min(first + most, count))
        yield _Square(texels, np.arange(len(texels)), picture)


def _cover_hidden(values: Floats, hidden: HiddenCells, texels: Ints) -> None:
    """Give hidden cells of `values` (k, n, n, C) the mean of their texel's others: nobody will see them."""
    marks = HiddenCells(hidden.bits[texels], hidden.bucket).cells[..., None]
    seen = np.maximum((~marks).sum(axis=(1, 2)), 1)
    mean = np.where(marks, 0, values).sum(axis=(1, 2)) / seen
    np.copyto(values, mean[:, None, None], where=marks)


def _denoised(
    values: Floats, picture: Picture, denoiser: Denoiser, layers: tuple[Layer, ...], buckets: bool
) -> Floats:
    """Denoise the cells (k, n, n, C) of a square."""
    flat = values.reshape(len(values), -1, values.shape[-1])
    result = flat.copy()

    def denoised(light: Floats) -> Floats:
        if buckets:
            return denoise_pictures(light.transpose(1, 0, 2), picture, denoiser).transpose(1, 0, 2)
        return denoise_pictures(light, picture, denoiser)

    lights = [slice(0, 3)]
    for number, layer in enumerate(layers):
        if layer is not Layer.NORMAL:
            lights.append(slice(WHOLE + OF_LAYER * number, WHOLE + OF_LAYER * (number + 1)))
    for channels in lights:
        result[..., channels] = denoised(flat[..., channels])
    alpha = flat[..., 3:WHOLE]
    if float(np.ptp(alpha)) > _OPAQUE:
        result[..., 3] = np.clip(denoised(alpha.repeat(3, axis=2)).mean(axis=2), 0, 1)
    return result.reshape(values.shape)
