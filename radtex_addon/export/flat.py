# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The flat lightmap: what a texel shows on the mean, for viewers that do not know radiance textures.

Each texel's radiance is averaged over the solid angle of the hemisphere above it.
"""

from __future__ import annotations

from collections.abc import Generator
from pathlib import Path

import numpy as np

from ..bake.kinds import KINDS, Kind, Light
from ..core.arrays import Bools, Floats
from ..core.atlas import AtlasLayout
from ..core.errors import FormatError
from ..core.gutter import LEAST_AGREEMENT, dilate, gutter_agreement, nearest_covered
from ..core.hemisphere import equisolid_inverse
from ..core.shared import SharedAtlas, sample_shared
from ..core.solid_angle import cell_solid_angles_sr
from ..core.surface import SurfaceMesh
from ..core.texel_map import TexelMap, covered_texels, rasterise
from ..core.transfer import mean_over_lights
from ..formats.bucket_rows import open_buckets
from ..formats.exr import stored_compression
from ..formats.gutter_signature import loss_of, own_texels
from ..formats.image_rows import ImageRows
from ..formats.png import encode_png
from ..formats.shadow_files import KIND as SHADOW
from ..formats.shadow_files import visible_buckets
from ..formats.shared_files import read_shared
from ..formats.sidecar import Sidecar, read_sidecar
from ..formats.transfer_files import read_transfer
from .progress import Step, Task

DIRECTIONS = 64  # that a texel of the shared layout is looked at from
_EACH = 8  # directions between two signs of life
_GOLDEN = np.pi * (3 - np.sqrt(5))
_ROUNDED = 1e-4  # by how much the means of equal buckets may differ
_RGBA = 4
_OPAQUE = 0.999  # alpha: half floats' means fall a trifle short of 1
_LEAST_ALPHA = 1 / 512  # what eight bits round to nothing
_BRIGHT = 99.5  # percent of the texels that the picture shows unclipped


def flat_buckets(sidecar: Path, surface: SurfaceMesh) -> Floats:
    """The mean light (H, W, 3 or 4) of each bucket of an atlas, float32, row 0 at v = 0.

    Where what is seen is clear somewhere, alpha's mean is the fourth channel, and light premultiplied. Of
    kinds that hold no light it is how much is open, in grey.

    Raises FormatError for files that cannot be read, and a surface that the atlas is not of.
    """
    if read_sidecar(sidecar).kind == SHADOW:
        pixels, facts = visible_buckets(sidecar)
        light = mean_of_buckets(pixels, AtlasLayout(facts.width, facts.height, facts.bucket))
    else:
        image, facts = open_buckets(sidecar)
        light = _means(image, facts)
    _check_means(sidecar, covered_texels(surface, facts.width, facts.height), light)
    return light


def _means(image: ImageRows, facts: Sidecar) -> Floats:
    """The means of an image's buckets, of what is opaque all over without alpha."""
    light = KINDS[Kind(facts.kind)].light
    used = slice(3, None) if light is Light.OCCLUSION else slice(3)
    if light is Light.LEAVING and image.channels == _RGBA and _is_clear(image):
        used = slice(_RGBA)
    means = []
    for _, band in image.bands(facts.bucket):
        some = AtlasLayout(facts.width, len(band) // facts.bucket, facts.bucket)
        means.append(mean_of_buckets(band[..., used], some))
    return np.concatenate(means)


def _is_clear(image: ImageRows) -> bool:
    return any((rows[..., 3] < _OPAQUE).any() for _, rows in image.bands())


def flat_sphere(sidecar: Path, surface: SurfaceMesh) -> Floats:
    """What the texels of a bake of kind `transfer` show under white surroundings: as `flat_buckets`."""
    pixels, facts = read_transfer(sidecar)
    light = mean_over_lights(pixels, facts.layout, facts.views)[..., :3]
    _check_means(sidecar, covered_texels(surface, facts.layout.width, facts.layout.height), light)
    return light


def mean_of_buckets(pixels: Floats, layout: AtlasLayout) -> Floats:
    """The mean (H, W, C), float32, of an atlas (H*n, W*n, C), each cell weighing its solid angle.

    Of one channel it is grey, (H, W, 3).
    """
    weight = (cell_solid_angles_sr(layout.bucket) / (2 * np.pi)).astype(np.float32)
    buckets = layout.to_buckets(pixels)
    rows = (np.einsum("wqpc,qp->wc", row.astype(np.float32), weight) for row in buckets)
    light: Floats = np.stack(list(rows))
    return np.broadcast_to(light, (*light.shape[:2], 3)) if light.shape[2] == 1 else light


def flat_shared(sidecar: Path, surface: SurfaceMesh) -> Generator[Step, None, Floats]:
    """The mean light (H, W, 3) of each texel of a bake in the shared layout, float32, row 0 at v = 0.

    Raises FormatError for files that cannot be read, and a surface that the atlas is not of.
    """
    atlas, facts = read_shared(sidecar)
    texels = rasterise(surface, facts.bake.width, facts.bake.height)
    _check_surface(sidecar, texels.covered, *own_texels(sidecar, atlas, facts))
    return (yield from mean_of_shared(atlas, texels))


def _check_means(sidecar: Path, covered: Bools, means: Floats) -> None:
    """`_check_surface` by the means of buckets."""
    loss = max(loss_of(stored_compression(sidecar.with_suffix(".exr"))), _ROUNDED)
    _check_surface(sidecar, covered, means, loss)


def _check_surface(sidecar: Path, covered: Bools, stored: Floats, loss: float) -> None:
    """Raise FormatError where an atlas's gutter is not that of a surface."""
    if gutter_agreement(covered, stored, loss) < LEAST_AGREEMENT:
        raise FormatError(
            f"the preview beside {sidecar} is of another bake: bake it again with --save-preview"
        )


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


def flat_png(light: Floats) -> tuple[bytes, float]:
    """A PNG of light (H, W, 3 or 4), row 0 at v = 0, in sRGB; and by what the light was multiplied for that.

    That is 1 unless more than a few texels are brighter than white. Of premultiplied light with alpha the
    picture has the colour of what is there, as PNG and glTF want it.
    """
    colour, alpha = light[..., :3], np.clip(light[..., 3:], 0, 1)
    if alpha.size:
        colour = np.divide(colour, alpha, out=np.zeros_like(colour), where=alpha > _LEAST_ALPHA)
    brightest = float(np.percentile(colour.max(axis=2), _BRIGHT))
    scale = 1 / brightest if brightest > 1 else 1.0
    return encode_png(np.concatenate([srgb(colour * scale), alpha], axis=2)[::-1]), scale


def srgb(linear: Floats) -> Floats:
    """Display values of linear light, clipped to 0..1. Formula: IEC 61966-2-1."""
    light = np.clip(linear, 0, 1)
    shown: Floats = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    return shown
