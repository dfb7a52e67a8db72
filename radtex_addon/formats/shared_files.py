# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The files of a bake in the shared layout: a sidecar `<name>.<kind>.json` and its images beside it.

The images are EXRs, or GPU textures (DDS) if the bake is condensed.
"""

from __future__ import annotations

from collections.abc import Generator
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from ..core.arrays import Floats
from ..core.condensed import CondensedAtlas
from ..core.errors import BakeError
from ..core.shared import SharedAtlas
from .condensed_files import StoredAtlas, digest, read_textures
from .condensed_sizes import texture_format
from .containers.dds import write_dds
from .containers.exr import Compression, header_text, read_pixels
from .disk.atomic import replacing
from .disk.memory import check_memory
from .image_files import layer_path, write_images
from .packing import (
    COLOUR,
    ENDS,
    IRRADIANCE,
    LOBE_CHANNELS,
    SURROUNDINGS,
    pack,
    unpack_lobe,
    unpack_surroundings,
)
from .shared_sidecar import SharedSidecar
from .sidecar import Sidecar
from .sidecar_file import AnySidecar, mismatch_error, opened, read_facts


def texture_path(sidecar: Path, layer: str) -> Path:
    """A condensed bake's texture beside a sidecar's file: Vase.radiance.json has Vase.radiance.colour.dds."""
    return sidecar.with_name(f"{sidecar.stem}.{layer}.dds")


def write_shared(
    path: Path,
    atlas: SharedAtlas,
    bake: Sidecar,
    half: bool = True,
    compression: Compression = Compression.ZIP,
) -> SharedSidecar:
    """Write the sidecar to `path` and the atlas's images beside it; all of them, or none.

    `bake` holds the facts that are not in the atlas; its `layers` and `clamped` are replaced in the returned
    sidecar. Values beyond the files' range, infinities included, are clamped to it. Raises ShapeError if the
    atlas does not fit `bake` or the files, BakeError for values that are not numbers and where the system
    refuses.
    """
    sidecar, images = SharedSidecar.of(atlas, bake), pack(atlas)

    def with_clamped(count: int) -> SharedSidecar:
        return replace(sidecar, bake=replace(sidecar.bake, clamped=count))

    ends = [layer for layer in images if layer.endswith(ENDS)]  # shifts and variances
    clamped = write_images(path, images, lambda count: with_clamped(count).to_json(), half, compression, ends)
    return with_clamped(clamped)


def write_condensed(path: Path, atlas: CondensedAtlas, bake: Sidecar) -> SharedSidecar:
    """Write the sidecar to `path` and the atlas's textures beside it; all of them, or none.

    `bake` holds the facts that are not in the atlas, as in `write_shared`. Values that the textures cannot
    hold are clamped and counted: light below 0 or above 65504, other values beyond ±65504, weights beyond ±1.
    A colour that is the same everywhere is stored once. Raises ShapeError if the atlas's maps do not fit each
    other, `bake` or the textures, BakeError for values that are not numbers and where the system refuses.
    """
    for _ in writing_condensed(path, atlas, bake):
        pass
    return read_shared_sidecar(path)


def writing_condensed(path: Path, atlas: CondensedAtlas, bake: Sidecar) -> Generator[str, None, None]:
    """`write_condensed` as a generator, which yields each layer's name after writing its texture.

    The files get their final names after the last layer; a generator closed before that leaves no files.
    """
    stored = StoredAtlas.of(atlas, partial(texture_path, path))
    sidecar = SharedSidecar.of(stored.atlas, replace(bake, clamped=stored.clamped), stored.facts)
    digests: dict[str, str] = {}
    with ExitStack() as files:
        beside_sidecar = files.enter_context(replacing(path))
        for layer, blocks in stored.textures():
            texture = texture_path(path, layer)
            beside = files.enter_context(replacing(texture))
            try:
                write_dds(beside, blocks, texture_format(layer))
            except BakeError as error:
                raise error.saying(error.message.problem.replace(str(beside), str(texture))) from error
            digests[layer] = digest(beside)
            yield layer
        sidecar = replace(sidecar, condensed=replace(stored.facts, digests=digests))
        beside_sidecar.write_text(sidecar.to_json(), encoding="utf-8", newline="\n")


def read_shared(sidecar: AnySidecar) -> tuple[SharedAtlas, SharedSidecar]:
    """Read a bake in the shared layout, condensed or not; float32.

    Raises FormatError, with the path, for a sidecar or an image that is missing, damaged, not ours, of a
    newer version, of another bake, not of the size that the sidecar says, or too large for this machine's
    memory.
    """
    file = opened(sidecar)
    facts = read_shared_sidecar(file)
    with np.errstate(over="ignore", invalid="ignore"):  # a damaged file may hold any values
        return _read_atlas(file.path, facts), facts


def _read_atlas(path: Path, sidecar: SharedSidecar) -> SharedAtlas:
    if sidecar.condensed is not None:
        check_memory(f"the bake of {path}", expanded_bytes(sidecar))
        return read_textures(path, sidecar, partial(texture_path, path)).expanded()
    images = {layer: read_layer(path, sidecar, layer) for layer in sidecar.shapes}
    return SharedAtlas(
        colour=images[COLOUR].astype(np.float32),
        irradiance=images[IRRADIANCE].astype(np.float32),
        falloff=np.array(sidecar.falloff, dtype=np.float32),
        surroundings=unpack_surroundings(images[SURROUNDINGS], sidecar.surroundings, sidecar.levels),
        sharpest=sidecar.sharpest,
        lobes=tuple(
            unpack_lobe(images, axis, sidecar.bake.bucket, sidecar.sharpest) for axis in sidecar.lobes
        ),
    )


def read_condensed(sidecar: AnySidecar) -> tuple[CondensedAtlas, SharedSidecar]:
    """Read a condensed bake without expanding it; float32.

    Raises FormatError as `read_shared` does, and for a bake that is not condensed.
    """
    file = opened(sidecar)
    facts = read_shared_sidecar(file)
    return read_textures(file.path, facts, partial(texture_path, file.path)), facts


def read_shared_sidecar(sidecar: AnySidecar) -> SharedSidecar:
    """Read a sidecar's file. Raises FormatError, with the path, if it is missing or not of this layout."""
    return SharedSidecar.from_facts(read_facts(sidecar))


def read_layer(path: Path, sidecar: SharedSidecar, layer: str) -> Floats:
    """Read a layer's EXR (H, W, C) of the sidecar at `path`, as it is stored, row 0 at the bottom.

    Raises FormatError as `read_shared` does.
    """
    image = layer_path(path, layer)
    if SharedSidecar.from_json(header_text(image), f"the header of {image}") != sidecar:
        raise mismatch_error(image, path)
    width, height, channels = sidecar.shapes[layer]
    return read_pixels(image, width, height, [channels])


def expanded_bytes(sidecar: SharedSidecar) -> int:
    """Bytes of memory for all texels' own buckets."""
    values = sidecar.bake.width * sidecar.bake.height * sidecar.bake.bucket**2 * sum(LOBE_CHANNELS.values())
    return 4 * values * len(sidecar.lobes)
