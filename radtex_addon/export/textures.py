# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A finished bake's images as textures that engines load.

Their first row is the bottom one, v = 0; an EXR's is the top one, as the bake wrote it.
"""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..core.arrays import Floats
from ..core.atlas import AtlasLayout
from ..core.errors import FormatError, InputError
from ..core.levels import fitting_levels, level_chain, padded_layout
from ..core.pages import Pages, fitting_pages, split_pages
from ..core.slices import mip_chain, to_slices
from ..formats.atomic import replacing
from ..formats.bucket_files import BASE, image_path, read_layer
from ..formats.condensed_files import digest
from ..formats.dds import read_dds, write_texture
from ..formats.exr import read_buckets
from ..formats.ktx2 import write_ktx2
from ..formats.packing import COLOUR, ENDS, IRRADIANCE, SURROUNDINGS
from ..formats.shadow_files import KIND as SHADOW
from ..formats.shared_files import layer_path, read_shared_sidecar, texture_path
from ..formats.shared_files import read_layer as read_shared_layer
from ..formats.shared_sidecar import LAYOUT as SHARED
from ..formats.shared_sidecar import SharedSidecar
from ..formats.sidecar import Sidecar, read_facts
from ..formats.texture import MOST_PIXELS, PixelFormat, Texture, encode_texture, most_levels
from ..formats.transfer_files import LAYOUT as SPHERE
from ..formats.transfer_files import read_transfer
from .manifest import Arranged, Container, TextureEntry
from .shadow_texture import write_shadow_texture
from .spec import Arrangement, ExportSpec, Target, TextureFormat
from .texture_choice import (
    check_limit,
    checked_levels,
    choice,
    container_of,
    sphere_spec,
    straddled_bucket,
    straddled_layout,
)

_CONDENSED = (TextureFormat.AUTO, TextureFormat.DDS_BC6H)  # what leaves a condensed bake as it is
_SMOOTH = (COLOUR, IRRADIANCE, SURROUNDINGS)  # without buckets that a block could straddle
_BLOCK = PixelFormat.BC6H.side
_EXACT = {
    TextureFormat.KTX2_RGB9E5: TextureFormat.KTX2_RGBA16F,
    TextureFormat.KTX2_BC6H: TextureFormat.KTX2_RGBA16F,
    TextureFormat.DDS_BC6H: TextureFormat.DDS_RGBA16F,
}


def write_textures(sidecar: Path, spec: ExportSpec, folder: Path) -> dict[str, TextureEntry]:
    """Write the textures of the bake whose sidecar is the file `sidecar` into `folder`; entries by layer.

    They are called as the bake's images, but for the ending. EXR and RGBA16F hold what the bake holds; RGB9E5
    and BC6H lose a little, and light below 0. A shared layer that has negative values is RGBA16F whatever
    `spec` says. A condensed bake's files are copied as they are. Raises InputError for what the bake or the
    format cannot be, FormatError, with the path, for files that are missing, damaged or of different bakes,
    BakeError where the system refuses.
    """
    found = read_facts(sidecar)
    if found.text("kind") == SHADOW:
        return write_shadow_texture(sidecar, spec, folder)
    if found.text("layout") == SPHERE:
        pixels, sphere = read_transfer(sidecar)
        stored = replace(sphere.bake, width=sphere.stored.width, height=sphere.stored.height)
        return _write_buckets(sidecar, pixels, stored, sphere_spec(sidecar, spec), folder)
    if found.text("layout") != SHARED:
        pixels, facts = read_buckets(sidecar)
        written = _write_buckets(sidecar, pixels, facts, spec, folder)
        for layer in spec.layers:
            written |= _write_layer_of_buckets(sidecar, facts, layer, spec, folder)
        return written
    shared = read_shared_sidecar(sidecar)
    if spec.arrangement is not Arrangement.MATRIX or (spec.levels or 1) > 1:
        raise InputError(f"{sidecar} is of the shared layout: leave --arrangement and --levels out")
    if shared.condensed is not None:
        return _copy_condensed(sidecar, shared, spec, folder)
    return {layer: _write_layer(sidecar, shared, layer, spec, folder) for layer in shared.shapes}


def _write_layer_of_buckets(
    sidecar: Path, facts: Sidecar, layer: str, spec: ExportSpec, folder: Path
) -> dict[str, TextureEntry]:
    """A part of the light, stored as the whole is, the base as an image; exactly where it is below 0."""
    image = read_layer(sidecar, layer)
    if layer == BASE:
        return {layer: _write_image(image_path(sidecar, layer), image, spec, folder, None)}
    if image.min() < 0:
        spec = replace(spec, format=_EXACT.get(spec.format, spec.format))
    return _write_buckets(sidecar, image, facts, spec, folder, layer)


def _write_buckets(
    sidecar: Path, pixels: Floats, facts: Sidecar, spec: ExportSpec, folder: Path, layer: str = ""
) -> dict[str, TextureEntry]:
    """The atlas itself, or a `layer` of its size."""
    source, layout = image_path(sidecar, layer), AtlasLayout(facts.width, facts.height, facts.bucket)
    sliced = spec.arrangement is Arrangement.SLICES
    if spec.format is TextureFormat.EXR:
        if sliced or (spec.levels or 1) > 1:
            raise InputError(f"{source} holds one image: for slices or levels choose --format ktx2-rgba16f")
        check_limit(source, layout.pixel_width, layout.pixel_height, spec)
        pages = Pages(1, 1, layout.width, layout.height)
        return {layer or facts.kind: _copy_exr(source, folder, pixels, Arranged.MATRIX, pages)}
    levels, pages = (_sliced if sliced else _paged)(source, layout, spec)
    is_array = sliced or pages.layers > 1
    container = container_of(source, spec, is_array)
    kind = choice(source, pixels, spec, container, straddled_layout(layout, spec, container))
    light = pixels if pixels.shape[2] > 1 else np.repeat(pixels, 3, axis=2)
    images = _slices(light, layout, levels) if sliced else _matrix(light, layout, levels, pages)
    texture = encode_texture(_chain(images, spec), kind, is_array)
    path = folder / source.with_suffix(f".{container}").name
    zstd = _write(path, container, texture, spec, premultiplied=True)
    texels = (layout.width, layout.height)
    arranged = Arranged.SLICES if sliced else Arranged.MATRIX
    entry = _entry(path, container, texture, zstd, arranged, texels, pages)
    return {layer or facts.kind: replace(entry, levels=levels)}


def _paged(source: Path, layout: AtlasLayout, spec: ExportSpec) -> tuple[int, Pages]:
    """How many levels a matrix has, and its pages, as few as the limit allows."""
    limit = min(spec.most_pixels, MOST_PIXELS)
    fitting = min(fitting_levels(layout), (limit // layout.bucket).bit_length())
    levels = checked_levels(source, layout, spec) or max(1, fitting)
    return levels, fitting_pages(layout, limit, levels)


def _sliced(source: Path, layout: AtlasLayout, spec: ExportSpec) -> tuple[int, Pages]:
    """How many mip levels slices have, all by themselves, and the one page of their texels."""
    check_limit(source, layout.width, layout.height, spec)
    levels = checked_levels(source, layout, spec) or most_levels(layout.width, layout.height)
    return levels, Pages(1, 1, layout.width, layout.height)


def _matrix(pixels: Floats, layout: AtlasLayout, levels: int, pages: Pages) -> list[Floats]:
    """The levels (layers, H, W, C) of the bucket matrix, a layer for each page."""
    stored = padded_layout(layout, levels)
    images = []
    for level, image in enumerate(level_chain(pixels, layout, levels)):
        here = AtlasLayout(stored.width >> level, stored.height >> level, layout.bucket)
        images.append(split_pages(image, here, pages.at_level(level)))
    return images


def _slices(pixels: Floats, layout: AtlasLayout, levels: int) -> list[Floats]:
    """The levels (layers, H, W, C) of the slices."""
    return mip_chain(to_slices(pixels, layout))[:levels]


def _chain(images: list[Floats], spec: ExportSpec) -> list[Floats]:
    """The levels as the target loads them: Godot wants all, though no lookup reads the further ones."""
    if spec.target is not Target.GODOT or len(images) == 1:
        return images
    return [*images, *mip_chain(images[-1])[1:]]


def _write_layer(
    sidecar: Path, shared: SharedSidecar, layer: str, spec: ExportSpec, folder: Path
) -> TextureEntry:
    """One image of a bake in the shared layout."""
    source, image = layer_path(sidecar, layer), read_shared_layer(sidecar, shared, layer)
    straddled = None if layer in _SMOOTH else straddled_bucket(shared.bake.bucket, border=1)
    return _write_image(source, image, spec, folder, straddled, exact=layer.endswith(ENDS))


def _write_image(
    source: Path, image: Floats, spec: ExportSpec, folder: Path, straddled: str | None, exact: bool = False
) -> TextureEntry:
    """An image as a texture; `exact` or with values below 0 in RGBA16F, whatever `spec` says.

    Blocks beyond its edge are filled with its last pixels.
    """
    height, width = image.shape[:2]
    check_limit(source, width, height, spec)
    if spec.format is TextureFormat.EXR:
        return _copy_exr(source, folder, image, Arranged.IMAGE, Pages(1, 1, width, height))
    container, kind = container_of(source, spec, is_array=False), PixelFormat.RGBA16F
    if not exact and image.min() >= 0:
        kind = choice(source, image, spec, container, straddled)
    if kind is PixelFormat.BC6H:
        image = np.pad(image, ((0, -height % _BLOCK), (0, -width % _BLOCK), (0, 0)), mode="edge")
    texture = encode_texture([image[None]], kind)
    path = folder / source.with_suffix(f".{container}").name
    zstd = _write(path, container, texture, spec, premultiplied=False)
    pages = Pages(1, 1, texture.width, texture.height)
    return _entry(path, container, texture, zstd, Arranged.IMAGE, (width, height), pages)


def _copy_condensed(
    sidecar: Path, shared: SharedSidecar, spec: ExportSpec, folder: Path
) -> dict[str, TextureEntry]:
    """The textures of a condensed bake, byte for byte."""
    if spec.format not in _CONDENSED:
        raise InputError(f"{sidecar} is condensed, its textures are DDS files already: leave --format out")
    digests = shared.condensed.digests if shared.condensed else {}
    entries = {}
    for layer, (width, height, _) in shared.shapes.items():
        source = texture_path(sidecar, layer)
        if digest(source) != digests[layer]:
            raise FormatError(
                f"{source} is of another bake than {sidecar}: put one bake's files together, or bake again"
            )
        kind, blocks, stored_width, stored_height = read_dds(source)
        texture = Texture(kind.pixel_format, stored_width, stored_height, (blocks[None],))
        check_limit(source, stored_width, stored_height, spec)
        path, pages = _copied(source, folder), Pages(1, 1, stored_width, stored_height)
        entries[layer] = _entry(path, Container.DDS, texture, False, Arranged.IMAGE, (width, height), pages)
    return entries


def _write(path: Path, container: Container, texture: Texture, spec: ExportSpec, premultiplied: bool) -> bool:
    """Write a texture; whether it is packed by Zstandard."""
    if container is Container.DDS:
        write_texture(path, texture)
        return False
    write_ktx2(path, texture, spec.zstd, premultiplied)
    return spec.zstd


def _copy_exr(source: Path, folder: Path, image: Floats, arranged: Arranged, pages: Pages) -> TextureEntry:
    height, width = image.shape[:2]
    return TextureEntry(
        file=_copied(source, folder).name,
        container=Container.EXR,
        format=PixelFormat.RGBA16F,
        zstd=False,
        arrangement=arranged,
        size=(width, height),
        layers=1,
        texels=(pages.width, pages.height),
        stored=(pages.width, pages.height),
        levels=1,
        pages=(1, 1),
        page_texels=(pages.width, pages.height),
    )


def _copied(source: Path, folder: Path) -> Path:
    path = folder / source.name
    with replacing(path) as beside:
        shutil.copyfile(source, beside)
    return path


def _entry(
    path: Path,
    container: Container,
    texture: Texture,
    zstd: bool,
    arranged: Arranged,
    texels: tuple[int, int],
    pages: Pages,
) -> TextureEntry:
    return TextureEntry(
        file=path.name,
        container=container,
        format=texture.format,
        zstd=zstd,
        arrangement=arranged,
        size=(texture.width, texture.height),
        layers=texture.layers,
        texels=texels,
        stored=(pages.columns * pages.width, pages.rows * pages.height),
        levels=len(texture.levels),
        pages=(pages.columns, pages.rows),
        page_texels=(pages.width, pages.height),
    )
