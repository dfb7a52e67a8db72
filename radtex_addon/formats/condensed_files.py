# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Convert a condensed atlas to and from GPU textures."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..core.arrays import Floats
from ..core.condensed import CondensedAtlas, CondensedLobe
from ..core.errors import BakeError, FormatError
from ..core.shared import Axis
from .codecs.bc5 import decode_bc5, encode_bc5
from .codecs.bc6h import decode_bc6h, encode_bc6h
from .codecs.bc7 import Blocks, decode_bc7, encode_bc7
from .condensed_packing import (
    layer_values,
    pack_tiles,
    pack_weights,
    unpack_tiles,
    unpack_weights,
    value_range,
)
from .condensed_sidecar import CondensedFacts, Tiles, as_range
from .condensed_sizes import columns_of, texture_format
from .containers.dds import DdsFormat, read_dds
from .containers.exr import HALF_MOST
from .disk.memory import check_memory
from .disk.regular import open_regular
from .packing import (
    COLOUR,
    IRRADIANCE,
    SURROUNDINGS,
    TEXTURES,
    WEIGHTS,
    ends_unit,
    lobe_layer,
    unpack_surroundings,
)
from .shared_sidecar import SharedSidecar

# The range of values that a texture can hold; each lobe's tiles have a narrower range of their own.
LIMITS = {
    DdsFormat.BC6H_UF16: (0.0, HALF_MOST),
    DdsFormat.R8G8B8A8_UNORM: (-1.0, 1.0),
    DdsFormat.BC5_UNORM: (-HALF_MOST, HALF_MOST),
    DdsFormat.BC7_UNORM: (-HALF_MOST, HALF_MOST),
}
_ALIKE = 1e-6  # a colour image whose values differ by no more is one colour

_SIDE = DdsFormat.BC6H_UF16.side  # pixels along a block's side
_DECODERS = {
    DdsFormat.BC5_UNORM: decode_bc5,
    DdsFormat.BC6H_UF16: decode_bc6h,
    DdsFormat.BC7_UNORM: decode_bc7,
}
_DECODED = 16  # bytes of a pixel: four floats


@dataclass(frozen=True, eq=False)
class StoredAtlas:
    """The contents of an atlas's textures, clamped to their limits but not yet encoded.

    `atlas` has a small colour image if the colour is the same everywhere. `values` are its `layer_values`,
    split by texture; `clamped` is the number of values that were beyond the limits. `facts` lack the digests.
    """

    atlas: CondensedAtlas
    values: Mapping[str, Floats]
    facts: CondensedFacts
    clamped: int

    @classmethod
    def of(cls, atlas: CondensedAtlas, file_of: Callable[[str], Path]) -> StoredAtlas:
        """Prepare `atlas` for storing; `file_of` gives a layer's path, for errors.

        Raises ShapeError if its maps do not fit each other, BakeError for values that are not numbers.
        """
        atlas = replace(atlas, colour=stored_colour(atlas.colour))
        values, clamped = _by_texture(atlas), 0
        for layer in values:
            values[layer], beyond = _within_limits(file_of(layer), values[layer], texture_format(layer))
            clamped += beyond
        tiles = {
            lobe.axis: Tiles(
                clusters=len(lobe.ends),
                ranges={
                    part: as_range(np.hstack([value_range(values[layer]) for layer in layers]))
                    for part, layers in _part_layers(lobe.axis).items()
                },
            )
            for lobe in atlas.lobes
        }
        rank = atlas.lobes[0].rank if atlas.lobes else 2
        columns = columns_of((lobe.clusters for lobe in tiles.values()), rank)
        return cls(atlas, values, CondensedFacts(rank, columns, tiles, digests={}), clamped)

    def textures(self) -> Iterator[tuple[str, Blocks]]:
        """Yield each layer's name and its texture's blocks, in the files' order."""
        for layer in (COLOUR, IRRADIANCE, SURROUNDINGS):
            yield layer, encode_bc6h(_filled_up(self.values[layer]))
        for lobe in self.atlas.lobes:
            layer = lobe_layer(lobe.axis, WEIGHTS)
            yield layer, pack_weights(lobe.cluster, self.values[layer])
            for part, layers in _part_layers(lobe.axis).items():
                limits = np.array(self.facts.lobes[lobe.axis].ranges[part], np.float32)
                for layer, own in zip(layers, np.split(limits, len(layers), axis=1), strict=True):
                    grid = pack_tiles(self.values[layer], own, self.facts.columns)
                    yield layer, _encoded(grid, texture_format(layer))


def stored_colour(colour: Floats) -> Floats:
    """The colour image (H, W, C) to store: reduced to a block's size if it is the same everywhere."""
    if not colour.size or not np.isfinite(colour).all() or np.ptp(colour, axis=(0, 1)).max() > _ALIKE:
        return colour
    return np.broadcast_to(colour[:1, :1], (_SIDE, _SIDE, colour.shape[2]))


