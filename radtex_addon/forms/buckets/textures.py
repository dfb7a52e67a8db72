# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake in buckets as textures: the atlas and its layers; and as a flat lightmap, of their means."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from ...core.arrays import Floats
from ...core.atlas import AtlasLayout
from ...core.surface import SurfaceMesh
from ...core.texel_map import covered_texels
from ...formats.bucket_files import BASE, image_path, open_buckets, open_layer, read_layer
from ...formats.containers.exr_rows import ImageRows
from ...formats.sidecar import Sidecar, read_sidecar
from ...formats.sidecar_file import SidecarFile
from ...textures.choice import checked_levels
from ...textures.entry import TextureEntry
from ...textures.export_spec import ExportSpec, TextureFormat
from ...textures.flat_lightmap import check_stored, mean_of_buckets
from ...textures.matrix import write_matrix
from ...textures.stream import light_of
from ...textures.texture_files import write_image

_ALPHA = 3  # its channel
_OPAQUE = 0.999  # alpha: means of half floats may be slightly below 1
_EXACT = {
    TextureFormat.KTX2_RGB9E5: TextureFormat.KTX2_RGBA16F,
    TextureFormat.KTX2_BC6H: TextureFormat.KTX2_RGBA16F,
    TextureFormat.DDS_BC6H: TextureFormat.DDS_RGBA16F,
}


def flat_buckets(sidecar: SidecarFile, surface: SurfaceMesh, used: slice) -> Floats:
    """The mean (H, W, C) of the `used` channels of each bucket of an atlas, float32, row 0 at v = 0.

    One channel becomes grey, (H, W, 3). Raises FormatError for files that cannot be read, and if the
    atlas is of another surface.
    """
    image, facts = open_buckets(sidecar)
    light, cells = _means_and_cells(image, facts, used)
    check_stored(sidecar.path, covered_texels(surface, facts.width, facts.height), cells, light)
    return light


def light_channels(sidecar: SidecarFile) -> slice:
    """RGB, and alpha if any cell is transparent: light is premultiplied by it."""
    image, _ = open_buckets(sidecar)
    clear = image.channels > _ALPHA and any((rows[..., _ALPHA] < _OPAQUE).any() for _, rows in image.bands())
    return slice(_ALPHA + 1 if clear else _ALPHA)


def _means_and_cells(image: ImageRows, facts: Sidecar, used: slice) -> tuple[Floats, Floats]:
    means, cells = [], []
    for _, band in image.bands(facts.bucket):
        some = AtlasLayout(facts.width, len(band) // facts.bucket, facts.bucket)
        means.append(mean_of_buckets(band[..., used], some))
        cells.append(some.some_cells(band[..., used]))
    return np.concatenate(means), np.concatenate(cells)


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
