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
from typing import Any

from radtex_addon.core.arrays import Floats
from radtex_addon.formats.containers.texture import PixelFormat
from radtex_addon.forms.layered.blocks import coded
from radtex_addon.forms.layered.files.arrangement import (
    ALPHA,
    DISTANCES,
    OWN,
    PLANE,
    REST,
    THINGS,
    WIDTH,
    WORLD,
    tiled,
    untiled,
)
from radtex_addon.forms.layered.lookup.atlas import LayeredAtlas
from radtex_addon.forms.layered.lookup.edge_grid import EdgeImpostor, EdgePictures, on_edges
from radtex_addon.forms.layered.lookup.environment import Around, Impostor, Pictures, SurroundingLayer

PLANE_SIZE, THINGS_SIZE = 512, 256  # texels along a side of near layers' pictures, at most


@dataclass(frozen=True, eq=False)
class Texture:
    """A texture as a GPU's filter finds it: `levels` (H, W, C) float32; a value is `scale` level + `offset`.

    `levels` of all formats but BC6H lie in 0..1, and scale does not apply to the alpha of sRGB. `size` (w, h)
    are the texels of an image, without what fills its last blocks.
    """

    format: PixelFormat
    levels: tuple[Floats, ...]
    size: tuple[int, int]
    scale: float = 1.0
    offset: float = 0.0

    @property
    def bytes(self) -> int:
        texels = sum(int(level.shape[0]) * int(level.shape[1]) for level in self.levels)
        return texels * self.format.block_bytes // self.format.side**2

    def values(self, level: int) -> Floats:
        """A level's values, (H, W, C) float32."""
        found = self.levels[level]
        scaled = found * self.scale + self.offset
        if self.format.is_srgb:
            scaled[..., 3] = found[..., 3]
        return scaled


MATERIAL_MAPS = ("colour", "tint", "normal")
_MAPS = ("irradiance", "tangent")


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
    width = None if atlas.width is None else kept.of("width", texture_of, WIDTH, (atlas.width,))
    found = {name: _map_kept(kept, name, getattr(atlas, name)) for name in (*_MAPS, *MATERIAL_MAPS)}
    alpha = None if atlas.alpha is None else kept.of("alpha", texture_of, ALPHA, (atlas.alpha,))
    own = kept.of("own", texture_of, OWN, (tiled(atlas.own),))
    rest = kept.of("rest", texture_of, REST, (tiled(atlas.rest),))
    size = (atlas.own.shape[1], atlas.own.shape[0])
    decoded = replace(
        atlas,
        colour=atlas.colour if found["colour"] is None else found["colour"],
        irradiance=atlas.irradiance if found["irradiance"] is None else found["irradiance"],
        tint=atlas.tint if found["tint"] is None else found["tint"],
        normal=atlas.normal if found["normal"] is None else found["normal"],
        width=atlas.width if width is None else _cropped(width, 1),
        around=around,
        own=atlas.own if own is None else untiled(own.values(0), atlas.own.shape[2], size),
        rest=atlas.rest if rest is None else untiled(rest.values(0), atlas.rest.shape[2], size)[..., :3],
        alpha=atlas.alpha if alpha is None else _cropped(alpha, 1),
        tangent=atlas.tangent if found["tangent"] is None else found["tangent"],
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
    found = kept.of("world", _picture, WORLD, world, len(world.levels[0]))
    if found is not None:
        world = _decoded(found, world.sharpest)
    layers = []
    for number, layer in enumerate(around.layers):
        pictures, shape = layer.pictures, layer.shape
        most = near_sizes[isinstance(shape, Impostor)]
        size = min(most, len(pictures.levels[0]))
        name = THINGS if isinstance(shape, Impostor) else PLANE
        found = kept.of(f"near{number}", _picture, name, pictures, size)
        if found is not None:
            ratio = len(pictures.levels[0]) // len(found.levels[0])
            pictures = _decoded(found, pictures.sharpest * ratio**2)
        if isinstance(shape, Impostor):
            found = kept.of(
                f"distances{number}", texture_of, DISTANCES, (on_edges(shape.nearness[..., None]),)
            )
            shape = shape if found is None else EdgeImpostor(found.values(0)[..., 0])
        layers.append(SurroundingLayer(pictures, shape))
    return replace(around, world=world, layers=tuple(layers))


def _map_kept(kept: _Kept, name: str, image: Floats | None) -> Floats | None:
    """A map of the surface as it decodes; None where there is none, it is black, or it is not wanted."""
    if image is None or not image.any():
        return None
    found = kept.of(name, texture_of, name, (image,))
    return None if found is None else _cropped(found)


def texture_of(layer: str, levels: tuple[Floats, ...]) -> Texture:
    """The texture of a layer's mip levels (H, W, C), the largest first."""
    found = coded(layer, levels)
    return Texture(found.texture.format, found.levels(), found.texels, found.scale, found.offset)


def _picture(layer: str, pictures: Pictures, size: int) -> Texture:
    """The texture of pictures (M, M, C) whose first level has at most `size` x `size`."""
    return texture_of(layer, tuple(on_edges(level) for level in pictures.levels if len(level) <= size))


def _decoded(texture: Texture, sharpest: float) -> EdgePictures:
    return EdgePictures(
        tuple(
            texture.values(level)[..., : 3 + texture.format.is_srgb] for level in range(len(texture.levels))
        ),
        sharpest,
    )


def _cropped(texture: Texture, channels: int = 3) -> Floats:
    width, height = texture.size
    return texture.values(0)[:height, :width, :channels]
