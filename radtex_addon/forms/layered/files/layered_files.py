# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The files of a bake in the layered layout: a sidecar `<name>.<kind>.json` and its EXRs beside it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from ....core.arrays import Floats
from ....formats.containers.exr import Compression, header_text, read_pixels
from ....formats.image_files import layer_path, write_images
from ....formats.sidecar import Sidecar
from ....formats.sidecar_file import AnySidecar, mismatch_error, opened, read_facts
from ..lookup.atlas import LayeredAtlas
from ..lookup.edge_grid import EdgeImpostor, EdgePictures
from ..lookup.environment import Around, Shell, SurroundingLayer
from .arrangement import (
    ALPHA,
    COLOUR,
    DISTANCES,
    EXIT_DIRECTION,
    EXIT_PLACE,
    FIELD,
    IRRADIANCE,
    NORMAL,
    OWN,
    PLANE,
    REST,
    TANGENT,
    THINGS,
    TINT,
    WIDTH,
    WORLD,
    arranged,
    through_of,
    unpacked,
    untiled,
)
from .sidecar import LayeredSidecar

_NO_LIGHT = frozenset({NORMAL, WIDTH, ALPHA, TANGENT, DISTANCES, EXIT_DIRECTION, EXIT_PLACE, FIELD, OWN})


def write_layered(
    path: Path,
    atlas: LayeredAtlas,
    bake: Sidecar,
    half: bool = True,
    compression: Compression = Compression.ZIP,
) -> LayeredSidecar:
    """Write the sidecar to `path` and the atlas's images beside it; all of them, or none.

    `bake` holds the facts that are not in the atlas; its `layers` and `clamped` are replaced in the returned
    sidecar. Values beyond the files' range, infinities included, are clamped to it. Raises ShapeError if the
    atlas does not fit `bake`, BakeError for values that are not numbers and where the system refuses.
    """
    sidecar = LayeredSidecar.of(atlas, bake)

    def with_clamped(count: int) -> LayeredSidecar:
        return replace(sidecar, bake=replace(sidecar.bake, clamped=count))

    clamped = write_images(
        path, arranged(atlas), lambda count: with_clamped(count).to_json(), half, compression, _NO_LIGHT
    )
    return with_clamped(clamped)


def read_layered(sidecar: AnySidecar) -> tuple[LayeredAtlas, LayeredSidecar]:
    """Read a bake in the layered layout; float32.

    Raises FormatError, with the path, for a sidecar or an image that is missing, damaged, not ours, of a
    newer version, of another bake, not of the size that the sidecar says, or too large for this machine's
    memory.
    """
    file = opened(sidecar)
    facts = read_layered_sidecar(file)
    with np.errstate(over="ignore", invalid="ignore"):  # a damaged file may hold any values
        images = {layer: read_layer(file.path, facts, layer) for layer in facts.shapes}
        return atlas_of({name: image.astype(np.float32) for name, image in images.items()}, facts), facts


def atlas_of(images: dict[str, Floats], facts: LayeredSidecar) -> LayeredAtlas:
    """The atlas that these images, by layer, are of."""
    found = facts.pictures
    pictures = {
        name: EdgePictures(unpacked(images[name], found[name].size, found[name].levels), found[name].sharpest)
        for name in found
    }
    layers = []
    if facts.plane is not None:
        layers.append(SurroundingLayer(pictures[PLANE], facts.plane))
    if THINGS in pictures:
        shell = facts.plane if isinstance(facts.plane, Shell) else None
        things = EdgeImpostor(images[DISTANCES][..., 0], facts.things_eye, facts.boxes, shell)
        layers.append(SurroundingLayer(pictures[THINGS], things))
    through = facts.through
    return LayeredAtlas(
        colour=images[COLOUR],
        irradiance=images[IRRADIANCE],
        falloff=facts.falloff,
        tint=images.get(TINT),
        normal=images.get(NORMAL),
        width=images.get(WIDTH),
        around=Around(facts.middle, pictures[WORLD], tuple(layers), facts.lamps),
        materials=facts.materials,
        own=untiled(images[OWN], facts.own_cells, facts.coarse),
        rest=untiled(images[REST], facts.rest_cells, facts.rest),
        through=None
        if through is None
        else through_of(images, through.exits, through.rest, facts.coarse, through.field),
        alpha=images.get(ALPHA),
        tangent=images.get(TANGENT),
        looks=facts.looks,
    )


def read_layered_sidecar(sidecar: AnySidecar) -> LayeredSidecar:
    """Read a sidecar's file. Raises FormatError, with the path, if it is missing or not of this layout."""
    return LayeredSidecar.from_facts(read_facts(sidecar))


def read_layer(path: Path, sidecar: LayeredSidecar, layer: str) -> Floats:
    """Read a layer's EXR (H, W, C) of the sidecar at `path`, as it is stored, row 0 at the bottom.

    Raises FormatError as `read_layered` does.
    """
    image = layer_path(path, layer)
    header = LayeredSidecar.from_json(header_text(image), f"the header of {image}")
    if header.to_json() != sidecar.to_json():
        raise mismatch_error(image, path)
    width, height, channels = sidecar.shapes[layer]
    return read_pixels(image, width, height, [channels])
