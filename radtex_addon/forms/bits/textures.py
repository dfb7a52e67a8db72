# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake of kind `shadow` as a texture of integers."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ...core.errors import InputError
from ...core.messages import Setting, leave_out
from ...formats.codecs.bc7 import Blocks
from ...formats.containers.ktx2 import write_ktx2
from ...formats.containers.texture import PixelFormat, Texture
from ...formats.shadow_files import Words, read_shadow_of
from ...formats.sidecar import read_sidecar
from ...formats.sidecar_file import SidecarFile
from ...textures.entry import Arranged, Container, TextureEntry
from ...textures.export_spec import Arrangement, ExportSpec, TextureFormat


def check_shadow_texture(sidecar: SidecarFile, spec: ExportSpec) -> None:
    """As `Form.check_textures`."""
    if spec.format is not TextureFormat.AUTO:
        raise InputError(f"{sidecar} holds bits, not light", leave_out(Setting.FORMAT))
    if spec.arrangement is not Arrangement.MATRIX or (spec.levels or 1) > 1:
        raise InputError(
            f"{sidecar} holds bits, which are not blended", leave_out(Setting.ARRANGEMENT, Setting.LEVELS)
        )
    facts = read_sidecar(sidecar)
    if max(facts.width, facts.height) > spec.most_pixels:
        size = f"{facts.width} x {facts.height} pixels"
        raise InputError(f"{sidecar} would be a texture of {size}: raise the limit of {spec.most_pixels}")


def write_shadow_texture(sidecar: SidecarFile, spec: ExportSpec, folder: Path) -> dict[str, TextureEntry]:
    """Write the bits of the bake `sidecar` into `folder` as KTX2; returns the entry of its one texture.

    One pixel per texel, the bottom row first: R32UI for one word, RG32UI for two, and for more an array of
    RG32UI, whose layer k has the words 2 k and 2 k + 1. Raises InputError for options that bits do not
    support, FormatError for files that cannot be read, BakeError where the system refuses.
    """
    check_shadow_texture(sidecar, spec)
    words, facts = read_shadow_of(sidecar)
    texture = shadow_texture(words)
    path = folder / sidecar.path.with_suffix(".ktx2").name
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
