# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake of kind `transfer`, whose buckets hold the whole sphere, as a texture and as a flat lightmap."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from ...core.arrays import Floats
from ...core.errors import InputError
from ...core.messages import Setting, leave_out
from ...core.sampler import mean_over_lights
from ...core.surface import SurfaceMesh
from ...core.texel_map import covered_texels
from ...formats.sidecar_file import SidecarFile
from ...formats.transfer_files import open_transfer, read_transfer
from ...textures.entry import TextureEntry
from ...textures.export_spec import Arrangement, ExportSpec
from ...textures.flat_lightmap import check_means
from ...textures.matrix import write_matrix


def write_sphere(sidecar: SidecarFile, spec: ExportSpec, folder: Path) -> dict[str, TextureEntry]:
    """As `Form.write_textures`."""
    check_sphere(sidecar, spec)
    image, facts = open_transfer(sidecar)
    return {facts.bake.kind: write_matrix(image, facts.stored, replace(spec, levels=1), folder)}


def check_sphere(sidecar: SidecarFile, spec: ExportSpec) -> None:
    """As `Form.check_textures`: buckets of the whole sphere are exported as a matrix without mip levels."""
    if spec.arrangement is not Arrangement.MATRIX or (spec.levels or 1) > 1:
        raise InputError(
            f"{sidecar} has one level in a matrix", leave_out(Setting.ARRANGEMENT, Setting.LEVELS)
        )


def flat_sphere(sidecar: SidecarFile, surface: SurfaceMesh) -> Floats:
    """The flat lightmap of a bake of kind `transfer`, under white surroundings; as `Form.flat`."""
    pixels, facts = read_transfer(sidecar)
    light = mean_over_lights(pixels, facts.layout, facts.views)[..., :3]
    check_means(sidecar.path, covered_texels(surface, facts.layout.width, facts.layout.height), light)
    return light
