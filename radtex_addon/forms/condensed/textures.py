# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A condensed bake as textures: its files as they are."""

from __future__ import annotations

from pathlib import Path

from ...core.errors import FormatError, InputError
from ...core.pages import Pages
from ...formats.condensed_files import digest
from ...formats.containers.dds import read_dds
from ...formats.containers.texture import Texture
from ...formats.shared_files import read_shared_sidecar, texture_path
from ...textures.choice import check_limit
from ...textures.entry import Arranged, Container, TextureEntry
from ...textures.files import copied, entry_of
from ...textures.spec import ExportSpec, TextureFormat
from ..shared.textures import check_plain_arrangement

_CONDENSED = (TextureFormat.AUTO, TextureFormat.DDS_BC6H)  # what leaves a condensed bake as it is


def copy_textures(sidecar: Path, spec: ExportSpec, folder: Path) -> dict[str, TextureEntry]:
    """As `Form.write_textures`; the files are copied byte for byte."""
    check_plain_arrangement(sidecar, spec)
    shared = read_shared_sidecar(sidecar)
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
        path, pages = copied(source, folder), Pages(1, 1, stored_width, stored_height)
        entries[layer] = entry_of(path, Container.DDS, texture, False, Arranged.IMAGE, (width, height), pages)
    return entries
