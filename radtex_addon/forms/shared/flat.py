# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The flat lightmap of a bake in the shared layout: each texel's mean light over the hemisphere."""

from __future__ import annotations

from collections.abc import Generator

import numpy as np

from ...core.arrays import Floats
from ...core.gutter import dilate, nearest_covered
from ...core.shared import SharedAtlas, sample_shared
from ...core.surface import SurfaceMesh
from ...core.texel_map import TexelMap, rasterise
from ...formats.gutter_signature import own_texels
from ...formats.shared_files import read_shared
from ...formats.sidecar_file import SidecarFile
from ...textures.export_progress import Step, Task
from ...textures.flat_lightmap import check_surface, even_directions

DIRECTIONS = 64  # from which each texel is looked at
_EACH = 8  # directions between two reports of progress


def flat_shared(sidecar: SidecarFile, surface: SurfaceMesh) -> Generator[Step, None, Floats]:
    """The mean light (H, W, 3) of each texel of a bake in the shared layout, float32, row 0 at v = 0.

    Raises FormatError for files that cannot be read, and if the atlas is of another surface.
    """
    atlas, facts = read_shared(sidecar)
    texels = rasterise(surface, facts.bake.width, facts.bake.height)
    check_surface(sidecar.path, texels.covered, *own_texels(sidecar.path, atlas, facts))
    return (yield from mean_of_shared(atlas, texels))


def mean_of_shared(atlas: SharedAtlas, texels: TexelMap) -> Generator[Step, None, Floats]:
    """The mean light (H, W, 3) of an atlas's `texels`, over evenly spread directions of the hemisphere."""
    height, width = texels.covered.shape
    rows, columns = np.nonzero(texels.covered)
    uv = ((np.stack([columns, rows], axis=1) + 0.5) / (width, height)).astype(np.float32)
    normal, tangent = texels.normal[rows, columns], texels.tangent[rows, columns]
    bitangent = texels.sign[rows, columns, None] * np.cross(normal, tangent)
    total = np.zeros((len(rows), 3))
    for done, (x, y, z) in enumerate(even_directions(DIRECTIONS)):
        if done % _EACH == 0:
            yield Step(Task.FLAT, done, DIRECTIONS)
        viewer = (x * tangent + y * bitangent + z * normal).astype(np.float32)
        total += sample_shared(atlas, uv, normal, viewer)
    light = np.zeros((height, width, 3), dtype=np.float32)
    light[rows, columns] = total / DIRECTIONS
    return dilate(light, nearest_covered(texels.covered))
