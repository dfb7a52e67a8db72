# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake in buckets as textures: the atlas, and its layers."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from ...core.atlas import AtlasLayout
from ...formats.bucket_files import BASE, image_path, read_layer
from ...formats.bucket_rows import open_buckets, open_layer
from ...textures.entry import TextureEntry
from ...textures.files import write_image
from ...textures.matrix import write_matrix
from ...textures.spec import ExportSpec, TextureFormat
from ...textures.stream import light_of

_EXACT = {
    TextureFormat.KTX2_RGB9E5: TextureFormat.KTX2_RGBA16F,
    TextureFormat.KTX2_BC6H: TextureFormat.KTX2_RGBA16F,
    TextureFormat.DDS_BC6H: TextureFormat.DDS_RGBA16F,
}


def write_buckets(sidecar: Path, spec: ExportSpec, folder: Path) -> dict[str, TextureEntry]:
    """Write the atlas whose sidecar is the file `sidecar`, and those of its layers that `spec` names.

    Raises as `Form.write_textures` does.
    """
    image, facts = open_buckets(sidecar)
    layout = AtlasLayout(facts.width, facts.height, facts.bucket)
    written = {facts.kind: write_matrix(image, layout, spec, folder)}
    for layer in spec.layers:
        written[layer] = _write_layer(sidecar, layer, layout, spec, folder)
    return written


def _write_layer(
    sidecar: Path, layer: str, layout: AtlasLayout, spec: ExportSpec, folder: Path
) -> TextureEntry:
    """A part of the light, stored as the whole is, the base as an image; exactly where it is below 0."""
    if layer == BASE:
        return write_image(image_path(sidecar, layer), read_layer(sidecar, layer), spec, folder, None)
    image = open_layer(sidecar, layer)
    if spec.format in _EXACT and light_of(image).least < 0:
        spec = replace(spec, format=_EXACT[spec.format])
    return write_matrix(image, layout, spec, folder)
