# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A layered atlas as the block-compressed textures that a GPU holds, and the atlas that these decode to.

Light without alpha is BC6H. What has alpha is coded as sRGB, which hardware decodes before it filters, in a
range of its own: pictures BC7, and what the object shows of itself BC3, as its mask has nothing to do with
its colours. Distances and alpha are BC4. Buckets are an image of [cell row][cell column] tiles of (h, w)
texels each: one lookup filters the four texels of a cell.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any

import numpy as np

from radtex_addon.core.arrays import Floats
from radtex_addon.formats.codecs.bc3 import decode_bc3, encode_bc3
from radtex_addon.formats.codecs.bc5 import decode_bc5, encode_bc5
from radtex_addon.formats.codecs.bc6h import decode_bc6h, encode_bc6h
from radtex_addon.formats.codecs.bc7 import decode_bc7, encode_bc7
from radtex_addon.forms.layered.lookup.atlas import LayeredAtlas
from radtex_addon.forms.layered.lookup.edge_grid import EdgeImpostor, EdgePictures, on_edges
from radtex_addon.forms.layered.lookup.environment import Around, Impostor, Layer, Pictures

PLANE_SIZE, THINGS_SIZE = 512, 256  # texels along a side of near layers' pictures, at most
_BRIGHTEST = 4.0  # of what the object shows of itself: a wider range has coarser steps in the dark
_REST_RANGE = 0.0002  # share of the rest's values beyond either end of its range
_SEEN = 0.02  # weight of what the object shows of itself, where the mask leaves all free
_BLOCK = 4


class Format(StrEnum):
    """How a texture's texels are stored."""

    BC3_SRGB = "BC3 sRGB"
    BC4 = "BC4"
    BC6H = "BC6H"
    BC7 = "BC7"
    BC7_SRGB = "BC7 sRGB"


@dataclass(frozen=True, eq=False)
class Texture:
    """A texture as a GPU's filter finds it: `levels` (H, W, C) float32; a value is `scale` level + `offset`.

    `levels` of the BC7 and BC4 formats lie in 0..1, and scale does not apply to alpha. `size` (w, h) are the
    texels of an image, or of a tile, that is padded to whole blocks on the right and at the top.
    """

    format: Format
    levels: tuple[Floats, ...]
    size: tuple[int, int]
    scale: float = 1.0
    offset: float = 0.0

    @property
    def bytes(self) -> int:
        texels = sum(int(level.shape[0]) * int(level.shape[1]) for level in self.levels)
        return texels // 2 if self.format is Format.BC4 else texels

    def values(self, level: int) -> Floats:
        """A level's values, (H, W, C) float32."""
        found = self.levels[level]
        if self.scale == 1 and self.offset == 0:
            return found
        scaled = found * np.float32(self.scale) + np.float32(self.offset)
        if self.format in (Format.BC3_SRGB, Format.BC7_SRGB):
            scaled[..., 3] = found[..., 3]
        return scaled


MATERIAL_MAPS = ("colour", "tint", "normal")


def compressed(
    atlas: LayeredAtlas,
    only: Collection[str] | None = None,
    near_sizes: tuple[int, int] = (PLANE_SIZE, THINGS_SIZE),
) -> tuple[LayeredAtlas, dict[str, Texture]]:
    """The atlas as it decodes, and its textures by name.

    `only` names the textures that are compressed, the others stay as they are; without it all are. The
    pictures of a plane and of other things have at most `near_sizes` texels along a side. What comes through
    is neither counted nor compressed here.
    """
    kept = _Kept({}, only)
    around = _around(kept, atlas.around, near_sizes)
    width = None if atlas.width is None else kept.of("width", _range, atlas.width)
    found = {name: _map_kept(kept, name, getattr(atlas, name)) for name in ("irradiance", *MATERIAL_MAPS)}
    alpha = None if atlas.alpha is None else kept.of("alpha", _alpha, atlas.alpha)
    own, rest = kept.of("own", _own, atlas.own), kept.of("rest", _rest, atlas.rest)
    decoded = replace(
        atlas,
        colour=atlas.colour if found["colour"] is None else found["colour"],
        irradiance=atlas.irradiance if found["irradiance"] is None else found["irradiance"],
        tint=atlas.tint if found["tint"] is None else found["tint"],
        normal=atlas.normal if found["normal"] is None else found["normal"],
        width=atlas.width if width is None else _cropped(width),
        around=around,
        own=atlas.own if own is None else _buckets(own),
        rest=atlas.rest if rest is None else _buckets(rest)[..., :3],
        alpha=atlas.alpha if alpha is None else _cropped(alpha),
    )
    return decoded, kept.textures


