# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the condensed form's textures hold, decoded: the atlases of `shared_atlases` and files' blocks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from radtex_addon.core.arrays import Floats
from radtex_addon.core.condensed import CondensedAtlas
from radtex_addon.core.shared import Axis
from radtex_addon.formats.codecs.bc5 import decode_bc5
from radtex_addon.formats.codecs.bc6h import decode_bc6h
from radtex_addon.formats.codecs.bc7 import Blocks, decode_bc7
from radtex_addon.formats.condensed_packing import layer_values, pack_tiles, pack_weights, value_range
from radtex_addon.formats.containers.dds import DdsFormat
from radtex_addon.formats.packing import LOBE_CHANNELS, TEXTURES, WEIGHTS, lobe_layer
from tests.lookups import Lookups, relative_error
from tests.shared_lookups import shared_answers

COLUMNS = 5
Ranges = dict[Axis, Floats]


def uncompressed(atlas: CondensedAtlas) -> tuple[dict[str, Floats], Ranges]:
    """What the textures hold if nothing is lost, tiles COLUMNS side by side, and the lobes' ranges."""
    images: dict[str, Floats] = {}
    ranges: Ranges = {}
    values = layer_values(atlas)
    for lobe in atlas.lobes:
        limits = {part: value_range(values[lobe_layer(lobe.axis, part)]) for part in LOBE_CHANNELS}
        ranges[lobe.axis] = rows_of(limits)
        for part, rows in limits.items():
            grid = pack_tiles(values.pop(lobe_layer(lobe.axis, part)), rows, COLUMNS)
            layers = [lobe_layer(lobe.axis, texture) for texture in TEXTURES[part]]
            images |= zip(layers, np.split(grid, len(layers), axis=2), strict=True)
        weights = lobe_layer(lobe.axis, WEIGHTS)
        images[weights] = pack_weights(lobe.cluster, values.pop(weights)) / np.float32(255)
    return images | {name: filled_up(image) for name, image in values.items()}, ranges


def filled_up(image: Floats) -> Floats:
    """An image with more on the right and at the top, which no lookup may see."""
    more = [(0, 4 - length % 4) for length in image.shape[:2]]
    return np.pad(image, (*more, (0, 0)), constant_values=1e6)


def rows_of(limits: Mapping[str, npt.ArrayLike]) -> Floats:
    """A lobe's ranges as the shader takes them, (12, 4)."""
    rows = [np.asarray(limits[part], dtype=np.float32) for part in LOBE_CHANNELS]
    return np.concatenate([np.pad(some, ((0, 0), (0, 4 - some.shape[1]))) for some in rows])


def doubts(atlas: CondensedAtlas, lookups: Lookups) -> Floats:
    """How far each answer moves, relatively, where spreads are off by float32's step at the largest of them.

    A texture says no more: the range of a part's spreads begins near 0 and ends at tens of thousands.
    """
    dense = atlas.expanded()
    most = max(float(lobe.ends[..., 3].max()) for lobe in dense.lobes)
    step = float(np.spacing(np.float32(most / dense.sharpest))) * dense.sharpest
    answers = shared_answers(dense, lookups)
    apart = np.zeros(len(answers))
    for off in (-step, step):
        change = np.array([0, 0, 0, off])
        lobes = tuple(replace(lobe, ends=lobe.ends + change) for lobe in dense.lobes)
        moved = shared_answers(replace(dense, lobes=lobes), lookups)
        apart = np.maximum(apart, relative_error(moved, answers))
    return apart


def pixels(kind: DdsFormat, blocks: Blocks) -> Floats:
    """What a file holds, decoded by the reader."""
    if kind is DdsFormat.R8G8B8A8_UNORM:
        return blocks / np.float32(255)
    decoders = {
        DdsFormat.BC5_UNORM: decode_bc5,
        DdsFormat.BC6H_UF16: decode_bc6h,
        DdsFormat.BC7_UNORM: decode_bc7,
    }
    return decoders[kind](blocks)
