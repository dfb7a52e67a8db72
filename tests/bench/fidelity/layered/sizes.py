# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a GPU holds of a layered bake, compressed in blocks."""

from __future__ import annotations

from radtex_addon.forms.layered.lookup.atlas import LayeredAtlas
from radtex_addon.forms.layered.lookup.environment import Impostor

from .compressed import PLANE_SIZE, THINGS_SIZE

_MIPS = 4 / 3  # of a texture with its smaller copies
_BYTE, _HALF, _FLOATS = 1.0, 0.5, 8.0  # a texel of BC7 and BC6H, of BC4, and of RGBA16F


def texture_bytes(atlas: LayeredAtlas) -> int:
    """Of BC7 for what is dark and bright alike, BC6H for light, BC4 for distances and alpha.

    Without material maps: colour, tint and normals, which an engine may take from its own material.
    """
    total = _BYTE * _MIPS * (_pixels(atlas.irradiance) + _pixels(atlas.around.world.levels[0]))
    for layer in atlas.around.layers:
        things = isinstance(layer.shape, Impostor)
        side = min(len(layer.pictures.levels[0]), THINGS_SIZE if things else PLANE_SIZE)
        total += _BYTE * _MIPS * side**2
        if isinstance(layer.shape, Impostor):
            total += _HALF * layer.shape.nearness.size
    total += _BYTE * (atlas.own.size / 4 + atlas.rest.size / 3)
    total += 0 if atlas.tangent is None else _BYTE * _pixels(atlas.tangent)
    total += _HALF * sum(_pixels(image) for image in (atlas.alpha, atlas.width) if image is not None)
    if atlas.through is not None:
        field = atlas.through.field
        ways = _BYTE * atlas.through.ways.size / 4 if field is None else _FLOATS * field.values.size / 4
        total += ways + _BYTE * atlas.through.rest.size / 3
        total += _HALF * _pixels(atlas.through.colour)
    return round(total)


def material_bytes(atlas: LayeredAtlas) -> int:
    """Of the material's maps in BC7: colour, tint and normals."""
    maps = (atlas.colour, atlas.tint, atlas.normal)
    return round(_BYTE * sum(_pixels(image) for image in maps if image is not None))


def _pixels(image: object) -> int:
    height, width = image.shape[:2]  # type: ignore[attr-defined]
    return int(height * width)
