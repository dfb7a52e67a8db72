# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The flat lightmap of a bake in the layered layout: each texel's mean light over the hemisphere."""

from __future__ import annotations

from collections.abc import Generator

import numpy as np

from ...bake.rays import step_to
from ...core.arrays import Floats, Ints
from ...core.fragments import Fragments
from ...core.gutter import covered_in_coarser, dilate, nearest_covered
from ...core.surface import SurfaceMesh
from ...core.texel_map import TexelMap, covered_texels, rasterise
from ...formats.sidecar_file import SidecarFile
from ...textures.export_spec import Step, Task
from ...textures.flat_lightmap import check_surface, even_directions
from .files.layered_files import read_layered
from .lookup.atlas import LayeredAtlas, sample_layered
from .signature import own_texels

_DIRECTIONS = 64  # from which each texel is looked at
_EACH = 8  # directions between two reports of progress


def flat_layered(sidecar: SidecarFile, surface: SurfaceMesh) -> Generator[Step, None, Floats]:
    """The mean light (H, W, 3) of each texel of a bake in the layered layout, float32, row 0 at v = 0.

    Raises FormatError for files that cannot be read, and if the atlas is of another surface.
    """
    atlas, facts = read_layered(sidecar)
    texels = rasterise(surface, facts.bake.width, facts.bake.height)
    stored, loss = own_texels(sidecar.path, atlas)
    covered = covered_texels(surface, facts.bake.width, facts.bake.height)
    step = step_to(stored.shape, covered.shape)
    check_surface(sidecar.path, covered_in_coarser(covered, stored.shape[:2], step), stored, loss)
    material = surface.material_numbers[texels.triangle[texels.covered]]
    return (yield from mean_of_layered(atlas, texels, material))


def mean_of_layered(atlas: LayeredAtlas, texels: TexelMap, material: Ints) -> Generator[Step, None, Floats]:
    """The mean light (H, W, 3) of an atlas's `texels`, over evenly spread directions of the hemisphere.

    `material` (K,): the numbers of the materials of the covered texels, row by row.
    """
    height, width = texels.covered.shape
    rows, columns = np.nonzero(texels.covered)
    uv = ((np.stack([columns, rows], axis=1) + 0.5) / (width, height)).astype(np.float32)
    normal, tangent = texels.normal[rows, columns], texels.tangent[rows, columns]
    bitangent = texels.sign[rows, columns, None] * np.cross(normal, tangent)
    position = texels.position[rows, columns]
    total = np.zeros((len(rows), 3))
    for done, (x, y, z) in enumerate(even_directions(_DIRECTIONS)):
        if done % _EACH == 0:
            yield Step(Task.FLAT, done, _DIRECTIONS)
        viewer = x * tangent + y * bitangent + z * normal
        at = Fragments(uv, normal, viewer, position, material, tangent, bitangent).single()
        total += sample_layered(atlas, at)
    light = np.zeros((height, width, 3), dtype=np.float32)
    light[rows, columns] = total / _DIRECTIONS
    return dilate(light, nearest_covered(texels.covered))