@dataclass(frozen=True)
class _Kept:
    """The textures so far; `only` names those that are wanted, None all."""

    textures: dict[str, Texture]
    only: Collection[str] | None

    def of(self, name: str, make: Callable[..., Texture], *values: Any) -> Texture | None:
        """The texture that `make` makes of values, if it is wanted."""
        if self.only is None or name in self.only:
            self.textures[name] = make(*values)
        return self.textures.get(name)


def _around(kept: _Kept, around: Around, near_sizes: tuple[int, int]) -> Around:
    world = around.world
    found = kept.of("world", picture_texture, world)
    if found is not None:
        world = _decoded(found, world.sharpest)
    layers = []
    for number, layer in enumerate(around.layers):
        pictures, shape = layer.pictures, layer.shape
        most = near_sizes[isinstance(shape, Impostor)]
        size = min(most, len(pictures.levels[0]))
        found = kept.of(f"near{number}", picture_texture, pictures, size)
        if found is not None:
            ratio = len(pictures.levels[0]) // len(found.levels[0])
            pictures = _decoded(found, pictures.sharpest * ratio**2)
        if isinstance(shape, Impostor):
            found = kept.of(f"distances{number}", _distances, shape.nearness)
            shape = shape if found is None else EdgeImpostor(found.values(0)[..., 0])
        layers.append(Layer(pictures, shape))
    return replace(around, world=world, layers=tuple(layers))


def _map_kept(kept: _Kept, name: str, image: Floats | None) -> Floats | None:
    """A map of the surface as it decodes; None where there is none, it is black, or it is not wanted."""
    if image is None or not image.any():
        return None
    found = kept.of(
        name, *((light_texture, image) if name == "irradiance" else (_map, image, name == "normal"))
    )
    return None if found is None else _cropped(found)


def picture_texture(pictures: Pictures, size: int | None = None) -> Texture:
    """The texture of pictures (M, M, 3), or premultiplied (M, M, 4); its first level has `size` x `size`."""
    size = size or len(pictures.levels[0])
    levels = [level for level in pictures.levels if len(level) <= size]
    levels = [on_edges(level) for level in levels]
    if levels[0].shape[2] == 3:
        found = [decode_bc6h(encode_bc6h(level)) for level in levels]
        return Texture(Format.BC6H, tuple(found), (size, size))
    scale = max(float(levels[0][..., :3].max()), 1e-6)
    return Texture(
        Format.BC7_SRGB, tuple(_srgb_blocks(level, scale) for level in levels), (size, size), scale
    )


def _decoded(texture: Texture, sharpest: float) -> EdgePictures:
    return EdgePictures(tuple(texture.values(level) for level in range(len(texture.levels))), sharpest)


def _distances(nearness: Floats) -> Texture:
    return _range(on_edges(nearness[..., None]))


def _range(image: Floats) -> Texture:
    """The texture of values (H, W, 1) of any range."""
    height, width = image.shape[:2]
    least, most = float(image.min()), float(image.max())
    scale = max(most - least, 1e-9)
    coded = np.repeat(_padded((image - least) / scale), 2, axis=2)
    found = decode_bc5(encode_bc5(coded))[..., :1]
    return Texture(Format.BC4, (found,), (width, height), scale, least)


def _alpha(image: Floats) -> Texture:
    height, width = image.shape[:2]
    coded = np.repeat(_padded(np.clip(image, 0, 1)), 2, axis=2)
    return Texture(Format.BC4, (decode_bc5(encode_bc5(coded))[..., :1],), (width, height))


def light_texture(image: Floats) -> Texture:
    """The texture of light (H, W, 3)."""
    height, width = image.shape[:2]
    return Texture(Format.BC6H, (decode_bc6h(encode_bc6h(_padded(image))),), (width, height))


