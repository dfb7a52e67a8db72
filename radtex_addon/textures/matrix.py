# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Write an image of buckets as a texture, reading and writing a band of rows at a time."""

from __future__ import annotations

from dataclasses import replace
from functools import cache, partial
from pathlib import Path

from ..core.arrangements import Pages, check_slices, fitting_levels, fitting_pages
from ..core.atlas import AtlasLayout
from ..core.errors import InputError
from ..formats.containers.exr_rows import ImageRows
from ..formats.containers.texture import MOST_PIXELS, TextureShape, most_levels
from ..formats.containers.texture_file import texture_file
from .choice import (
    check_limit,
    checked_levels,
    choice,
    choose,
    container_of,
    straddled_layout,
)
from .entry import Arranged, TextureEntry
from .export_spec import Arrangement, ExportSpec, TextureFormat
from .stream import light_of, pour_matrix, pour_slices
from .texture_files import copy_exr, entry_of, write_encoded


def write_matrix(image: ImageRows, layout: AtlasLayout, spec: ExportSpec, folder: Path) -> TextureEntry:
    """Write an image of buckets as a texture. Raises InputError if it does not fit `spec`."""
    source, texels = image.path, (layout.width, layout.height)
    sliced = spec.arrangement is Arrangement.SLICES
    if spec.format is TextureFormat.EXR:
        if sliced or (spec.levels or 1) > 1:
            raise InputError(
                f"{source} holds one image, neither slices nor levels", choose(TextureFormat.KTX2_RGBA16F)
            )
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
    stored = most_levels(width, height) if spec.target.traits.all_levels and levels > 1 else levels
    path = folder / source.with_suffix(f".{container}").name
    with texture_file(TextureShape(kind, width, height, layers, stored, is_array), folder) as texture:
        if sliced:
            pour_slices(image, layout, texture)
        else:
            pour_matrix(image, layout, levels, pages, texture)
        zstd = write_encoded(path, container, texture, spec, premultiplied=True)
    arranged = Arranged.SLICES if sliced else Arranged.MATRIX
    return replace(entry_of(path, container, texture, zstd, arranged, texels, pages), levels=levels)


def _paged(source: Path, layout: AtlasLayout, spec: ExportSpec) -> tuple[int, Pages]:
    """The number of mip levels of a matrix, and its pages: as few as the limit allows."""
    limit = min(spec.most_pixels, MOST_PIXELS)
    fitting = min(fitting_levels(layout), (limit // layout.bucket).bit_length())
    levels = checked_levels(source, layout, spec) or max(1, fitting)
    return levels, fitting_pages(layout, limit, levels)


def _sliced(source: Path, layout: AtlasLayout, spec: ExportSpec) -> tuple[int, Pages]:
    """The number of mip levels of slices, all unless `spec` gives it, and the one page of their texels."""
    check_limit(source, layout.width, layout.height, spec)
    check_slices(layout.bucket)
    levels = checked_levels(source, layout, spec) or most_levels(layout.width, layout.height)
    return levels, Pages(1, 1, layout.width, layout.height)
