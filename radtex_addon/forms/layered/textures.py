# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Write a bake in the layered layout as textures, pictures of the surroundings with their mip levels."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from ...core.arrays import Floats
from ...core.errors import InputError
from ...core.messages import Setting, do, leave_out
from ...formats.containers.texture import PixelFormat
from ...formats.image_files import layer_path
from ...formats.sidecar_file import SidecarFile
from ...textures.choice import choose, in_blocks, light_in_blocks
from ...textures.entry import TextureEntry
from ...textures.export_spec import Arrangement, ExportSpec, TextureFormat
from ...textures.texture_files import write_levels, write_ranged
from .blocks import FORMATS, coded
from .files.arrangement import COLOUR, IRRADIANCE, TINT, WORLD, unpacked
from .files.layered_files import read_layer, read_layered_sidecar
from .files.sidecar import LayeredSidecar

_LIGHT = frozenset({COLOUR, IRRADIANCE, TINT, WORLD})  # colours without alpha, never below 0


def write_layered_textures(sidecar: SidecarFile, spec: ExportSpec, folder: Path) -> dict[str, TextureEntry]:
    """As `Form.write_textures`. What is no light becomes RGBA16F where `spec` asks for no blocks."""
    check_layered_textures(sidecar, spec)
    facts = read_layered_sidecar(sidecar)
    return {layer: _write_layer(sidecar, facts, layer, spec, folder) for layer in facts.shapes}


def check_layered_textures(sidecar: SidecarFile, spec: ExportSpec) -> None:
    """As `Form.check_textures`."""
    if spec.arrangement is not Arrangement.MATRIX or (spec.levels or 1) > 1:
        raise InputError(
            f"{sidecar} is of the layered layout", leave_out(Setting.ARRANGEMENT, Setting.LEVELS)
        )
    if spec.format is TextureFormat.EXR:
        raise InputError(
            f"{sidecar} is of the layered layout, whose pictures have mip levels, which EXRs cannot hold",
            choose(TextureFormat.KTX2_RGBA16F),
            do("choose DDS", Setting.FORMAT, value=str(TextureFormat.DDS_RGBA16F)),
        )


def _is_in_blocks(layer: str, spec: ExportSpec) -> bool:
    kind = FORMATS.get(layer)
    return kind is not None and (light_in_blocks(spec) if kind is PixelFormat.BC6H else in_blocks(spec))


def _to_one_texel(levels: tuple[Floats, ...]) -> tuple[Floats, ...]:
    """Mip levels down to one texel, as some engines want them; no lookup reads those that are added."""
    while len(levels[-1]) > 1:
        last = levels[-1]
        side = len(last) // 2
        levels = (*levels, last.reshape(side, 2, side, 2, -1).mean(axis=(1, 3)))
    return levels


def _write_layer(
    sidecar: SidecarFile, facts: LayeredSidecar, layer: str, spec: ExportSpec, folder: Path
) -> TextureEntry:
    source, image = layer_path(sidecar.path, layer), read_layer(sidecar.path, facts, layer)
    levels: tuple[Floats, ...] = (image.astype(np.float32),)
    if layer in facts.pictures:
        picture = facts.pictures[layer]
        levels = _to_one_texel(unpacked(levels[0], picture.size, picture.levels))
    if _is_in_blocks(layer, spec):
        return _write_blocks(source, layer, levels, spec, folder)
    if image.shape[2] == 1:  # as grey
        levels = tuple(np.repeat(level, 3, axis=2) for level in levels)
    return write_levels(source, levels, spec, folder, None, exact=layer not in _LIGHT)


def _write_blocks(
    source: Path, layer: str, levels: tuple[Floats, ...], spec: ExportSpec, folder: Path
) -> TextureEntry:
    found = coded(layer, levels)
    texture = found.texture
    if not spec.target.traits.srgb:  # the shader decodes them
        texture = replace(texture, format=texture.format.without_srgb)
    return write_ranged(source, texture, found.texels, (found.scale, found.offset), spec, folder)