def _map(image: Floats, signed: bool) -> Texture:
    """A map of the material: colours as sRGB, or unit vectors."""
    height, width = image.shape[:2]
    if signed:
        coded = _padded(_opaque(image * 0.5 + 0.5))
        return Texture(Format.BC7, (decode_bc7(encode_bc7(coded)),), (width, height), 2, -1)
    scale = max(1.0, float(image.max()))
    return Texture(Format.BC7_SRGB, (_srgb_blocks(_padded(_opaque(image)), scale),), (width, height), scale)


def _own(own: Floats) -> Texture:
    """What the object shows of itself, and alpha what it leaves free, where the former counts for nothing."""
    height, width = own.shape[:2]
    scale = min(max(float(own[..., :3].max()), 1e-6), _BRIGHTEST)
    image = _tiles(own)
    weight = (1 - image[..., 3] + np.float32(_SEEN)) ** 2
    image[..., :3] = to_srgb(np.clip(image[..., :3] / np.float32(scale), 0, 1))
    found = decode_bc3(encode_bc3(image, weight))
    found[..., :3] = from_srgb(found[..., :3])
    return Texture(Format.BC3_SRGB, (found,), (width, height), scale)


def _rest(rest: Floats) -> Texture:
    height, width = rest.shape[:2]
    least, most = (float(end) for end in np.quantile(rest, [_REST_RANGE, 1 - _REST_RANGE]))
    scale = max(most - least, 1e-6)
    coded = _tiles(_opaque((np.clip(rest, least, most) - least) / scale))
    return Texture(Format.BC7, (decode_bc7(encode_bc7(coded)),), (width, height), scale, least)


def _srgb_blocks(image: Floats, scale: float) -> Floats:
    """An image (H, W, 4) over `scale` as BC7 in sRGB gives it back, linear in 0..1; alpha is not scaled."""
    coded = image.astype(np.float32).copy()
    coded[..., :3] = to_srgb(np.clip(coded[..., :3] / np.float32(scale), 0, 1))
    found = decode_bc7(encode_bc7(coded))
    found[..., :3] = from_srgb(found[..., :3])
    return found


def to_srgb(linear: Floats) -> Floats:
    """The sRGB transfer function, IEC 61966-2-1, of 0..1."""
    curve = 1.055 * np.maximum(linear, 1e-9) ** (1 / 2.4) - 0.055
    return np.where(linear <= 0.0031308, 12.92 * linear, curve).astype(np.float32)


def from_srgb(coded: Floats) -> Floats:
    """The inverse of `to_srgb`."""
    curve = ((coded + 0.055) / 1.055) ** 2.4
    return np.where(coded <= 0.04045, coded / 12.92, curve).astype(np.float32)


def _opaque(image: Floats) -> Floats:
    return np.concatenate([image, np.ones_like(image[..., :1])], axis=-1)


def _padded(image: Floats) -> Floats:
    """An image (H, W, ...) to whole blocks, by its last column and row again."""
    more = [(0, -size % _BLOCK) for size in image.shape[:2]]
    return np.pad(image, more + [(0, 0)] * (image.ndim - 2), mode="edge")


def _cropped(texture: Texture) -> Floats:
    width, height = texture.size
    return texture.values(0)[:height, :width, :3]


def _tiles(buckets: Floats) -> Floats:
    """Buckets (h, w, n, n, C) as tiles: (n H, n W, C), H and W being h and w to whole blocks."""
    padded = _padded(buckets)
    height, width, n = padded.shape[:3]
    return np.moveaxis(padded, (2, 3), (0, 2)).reshape(n * height, n * width, -1).copy()


def _buckets(texture: Texture) -> Floats:
    """The inverse of `_tiles`, without the padding."""
    width, height = texture.size
    image = texture.values(0)
    rows, columns = (size + -size % _BLOCK for size in (height, width))
    tiles = image.reshape(image.shape[0] // rows, rows, image.shape[1] // columns, columns, -1)
    return np.ascontiguousarray(np.moveaxis(tiles, (0, 2), (2, 3))[:height, :width])
