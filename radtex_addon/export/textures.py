# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A finished bake's images as textures that engines load.

Their first row is the bottom one, v = 0; an EXR's is the top one, as the bake wrote it.
"""

from __future__ import annotations

from pathlib import Path

from ..core.errors import FormatError, InputError
from ..core.pages import Pages
from ..formats.condensed_files import digest
from ..formats.dds import read_dds
from ..formats.packing import COLOUR, ENDS, IRRADIANCE, SURROUNDINGS
from ..formats.shadow_files import KIND as SHADOW
from ..formats.shared_files import layer_path, read_shared_sidecar, texture_path
from ..formats.shared_files import read_layer as read_shared_layer
from ..formats.shared_sidecar import LAYOUT as SHARED
from ..formats.shared_sidecar import SharedSidecar
from ..formats.sidecar import read_facts
from ..formats.texture import Texture
from ..formats.transfer_files import LAYOUT as SPHERE
from .bucket_textures import write_buckets, write_sphere
from .manifest import Arranged, Container, TextureEntry
from .shadow_texture import write_shadow_texture
from .spec import Arrangement, ExportSpec, TextureFormat
from .texture_choice import check_limit, straddled_bucket
from .texture_files import copied, entry_of, write_image

_CONDENSED = (TextureFormat.AUTO, TextureFormat.DDS_BC6H)  # what leaves a condensed bake as it is
_SMOOTH = (COLOUR, IRRADIANCE, SURROUNDINGS)  # without buckets that a block could straddle


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
        return write_sphere(sidecar, spec, folder)
    if found.text("layout") != SHARED:
        return write_buckets(sidecar, spec, folder)
    shared = read_shared_sidecar(sidecar)
    if spec.arrangement is not Arrangement.MATRIX or (spec.levels or 1) > 1:
        raise InputError(f"{sidecar} is of the shared layout: leave --arrangement and --levels out")
    if shared.condensed is not None:
        return _copy_condensed(sidecar, shared, spec, folder)
    return {layer: _write_layer(sidecar, shared, layer, spec, folder) for layer in shared.shapes}


def _write_layer(
    sidecar: Path, shared: SharedSidecar, layer: str, spec: ExportSpec, folder: Path
) -> TextureEntry:
    """One image of a bake in the shared layout."""
    source, image = layer_path(sidecar, layer), read_shared_layer(sidecar, shared, layer)
    straddled = None if layer in _SMOOTH else straddled_bucket(shared.bake.bucket, border=1)
    return write_image(source, image, spec, folder, straddled, exact=layer.endswith(ENDS))


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
        path, pages = copied(source, folder), Pages(1, 1, stored_width, stored_height)
        entries[layer] = entry_of(path, Container.DDS, texture, False, Arranged.IMAGE, (width, height), pages)
    return entries
