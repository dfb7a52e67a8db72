# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""About how large the textures of an export get, without reading the bake's images."""

from __future__ import annotations

from ..textures.choice import in_blocks
from ..textures.export_spec import ExportSpec, TextureFormat
from .exporting import ExportSource

_LEVELS = 4 / 3  # all mip levels together, relative to the first
_WORD = 4  # bytes of a whole number that holds bits
_FLOATS, _SHARED, _BLOCKS = 8, 4, 1  # bytes a pixel: half floats, RGB9E5, blocks
_BYTES = {
    TextureFormat.EXR: _FLOATS,
    TextureFormat.KTX2_RGBA16F: _FLOATS,
    TextureFormat.KTX2_RGB9E5: _SHARED,
    TextureFormat.KTX2_BC6H: _BLOCKS,
    TextureFormat.DDS_BC6H: _BLOCKS,
    TextureFormat.DDS_RGBA16F: _FLOATS,
}


def about_texture_bytes(bake: ExportSource, spec: ExportSpec) -> float:
    """Bytes of the textures before they are packed by Zstandard, for light without alpha."""
    shapes = bake.form.shapes(bake.sidecar).values()
    pixels = sum(width * height for width, height, _ in shapes)
    if bake.form.traits.bits:
        return float(_WORD * sum(width * height * words for width, height, words in shapes))
    if bake.form.traits.by_paths:
        return pixels * _LEVELS * (_BLOCKS if in_blocks(spec) else _FLOATS)
    if not bake.form.traits.arranges:
        return float(pixels * _bytes(spec))
    levels = 1 if spec.levels == 1 or spec.format is TextureFormat.EXR else _LEVELS
    return pixels * levels * _bytes(spec)


def _bytes(spec: ExportSpec) -> int:
    return _BYTES[spec.target.traits.auto if spec.format is TextureFormat.AUTO else spec.format]
