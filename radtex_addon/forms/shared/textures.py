# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Write a bake in the shared layout as textures."""

from __future__ import annotations

from pathlib import Path

from ...core.errors import InputError
from ...core.messages import Setting, leave_out
from ...formats.image_files import layer_path
from ...formats.packing import COLOUR, ENDS, IRRADIANCE, SURROUNDINGS
from ...formats.shared_files import read_layer as read_shared_layer
from ...formats.shared_files import read_shared_sidecar
from ...formats.shared_sidecar import SharedSidecar
from ...formats.sidecar_file import SidecarFile
from ...textures.choice import straddled_bucket
from ...textures.entry import TextureEntry
from ...textures.export_spec import Arrangement, ExportSpec
from ...textures.texture_files import write_image

_SMOOTH = (COLOUR, IRRADIANCE, SURROUNDINGS)  # without buckets that a block could straddle


def write_shared_textures(sidecar: SidecarFile, spec: ExportSpec, folder: Path) -> dict[str, TextureEntry]:
    """As `Form.write_textures`. Images with negative values become RGBA16F, whatever `spec` says."""
    check_plain_arrangement(sidecar, spec)
    shared = read_shared_sidecar(sidecar)
    return {layer: _write_layer(sidecar, shared, layer, spec, folder) for layer in shared.shapes}


def check_plain_arrangement(sidecar: SidecarFile, spec: ExportSpec) -> None:
    """Raise InputError for an arrangement or levels, which the shared layout's textures cannot have."""
    if spec.arrangement is not Arrangement.MATRIX or (spec.levels or 1) > 1:
        raise InputError(f"{sidecar} is of the shared layout", leave_out(Setting.ARRANGEMENT, Setting.LEVELS))


def _write_layer(
    sidecar: SidecarFile, shared: SharedSidecar, layer: str, spec: ExportSpec, folder: Path
) -> TextureEntry:
    """Write one image of a bake in the shared layout."""
    source, image = layer_path(sidecar.path, layer), read_shared_layer(sidecar.path, shared, layer)
    straddled = None if layer in _SMOOTH else straddled_bucket(shared.bake.bucket, border=1)
    return write_image(source, image, spec, folder, straddled, exact=layer.endswith(ENDS))
