# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Copy a condensed bake's files as textures: they are textures already."""

from __future__ import annotations

from pathlib import Path

from ...core.errors import InputError
from ...core.messages import Setting, leave_out
from ...core.pages import Pages
from ...formats.condensed_files import digest
from ...formats.containers.dds import read_dds
from ...formats.containers.texture import Texture
from ...formats.shared_files import read_shared_sidecar, texture_path
from ...formats.sidecar_file import SidecarFile, mismatch_error
from ...textures.choice import check_limit
from ...textures.entry import Arranged, Container, TextureEntry
from ...textures.export_spec import ExportSpec, TextureFormat
from ...textures.texture_files import copied, entry_of
from ..shared.textures import check_plain_arrangement

_CONDENSED = (TextureFormat.AUTO, TextureFormat.DDS_BC6H)  # formats for which files are copied unchanged


def copy_textures(sidecar: SidecarFile, spec: ExportSpec, folder: Path) -> dict[str, TextureEntry]:
    """As `Form.write_textures`; the files are copied byte for byte."""
    check_plain_arrangement(sidecar, spec)
    shared = read_shared_sidecar(sidecar)
    if spec.format not in _CONDENSED:
        raise InputError(
            f"{sidecar} is condensed, its textures are DDS files already", leave_out(Setting.FORMAT)
        )
    digests = shared.condensed.digests if shared.condensed else {}
    entries = {}
    for layer, (width, height, _) in shared.shapes.items():
        source = texture_path(sidecar.path, layer)
        if digest(source) != digests[layer]:
            raise mismatch_error(source, sidecar)
        kind, blocks, stored_width, stored_height = read_dds(source)
        texture = Texture(kind.pixel_format, stored_width, stored_height, (blocks[None],))
        check_limit(source, stored_width, stored_height, spec)
        path, pages = copied(source, folder), Pages(1, 1, stored_width, stored_height)
        entries[layer] = entry_of(path, Container.DDS, texture, False, Arranged.IMAGE, (width, height), pages)
    return entries
