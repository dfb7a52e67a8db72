# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How each layer is compressed in blocks, and in which range.

Light without alpha is BC6H. Colours, and light with alpha, are coded as sRGB, which hardware decodes before
it filters, in a range of their own: BC7, and what the object shows of itself BC3, as its mask has nothing to
do with its colours. What may be below 0 is BC7 in a range, unless that is wide, as where a lamp's shade is in
the atlas; single channels are BC4. Buckets are tiles of whole blocks (`files.arrangement.tiled`), so that no
block joins two cells.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...core.arrays import Floats
from ...formats.containers.texture import PixelFormat, Texture, decode_texture, encode_texture
from ...formats.containers.unit_blocks import CHANNELS, decode_units, encode_units
from .files.arrangement import (
    ALPHA,
    COLOUR,
    DISTANCES,
    IRRADIANCE,
    NORMAL,
    OWN,
    PLANE,
    REST,
    TANGENT,
    THINGS,
    THROUGH_COLOUR,
    THROUGH_REST,
    TINT,
    WIDTH,
    WORLD,
)
from .shader_values import CLEAR_ALPHA

FORMATS = {
    COLOUR: PixelFormat.BC7_SRGB,
    IRRADIANCE: PixelFormat.BC6H,
    TINT: PixelFormat.BC7_SRGB,
    NORMAL: PixelFormat.BC7,
    WIDTH: PixelFormat.BC4,
    ALPHA: PixelFormat.BC4,
    TANGENT: PixelFormat.BC7,
    OWN: PixelFormat.BC3_SRGB,
    REST: PixelFormat.BC7,
    WORLD: PixelFormat.BC6H,
    PLANE: PixelFormat.BC7_SRGB,
    THINGS: PixelFormat.BC7_SRGB,
    DISTANCES: PixelFormat.BC4,
    THROUGH_COLOUR: PixelFormat.BC7_SRGB,
    THROUGH_REST: PixelFormat.BC7,
}
_MAPS = (COLOUR, IRRADIANCE, TINT, NORMAL, WIDTH, ALPHA, TANGENT, THROUGH_COLOUR)
_BRIGHTEST = 4.0  # of what the object shows of itself: a wider range has coarser steps in the dark
# Widest ranges in eight bits: with wider ones steps would be seen in what is dark, or all of it be grey.
_WIDEST = {REST: 4.0, THROUGH_REST: 4.0, PLANE: 16.0, THINGS: 16.0}
_SHARE_BEYOND = 0.0002  # of the rest's values, beyond either end of its range
_SEEN = 0.02  # weight of what the object shows of itself, where the mask leaves all free


@dataclass(frozen=True, eq=False)
class Coded:
    """A layer's texture: a value is texel * `scale` + `offset`, but for the alpha of CLEAR_ALPHA.

    `texels` are the width and height of the image, without what fills the last blocks.
    """

    texture: Texture
    texels: tuple[int, int]
    scale: float = 1.0
    offset: float = 0.0

    def levels(self) -> tuple[Floats, ...]:
        """All levels' texels as a GPU's filter finds them, with what fills the last blocks.

        (H, W, C) float32; C is 3 for BC6H, else as `CHANNELS` has it.
        """
        if self.texture.format in CHANNELS:
            return decode_units(self.texture)
        return tuple(level[0] for level in decode_texture(self.texture))

    def values(self) -> tuple[Floats, ...]:
        """All levels' values, without what fills the last blocks, (H, W, C) as `levels`."""
        width, height = self.texels
        found = []
        for number, level in enumerate(self.levels()):
            values = level * np.float32(self.scale) + np.float32(self.offset)
            if self.texture.format.is_srgb:
                values[..., 3] = level[..., 3]
            found.append(values[: max(1, height >> number), : max(1, width >> number)])
        return tuple(found)


def fits_blocks(layer: str, image: Floats) -> bool:
    """Whether a layer's values (H, W, C) can be coded in blocks without steps that one sees."""
    return layer not in _WIDEST or _range(layer, image)[0] <= _WIDEST[layer]


def coded(layer: str, levels: tuple[Floats, ...], texels: tuple[int, int] | None = None) -> Coded:
    """The mip levels (H, W, C) of a layer, linear, the largest first, in blocks.

    `texels`: the width and height of the image, if the first level has more at its end. A single level is
    filled up to whole blocks by its last column and row; a map that is the same everywhere becomes one block.
    Raises KeyError for a layer that has no format, InputError for values that are not numbers.
    """
    kind, image = FORMATS[layer], levels[0]
    if layer in _MAPS and (image == image[0, 0]).all():
        image = image[: kind.side, : kind.side]
        levels, texels = (image,), None
    texels = texels or (image.shape[1], image.shape[0])
    if len(levels) == 1:
        more = [(0, -side % kind.side) for side in image.shape[:2]]
        levels = (np.pad(image, [*more, (0, 0)], mode="edge"),)
    if kind is PixelFormat.BC6H:
        return Coded(encode_texture([level[None] for level in levels], kind), texels)
    scale, offset = _range(layer, image)
    units = tuple(_units(level, scale, offset) for level in levels)
    weight = (1 - units[0][..., 3] + np.float32(_SEEN)) ** 2 if layer == OWN else None
    return Coded(encode_units(units, kind, weight), texels, scale, offset)


def _range(layer: str, image: Floats) -> tuple[float, float]:
    """The scale and the offset of a layer's values."""
    if layer in (COLOUR, TINT, THROUGH_COLOUR):
        return max(1.0, float(image.max())), 0.0
    if layer in CLEAR_ALPHA:
        brightest = max(float(image[..., :3].max()), 1e-6)
        return (min(brightest, _BRIGHTEST) if layer == OWN else brightest), 0.0
    if layer in (NORMAL, TANGENT):
        return 2.0, -1.0
    if layer == ALPHA:
        return 1.0, 0.0
    beyond = _SHARE_BEYOND if layer in (REST, THROUGH_REST) else 0.0
    least, most = (float(end) for end in np.quantile(image, [beyond, 1 - beyond]))
    return max(most - least, 1e-9), least


def _units(image: Floats, scale: float, offset: float) -> Floats:
    """Values as texels in 0..1, with as many channels as the layer's format."""
    channels = image.shape[2]
    found: Floats = np.ones((*image.shape[:2], 4 if channels == 3 else channels), np.float32)
    scaled = found[..., :3]  # the single channel, too
    scaled[...] = image[..., :3]
    scaled -= np.float32(offset)
    scaled /= np.float32(scale)
    if channels == 4:
        found[..., 3] = image[..., 3]
    return np.clip(found, 0, 1, out=found)
