# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Write a bake in the layered layout as textures, pictures of the surroundings with their mip levels."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ...core.arrays import Floats
from ...core.errors import InputError
from ...core.messages import Setting, do, leave_out
from ...formats.image_files import layer_path
from ...formats.sidecar_file import SidecarFile
from ...textures.choice import choose
from ...textures.entry import TextureEntry
from ...textures.export_spec import Arrangement, ExportSpec, TextureFormat
from ...textures.texture_files import write_levels
from .files.arrangement import COLOUR, IRRADIANCE, TINT, WORLD, unpacked
from .files.layered_files import read_layer, read_layered_sidecar
from .files.sidecar import LayeredSidecar

_LIGHT = frozenset({COLOUR, IRRADIANCE, TINT, WORLD})  # colours without alpha, never below 0


def write_layered_textures(sidecar: SidecarFile, spec: ExportSpec, folder: Path) -> dict[str, TextureEntry]:
    """As `Form.write_textures`. What is no light becomes RGBA16F, whatever `spec` says."""
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
    facts = read_layered_sidecar(sidecar)
    return {layer: _write_layer(sidecar, facts, layer, spec, folder) for layer in facts.shapes}


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
    if image.shape[2] == 1:  # as grey
        levels = tuple(np.repeat(level, 3, axis=2) for level in levels)
    return write_levels(source, levels, spec, folder, None, exact=layer not in _LIGHT)
