# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake of kind `shadow` as a texture of whole numbers."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ...core.errors import InputError
from ...formats.codecs.bc7 import Blocks
from ...formats.containers.ktx2 import write_ktx2
from ...formats.containers.texture import PixelFormat, Texture
from ...formats.shadow_files import Words, read_shadow_of
from ...textures.entry import Arranged, Container, TextureEntry
from ...textures.spec import Arrangement, ExportSpec, TextureFormat


def write_shadow_texture(sidecar: Path, spec: ExportSpec, folder: Path) -> dict[str, TextureEntry]:
    """Write the bits of the bake `sidecar` into `folder` as KTX2; the entry of its one texture.

    A pixel a texel, the bottom row first: R32UI where a word is enough, else RG32UI, an array of it where two
    are not: layer k has the words 2 k and 2 k + 1. Raises InputError for what bits cannot be, FormatError for
    files that cannot be read, BakeError where the system refuses.
    """
    if spec.format is not TextureFormat.AUTO:
        raise InputError(f"{sidecar} holds bits, not light: leave --format out")
    if spec.arrangement is not Arrangement.MATRIX or (spec.levels or 1) > 1:
        raise InputError(f"{sidecar} holds bits, which are not blended: leave --arrangement and --levels out")
    words, facts = read_shadow_of(sidecar)
    if max(facts.width, facts.height) > spec.most_pixels:
        size = f"{facts.width} x {facts.height} pixels"
        raise InputError(f"{sidecar} would be a texture of {size}: raise the limit of {spec.most_pixels}")
    texture = shadow_texture(words)
    path = folder / sidecar.with_suffix(".ktx2").name
    write_ktx2(path, texture, spec.zstd, premultiplied=False)
    texels = (facts.width, facts.height)
    entry = TextureEntry(
        file=path.name,
        container=Container.KTX2,
        format=texture.format,
        zstd=spec.zstd,
        arrangement=Arranged.WORDS,
        size=texels,
        layers=texture.layers,
        texels=texels,
        stored=texels,
        levels=1,
        pages=(1, 1),
        page_texels=texels,
    )
    return {facts.kind: entry}


def shadow_texture(words: Words) -> Texture:
    """Words (H, W, w), row 0 at the bottom, as a texture."""
    height, width, count = words.shape
    if count == 1:
        return Texture(PixelFormat.R32UI, width, height, (_pixels(words[None]),))
    pairs = np.pad(words, ((0, 0), (0, 0), (0, count % 2))).reshape(height, width, -1, 2)
    layers = pairs.transpose(2, 0, 1, 3)
    return Texture(PixelFormat.RG32UI, width, height, (_pixels(layers),), is_array=count > 2)


def _pixels(words: Words) -> Blocks:
    return np.ascontiguousarray(words, dtype="<u4").view(np.uint8)
