# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Write the texture files of an exported folder, and make their manifest entries."""

from __future__ import annotations

import shutil
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from ..core.arrangements import Pages
from ..core.arrays import Floats
from ..core.messages import Message
from ..formats.containers.dds import write_texture
from ..formats.containers.ktx2 import write_ktx2
from ..formats.containers.texture import Encoded, PixelFormat, Texture, encode_texture
from ..formats.disk.atomic import replacing
from .choice import check_limit, choice, container_of
from .entry import Arranged, Container, TextureEntry
from .export_spec import ExportSpec, TextureFormat
from .stream import LightRange

_BLOCK = PixelFormat.BC6H.side


def write_image(
    source: Path,
    image: Floats,
    spec: ExportSpec,
    folder: Path,
    straddled: Message | None,
    exact: bool = False,
) -> TextureEntry:
    """Write an image as a texture; as RGBA16F if it is `exact` or has values below 0, whatever `spec` says.

    Blocks that reach beyond its edge repeat its last pixels.
    """
    height, width = image.shape[:2]
    check_limit(source, width, height, spec)
    if spec.format is TextureFormat.EXR:
        return copy_exr(source, folder, (width, height), Arranged.IMAGE, (width, height))
    return write_levels(source, (image,), (width, height), spec, folder, straddled, exact)


def write_levels(
    source: Path,
    levels: tuple[Floats, ...],
    texels: tuple[int, int],
    spec: ExportSpec,
    folder: Path,
    straddled: Message | None,
    exact: bool = False,
) -> TextureEntry:
    """Write mip levels (H, W, C), the largest first, as a texture, as `write_image` does; never as an EXR.

    `texels`: the width and height of the image; the first level may have more at its end.
    """
    image = levels[0]
    height, width = image.shape[:2]
    check_limit(source, width, height, spec)
    container, kind = container_of(source, spec, is_array=False), PixelFormat.RGBA16F
    if not exact and image.min() >= 0:
        kind = choice(source, partial(_light_of, image), spec, container, straddled)
    if kind is PixelFormat.BC6H and len(levels) == 1:
        levels = (np.pad(image, ((0, -height % _BLOCK), (0, -width % _BLOCK), (0, 0)), mode="edge"),)
    texture = encode_texture([level[None] for level in levels], kind)
    return _write_image(source, container, texture, texels, spec, folder)


def write_ranged(
    source: Path,
    texture: Texture,
    texels: tuple[int, int],
    scale_offset: tuple[float, float],
    spec: ExportSpec,
    folder: Path,
) -> TextureEntry:
    """Write an encoded image of `texels`, width and height, whose values are texels * scale + offset."""
    check_limit(source, texture.width, texture.height, spec)
    container, (scale, offset) = container_of(source, spec, is_array=False), scale_offset
    entry = _write_image(source, container, texture, texels, spec, folder)
    return replace(entry, scale=scale, offset=offset)


def _write_image(
    source: Path,
    container: Container,
    texture: Texture,
    texels: tuple[int, int],
    spec: ExportSpec,
    folder: Path,
) -> TextureEntry:
    path = folder / source.with_suffix(f".{container}").name
    zstd = write_encoded(path, container, texture, spec, premultiplied=False)
    pages = Pages(1, 1, texture.width, texture.height)
    return entry_of(path, container, texture, zstd, Arranged.IMAGE, texels, pages)


def write_encoded(
    path: Path, container: Container, texture: Encoded, spec: ExportSpec, premultiplied: bool
) -> bool:
    """Write a texture. Returns whether it is compressed with Zstandard."""
    if container is Container.DDS:
        write_texture(path, texture)
        return False
    write_ktx2(path, texture, spec.zstd, premultiplied)
    return spec.zstd


def copy_exr(
    source: Path, folder: Path, size: tuple[int, int], arranged: Arranged, texels: tuple[int, int]
) -> TextureEntry:
    """Copy an EXR of `size` pixels, width and height, which holds `texels`. Returns its manifest entry."""
    return TextureEntry(
        file=copied(source, folder).name,
        container=Container.EXR,
        format=PixelFormat.RGBA16F,
        zstd=False,
        arrangement=arranged,
        size=size,
        layers=1,
        texels=texels,
        stored=texels,
        levels=1,
        pages=(1, 1),
        page_texels=texels,
    )


def copied(source: Path, folder: Path) -> Path:
    """Copy a file into the folder. Returns its path there. Raises BakeError if the system refuses."""
    path = folder / source.name
    with replacing(path) as beside:
        shutil.copyfile(source, beside)
    return path


def entry_of(
    path: Path,
    container: Container,
    texture: Encoded,
    zstd: bool,
    arranged: Arranged,
    texels: tuple[int, int],
    pages: Pages,
) -> TextureEntry:
    """The manifest entry of the file `path`, which holds `texels`."""
    form = texture.form
    return TextureEntry(
        file=path.name,
        container=container,
        format=form.format,
        zstd=zstd,
        arrangement=arranged,
        size=(form.width, form.height),
        layers=form.layers,
        texels=texels,
        stored=(pages.columns * pages.width, pages.rows * pages.height),
        levels=form.levels,
        pages=(pages.columns, pages.rows),
        page_texels=(pages.width, pages.height),
    )


def _light_of(image: Floats) -> LightRange:
    opaque = image.shape[2] < 4 or bool((image[..., 3].astype(np.float16) == 1).all())
    return LightRange(opaque, float(image[..., :3].min()))
