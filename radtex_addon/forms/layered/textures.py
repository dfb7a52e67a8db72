# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A layered bake as textures, with mip levels of its surroundings and irradiance, and as a flat lightmap.

Flat is each texel's mean light over the hemisphere. The gutters of `own_texels` show which UV layer the bake
is of.
"""

from __future__ import annotations

from collections.abc import Collection, Generator
from dataclasses import replace
from pathlib import Path

import numpy as np

from ...core.arrays import Floats, Ints
from ...core.errors import InputError
from ...core.fragments import Fragments
from ...core.gutter import covered_in_coarser, dilate, means_in, nearest_covered
from ...core.messages import Setting, do, leave_out
from ...core.surface import SurfaceMesh
from ...core.texel_map import TexelMap, covered_texels, rasterise
from ...formats.containers.exr import loss_of, stored_compression
from ...formats.containers.texture import PixelFormat
from ...formats.image_files import layer_path
from ...formats.sidecar_file import SidecarFile
from ...settings.rays import step_to
from ...textures.choice import choose, in_blocks, light_in_blocks
from ...textures.entry import TextureEntry
from ...textures.export_spec import Arrangement, ExportSpec, ExportStep, ExportTask, TextureFormat
from ...textures.flat_lightmap import check_surface, even_directions
from ...textures.texture_files import write_levels, write_ranged
from .blocks import FORMATS, coded, fits_blocks
from .files.arrangement import COLOUR, IRRADIANCE, OWN, REST, TINT, WORLD, unpacked
from .files.layered_files import read_layer, read_layered, read_layered_sidecar
from .files.sidecar import LayeredSidecar
from .lookup.atlas import LayeredAtlas, sample_layered
from .shader_values import CLEAR_ALPHA, of_nodes_alone

_DIRECTIONS = 64  # from which each texel is looked at
_BLACK = np.float32(1e-3)  # what counts of texels without colour
_EACH = 8  # directions between two reports of progress
_LIGHT = frozenset({COLOUR, IRRADIANCE, TINT, WORLD})  # colours without alpha, never below 0


def own_texels(path: Path, atlas: LayeredAtlas) -> tuple[Floats, float]:
    """Values (H, W, K) of the texels of the bake with the sidecar `path`, and their largest relative loss.

    The irradiance; where nothing is diffuse, and it is the same everywhere, the buckets of fewer texels.
    """
    if (atlas.irradiance != atlas.irradiance[0, 0]).any():
        return atlas.irradiance, loss_of(stored_compression(layer_path(path, IRRADIANCE)))
    layer, buckets = (OWN, atlas.own) if (atlas.own != atlas.own[0, 0]).any() else (REST, atlas.rest)
    return buckets.reshape(*buckets.shape[:2], -1), loss_of(stored_compression(layer_path(path, layer)))


def flat_layered(sidecar: SidecarFile, surface: SurfaceMesh) -> Generator[ExportStep, None, Floats]:
    """The mean light (H, W, 3) of each texel of a bake in the layered layout, float32, row 0 at v = 0.

    Raises FormatError for files that cannot be read, and if the atlas is of another surface.
    """
    atlas, facts = read_layered(sidecar)
    texels = rasterise(surface, facts.bake.width, facts.bake.height)
    stored, loss = own_texels(sidecar.path, atlas)
    covered = covered_texels(surface, facts.bake.width, facts.bake.height)
    step = step_to(stored.shape, covered.shape)
    check_surface(sidecar.path, covered_in_coarser(covered, stored.shape[:2], step), loss, stored)
    material = surface.material_numbers[texels.triangle[texels.covered]]
    return (yield from mean_of_layered(atlas, texels, material))


def mean_of_layered(
    atlas: LayeredAtlas, texels: TexelMap, material: Ints
) -> Generator[ExportStep, None, Floats]:
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
            yield ExportStep(ExportTask.FLAT, done, _DIRECTIONS)
        viewer = x * tangent + y * bitangent + z * normal
        at = Fragments(uv, normal, viewer, position, material, tangent, bitangent).single()
        total += sample_layered(atlas, at)
    light = np.zeros((height, width, 3), dtype=np.float32)
    light[rows, columns] = total / _DIRECTIONS
    return dilate(light, nearest_covered(texels.covered))


def write_layered_textures(
    sidecar: SidecarFile, spec: ExportSpec, folder: Path, without: Collection[str] = ()
) -> dict[str, TextureEntry]:
    """As `Form.write_textures`, `without` some layers, and those that no shader reads.

    What is no light becomes RGBA16F where `spec` asks for no blocks.
    """
    check_layered_textures(sidecar, spec)
    facts = read_layered_sidecar(sidecar)
    without = {*without, *of_nodes_alone(facts)}
    layers = [layer for layer in facts.shapes if layer not in without]
    return {layer: _write_layer(sidecar, facts, layer, spec, folder) for layer in layers}


def check_layered_textures(sidecar: SidecarFile, spec: ExportSpec) -> None:
    """As `Form.check_textures`."""
    if spec.arrangement is not Arrangement.MATRIX or (spec.levels or 1) > 1:
        raise InputError(
            f"{sidecar} is of the layered layout", leave_out(Setting.ARRANGEMENT, Setting.LEVELS)
        )
    if spec.format is TextureFormat.EXR:
        raise InputError(
            f"{sidecar} is of the layered layout, whose pictures have mip levels, which EXRs cannot hold",
            choose(TextureFormat.KTX2_RGBA16F),
            do("choose DDS", Setting.FORMAT, value=str(TextureFormat.DDS_RGBA16F)),
        )


def _is_in_blocks(layer: str, spec: ExportSpec) -> bool:
    kind = FORMATS.get(layer)
    return kind is not None and (light_in_blocks(spec) if kind is PixelFormat.BC6H else in_blocks(spec))


def _to_one_texel(levels: tuple[Floats, ...]) -> tuple[Floats, ...]:
    """Mip levels down to one texel, as some engines want them; of pictures no lookup reads those added."""
    while max(levels[-1].shape[:2]) > 1:
        levels = (*levels, _halved(levels[-1]))
    return levels


def _halved(level: Floats) -> Floats:
    """Half as many rows and columns, rounded down: means of two texels, or three where a side is odd."""
    for axis in (0, 1):
        count = level.shape[axis]
        half = count // 2
        place = np.arange(half)
        if count % 2 == 0:
            level = (level.take(2 * place, axis) + level.take(2 * place + 1, axis)) / 2
        elif half:
            parts = np.stack([half - place, np.full(half, half), place + 1]).astype(np.float32) / count
            parts = parts.reshape(3, *(half if number == axis else 1 for number in range(level.ndim)))
            first, second, third = (level.take(2 * place + k, axis) * parts[k] for k in range(3))
            level = first + second + third
    return level


def _levels_of_seen(image: Floats, colour: Floats, side: int) -> tuple[Floats, ...]:
    """The mip levels of irradiance (H, W, 3), padded at its end to whole blocks of `side` x `side` texels.

    A texel is the mean of those below it that somebody sees, or where nobody does, what lies there on the
    next level: so no edge darkens. What nobody sees is black, and so is its `colour` (H', W', 3), which is as
    fine or finer. Texels count by their colour, which has no levels: from afar the product of both has the
    same mean as near by. What is the same everywhere has one level.
    """
    if (image == image[0, 0]).all():
        return (image,)
    height, width = image.shape[:2]
    coloured = covered_in_coarser(colour.any(axis=2), (height, width), len(colour) / height)
    more = [(0, -height % side), (0, -width % side), (0, 0)]
    whole = np.pad(image, more, mode="edge")
    seen = (image.any(axis=2) | coloured)[..., None]
    weight = np.pad(seen * (means_in(colour, height, width) + _BLACK), more, mode="edge")
    sums, parts = _to_one_texel((whole * weight,))[1:], _to_one_texel((weight,))[1:]
    above = sums[-1] / parts[-1]
    levels: list[Floats] = []
    for total, part in zip(reversed(sums), reversed(parts), strict=True):
        places = zip(part.shape[:2], above.shape[:2], strict=True)
        rows, columns = (np.minimum(np.arange(here) // 2, there - 1) for here, there in places)
        above = np.where(part > 0, total / np.maximum(part, 1e-12), above[np.ix_(rows, columns)])
        levels.append(above)
    return (whole, *reversed(levels))


def _write_layer(
    sidecar: SidecarFile, facts: LayeredSidecar, layer: str, spec: ExportSpec, folder: Path
) -> TextureEntry:
    source, image = layer_path(sidecar.path, layer), read_layer(sidecar.path, facts, layer)
    texels = (image.shape[1], image.shape[0])
    levels: tuple[Floats, ...] = (image.astype(np.float32),)
    if layer in facts.pictures:
        picture = facts.pictures[layer]
        levels = _to_one_texel(unpacked(levels[0], picture.size, picture.levels))
        texels = (picture.size, picture.size)
    elif layer == IRRADIANCE:
        colour = read_layer(sidecar.path, facts, COLOUR)
        levels = _levels_of_seen(levels[0], colour, FORMATS[layer].side if _is_in_blocks(layer, spec) else 1)
    # a shader that decodes colours decodes all of them
    always = layer in CLEAR_ALPHA and not spec.target.traits.srgb
    if _is_in_blocks(layer, spec) and (always or fits_blocks(layer, levels[0])):
        return _write_blocks(source, layer, levels, texels, spec, folder)
    if image.shape[2] == 1:  # as grey
        levels = tuple(np.repeat(level, 3, axis=2) for level in levels)
    return write_levels(source, levels, texels, spec, folder, None, exact=layer not in _LIGHT)


def _write_blocks(
    source: Path,
    layer: str,
    levels: tuple[Floats, ...],
    texels: tuple[int, int],
    spec: ExportSpec,
    folder: Path,
) -> TextureEntry:
    found = coded(layer, levels, texels)
    texture = found.texture
    if not spec.target.traits.srgb:  # the shader decodes them
        texture = replace(texture, format=texture.format.without_srgb)
    return write_ranged(source, texture, found.texels, (found.scale, found.offset), spec, folder)
