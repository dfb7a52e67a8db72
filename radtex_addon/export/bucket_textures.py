# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake in buckets as textures, read and written a band of rows at a time."""

from __future__ import annotations

from dataclasses import replace
from functools import cache, partial
from pathlib import Path

from ..core.atlas import AtlasLayout
from ..core.errors import InputError
from ..core.levels import fitting_levels
from ..core.pages import Pages, fitting_pages
from ..core.slices import check_slices
from ..formats.bucket_files import BASE, image_path, read_layer
from ..formats.bucket_rows import open_buckets, open_layer
from ..formats.image_rows import ImageRows
from ..formats.texture import MOST_PIXELS, Form, most_levels
from ..formats.texture_file import texture_file
from ..formats.transfer_files import open_transfer
from .manifest import Arranged, TextureEntry
from .spec import Arrangement, ExportSpec, Target, TextureFormat
from .stream_textures import light_of, pour_matrix, pour_slices
from .texture_choice import (
    check_limit,
    checked_levels,
    choice,
    container_of,
    sphere_spec,
    straddled_layout,
)
from .texture_files import copy_exr, entry_of, write_encoded, write_image

_EXACT = {
    TextureFormat.KTX2_RGB9E5: TextureFormat.KTX2_RGBA16F,
    TextureFormat.KTX2_BC6H: TextureFormat.KTX2_RGBA16F,
    TextureFormat.DDS_BC6H: TextureFormat.DDS_RGBA16F,
}


def write_buckets(sidecar: Path, spec: ExportSpec, folder: Path) -> dict[str, TextureEntry]:
    """Write the atlas whose sidecar is the file `sidecar`, and those of its layers that `spec` names.

    Raises as `textures.write_textures` does.
    """
    image, facts = open_buckets(sidecar)
    layout = AtlasLayout(facts.width, facts.height, facts.bucket)
    written = {facts.kind: _write(image, layout, spec, folder)}
    for layer in spec.layers:
        written[layer] = _write_layer(sidecar, layer, layout, spec, folder)
    return written


def write_sphere(sidecar: Path, spec: ExportSpec, folder: Path) -> dict[str, TextureEntry]:
    """Write a bake of kind `transfer`, whose buckets hold the whole sphere, as a texture."""
    image, facts = open_transfer(sidecar)
    return {facts.bake.kind: _write(image, facts.stored, sphere_spec(sidecar, spec), folder)}


def _write_layer(
    sidecar: Path, layer: str, layout: AtlasLayout, spec: ExportSpec, folder: Path
) -> TextureEntry:
    """A part of the light, stored as the whole is, the base as an image; exactly where it is below 0."""
    if layer == BASE:
        return write_image(image_path(sidecar, layer), read_layer(sidecar, layer), spec, folder, None)
    image = open_layer(sidecar, layer)
    if spec.format in _EXACT and light_of(image).least < 0:
        spec = replace(spec, format=_EXACT[spec.format])
    return _write(image, layout, spec, folder)


def _write(image: ImageRows, layout: AtlasLayout, spec: ExportSpec, folder: Path) -> TextureEntry:
    """An image of buckets as a texture."""
    source, texels = image.path, (layout.width, layout.height)
    sliced = spec.arrangement is Arrangement.SLICES
    if spec.format is TextureFormat.EXR:
        if sliced or (spec.levels or 1) > 1:
            raise InputError(f"{source} holds one image: for slices or levels choose --format ktx2-rgba16f")
        check_limit(source, layout.pixel_width, layout.pixel_height, spec)
        return copy_exr(source, folder, (image.width, image.height), Arranged.MATRIX, texels)
    levels, pages = (_sliced if sliced else _paged)(source, layout, spec)
    is_array = sliced or pages.layers > 1
    container = container_of(source, spec, is_array)
    light = cache(partial(light_of, image))
    kind = choice(source, light, spec, container, straddled_layout(layout, spec, container))
    cells = 1 if sliced else layout.bucket
    width, height = pages.width * cells, pages.height * cells
    layers = layout.bucket**2 if sliced else pages.layers
    stored = most_levels(width, height) if spec.target is Target.GODOT and levels > 1 else levels
    path = folder / source.with_suffix(f".{container}").name
    with texture_file(Form(kind, width, height, layers, stored, is_array), folder) as texture:
        if sliced:
            pour_slices(image, layout, texture)
        else:
            pour_matrix(image, layout, levels, pages, texture)
        zstd = write_encoded(path, container, texture, spec, premultiplied=True)
    arranged = Arranged.SLICES if sliced else Arranged.MATRIX
    return replace(entry_of(path, container, texture, zstd, arranged, texels, pages), levels=levels)


def _paged(source: Path, layout: AtlasLayout, spec: ExportSpec) -> tuple[int, Pages]:
    """How many levels a matrix has, and its pages, as few as the limit allows."""
    limit = min(spec.most_pixels, MOST_PIXELS)
    fitting = min(fitting_levels(layout), (limit // layout.bucket).bit_length())
    levels = checked_levels(source, layout, spec) or max(1, fitting)
    return levels, fitting_pages(layout, limit, levels)


def _sliced(source: Path, layout: AtlasLayout, spec: ExportSpec) -> tuple[int, Pages]:
    """How many mip levels slices have, all by themselves, and the one page of their texels."""
    check_limit(source, layout.width, layout.height, spec)
    check_slices(layout.bucket)
    levels = checked_levels(source, layout, spec) or most_levels(layout.width, layout.height)
    return levels, Pages(1, 1, layout.width, layout.height)
