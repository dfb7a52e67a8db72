# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The flat lightmap of a bake in the shared layout: the mean of what each texel shows in even directions."""

from __future__ import annotations

from collections.abc import Generator
from pathlib import Path

import numpy as np

from ...core.arrays import Floats
from ...core.gutter import dilate, nearest_covered
from ...core.hemisphere import equisolid_inverse
from ...core.shared import SharedAtlas, sample_shared
from ...core.surface import SurfaceMesh
from ...core.texel_map import TexelMap, rasterise
from ...formats.gutter_signature import own_texels
from ...formats.shared_files import read_shared
from ...textures.flat import check_surface
from ...textures.progress import Step, Task

DIRECTIONS = 64  # that a texel is looked at from
_EACH = 8  # directions between two signs of life
_GOLDEN = np.pi * (3 - np.sqrt(5))


def flat_shared(sidecar: Path, surface: SurfaceMesh) -> Generator[Step, None, Floats]:
    """The mean light (H, W, 3) of each texel of a bake in the shared layout, float32, row 0 at v = 0.

    Raises FormatError for files that cannot be read, and a surface that the atlas is not of.
    """
    atlas, facts = read_shared(sidecar)
    texels = rasterise(surface, facts.bake.width, facts.bake.height)
    check_surface(sidecar, texels.covered, *own_texels(sidecar, atlas, facts))
    return (yield from mean_of_shared(atlas, texels))


def mean_of_shared(atlas: SharedAtlas, texels: TexelMap) -> Generator[Step, None, Floats]:
    """The same of an atlas: its texels are seen from directions that share the hemisphere evenly."""
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


def even_directions(count: int) -> Floats:
    """Directions (count, 3) in the frame, each standing for as much solid angle: a sunflower's seeds.

    The projection keeps areas, so that what is even on the disc is even on the hemisphere.
    """
    index = np.arange(count)
    radius, angle = np.sqrt((index + 0.5) / count), index * _GOLDEN
    return equisolid_inverse(np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1))
