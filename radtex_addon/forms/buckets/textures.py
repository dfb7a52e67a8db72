# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Write a bake in buckets as textures: the atlas and its layers."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from ...core.atlas import AtlasLayout
from ...formats.bucket_files import BASE, image_path, open_buckets, open_layer, read_layer
from ...formats.sidecar import read_sidecar
from ...formats.sidecar_file import SidecarFile
from ...textures.choice import checked_levels
from ...textures.entry import TextureEntry
from ...textures.export_spec import ExportSpec, TextureFormat
from ...textures.matrix import write_matrix
from ...textures.stream import light_of
from ...textures.texture_files import write_image

_EXACT = {
    TextureFormat.KTX2_RGB9E5: TextureFormat.KTX2_RGBA16F,
    TextureFormat.KTX2_BC6H: TextureFormat.KTX2_RGBA16F,
    TextureFormat.DDS_BC6H: TextureFormat.DDS_RGBA16F,
}


def check_buckets(sidecar: SidecarFile, spec: ExportSpec) -> None:
    """As `Form.check_textures`."""
    facts = read_sidecar(sidecar)
    if spec.format is not TextureFormat.EXR:  # which `write_matrix` refuses to have levels
        checked_levels(sidecar.path, AtlasLayout(facts.width, facts.height, facts.bucket), spec)


def write_buckets(sidecar: SidecarFile, spec: ExportSpec, folder: Path) -> dict[str, TextureEntry]:
    """Write the atlas of a bake, and those of its layers that `spec` names.

    Raises as `Form.write_textures` does.
    """
    image, facts = open_buckets(sidecar)
    layout = AtlasLayout(facts.width, facts.height, facts.bucket)
    written = {facts.kind: write_matrix(image, layout, spec, folder)}
    for layer in spec.layers:
        written[layer] = _write_layer(sidecar, layer, layout, spec, folder)
    return written


def _write_layer(
    sidecar: SidecarFile, layer: str, layout: AtlasLayout, spec: ExportSpec, folder: Path
) -> TextureEntry:
    """Write a layer like the atlas, the base as an image; as RGBA16F if it has values below 0."""
    if layer == BASE:
        return write_image(image_path(sidecar.path, layer), read_layer(sidecar, layer), spec, folder, None)
    image = open_layer(sidecar, layer)
    if spec.format in _EXACT and light_of(image).least < 0:
        spec = replace(spec, format=_EXACT[spec.format])
    return write_matrix(image, layout, spec, folder)