def read_texture(path: Path, layer: str, width: int, height: int) -> Any:
    """Read a texture's pixels (height, width, C): light and tiles (in 0..1) as float32, weights as bytes.

    Raises FormatError, with the path, for a file that is missing, damaged, or of another format or size.
    """
    kind, blocks, *size = read_dds(path)
    expected = texture_format(layer)
    filled = [-(-pixels // expected.side) * expected.side for pixels in (width, height)]
    if kind is not expected or size != filled:
        found = f"{size[0]} x {size[1]} pixels of {kind.name}"
        wanted = f"{filled[0]} x {filled[1]} of {expected.name}"
        raise FormatError(f"{path} has {found}, its sidecar says {wanted}: bake it again")
    if kind is DdsFormat.R8G8B8A8_UNORM:
        return blocks
    try:
        pixels = _DECODERS[kind](blocks)
    except FormatError as error:
        raise FormatError(f"{path}: {error}") from error
    return pixels[:height, :width]


def read_textures(path: Path, sidecar: SharedSidecar, file_of: Callable[[str], Path]) -> CondensedAtlas:
    """Read the atlas of the condensed bake with this `sidecar`, which is the file `path`; float32.

    `file_of` gives the path of a layer's texture. Raises FormatError, with the path, for a bake that is not
    condensed, for textures too large for this machine's memory or of another bake, and as `read_texture`.
    """
    facts = sidecar.condensed
    if facts is None:
        raise FormatError(f"{path} is of a bake that is not condensed: its images are EXRs")
    check_memory(
        f"the bake of {path}", sum(width * height * _DECODED for width, height, _ in sidecar.shapes.values())
    )
    pixels = {}
    for layer, (width, height, _) in sidecar.shapes.items():
        texture = file_of(layer)
        if digest(texture) != facts.digests[layer]:
            cause = f"{texture} is damaged, or of another bake than {path}"
            raise FormatError(f"{cause}: put one bake's files together, or bake again")
        pixels[layer] = read_texture(texture, layer, width, height)
    return CondensedAtlas(
        colour=pixels[COLOUR],
        irradiance=pixels[IRRADIANCE],
        falloff=np.array(sidecar.falloff, dtype=np.float32),
        surroundings=unpack_surroundings(pixels[SURROUNDINGS], sidecar.surroundings, sidecar.levels),
        sharpest=sidecar.sharpest,
        lobes=tuple(_lobe(axis, pixels, sidecar, facts, file_of) for axis in sidecar.lobes),
    )


def digest(path: Path) -> str:
    """A file's SHA-256 in hexadecimal digits. Raises FormatError, with the path, if it cannot be read."""
    try:
        with open_regular(path) as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise FormatError(f"{path} cannot be read: {error.strerror or error}") from error


def _lobe(
    axis: Axis,
    pixels: Mapping[str, Any],
    sidecar: SharedSidecar,
    facts: CondensedFacts,
    file_of: Callable[[str], Path],
) -> CondensedLobe:
    """Make a lobe from its textures' `pixels`, which are by layer."""
    tiles, named = facts.lobes[axis], lobe_layer(axis, WEIGHTS)
    cluster, weights = unpack_weights(pixels[named], facts.rank)
    if cluster.max() >= tiles.clusters:
        found = f"{file_of(named)} names cluster {cluster.max()}"
        raise FormatError(f"{found}, its sidecar says that there are {tiles.clusters}: bake it again")
    ends, gain, rest = (
        unpack_tiles(
            np.concatenate([pixels[layer] for layer in layers], axis=2),
            np.array(tiles.ranges[part], dtype=np.float32),
            tiles.clusters,
            facts.rank,
            facts.columns,
        )
        for part, layers in _part_layers(axis).items()
    )
    return CondensedLobe(axis, cluster, weights, ends * ends_unit(sidecar.sharpest), gain, rest)


def _within_limits(path: Path, values: Floats, kind: DdsFormat) -> tuple[Floats, int]:
    """Values clamped to a texture's limits, and how many were beyond. Raises BakeError for NaN."""
    low, high = LIMITS[kind]
    if wrong := int(np.count_nonzero(np.isnan(values))):
        raise BakeError(f"{path} was not written: {wrong} of its values are not numbers; bake it again")
    return np.clip(values, low, high), int(np.count_nonzero((values < low) | (values > high)))


def _part_layers(axis: Axis) -> dict[str, list[str]]:
    """The texture layers of each part of a lobe."""
    return {part: [lobe_layer(axis, texture) for texture in textures] for part, textures in TEXTURES.items()}


def _by_texture(atlas: CondensedAtlas) -> dict[str, Floats]:
    """The atlas's `layer_values`, with each part's channels split among its textures."""
    values = layer_values(atlas)
    for axis in dict.fromkeys(lobe.axis for lobe in atlas.lobes):  # two of one axis are refused later
        for part, layers in _part_layers(axis).items():
            shares = np.split(values.pop(lobe_layer(axis, part)), len(layers), axis=-1)
            values |= zip(layers, shares, strict=True)
    return values


def _encoded(grid: Floats, kind: DdsFormat) -> Blocks:
    """Encode a grid of tiles (H, W, channels) as blocks; alpha, where the format has it, is 1."""
    if kind is DdsFormat.BC5_UNORM:
        return encode_bc5(grid)
    return encode_bc7(np.pad(grid, ((0, 0), (0, 0), (0, 4 - grid.shape[2])), constant_values=1))


def _filled_up(image: Floats) -> Floats:
    """Pad an image (H, W, C) to whole blocks by repeating its last row and column."""
    height, width = image.shape[:2]
    return np.pad(image, ((0, -height % _SIDE), (0, -width % _SIDE), (0, 0)), mode="edge")
