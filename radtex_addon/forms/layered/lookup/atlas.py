# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a layered bake keeps, and how it is looked up."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np

from ....bake.light_samples import Some
from ....bake.pooling import corner_cells, corners
from ....core.arrays import Floats, Ints
from ....core.fragments import Fragments
from ....core.octahedron import direction_to_octahedron
from ....core.sampler import bilinear, bilinear_texels
from .environment import Around, Lit
from .images import ImageLook, Look
from .lobes import Brushed, Material, bent, falloff_at, lifted, seen_free, shown_at
from .ways import Through, look_through

_STEEP = 0.3  # cosine between the mesh's normal and a shading normal, below which that is not used
_LEAST_COSINE = 1e-3
_LEAST_LEFT = 0.5  # of the light: the rest, in coarse cells, takes no more away beside a highlight


@dataclass(frozen=True, eq=False)
class LayeredAtlas:
    """A bake in the layered layout; float32, scene-linear Rec.709, row 0 at v = 0, space the world's.

    `colour` (H', W', 3), `irradiance` (H, W, 3), and each material's `falloff`
    (M, B, 3). `tint`
    (H', W', 3): what lobes' weights are multiplied by; `normal` (H', W', 3), the shading normal in world
    space; `width` (H, W, 1): log2 of what lobes' width² is multiplied by; None where they do not vary.
    `tangent` (H, W, 3): along what brushed materials are, in world space; None without any. `own`
    (h, w, n, n, 4): what a texel sees of the object itself along an axis of the octahedron, and how much it
    leaves free; `rest` (h, w, m, m, 3), or of every texel, (H, W, m, m, 3). `through`: the light that comes
    through, if there is any. `alpha` (H', W', 1), None where it is 1 everywhere: `colour` and `tint` are
    multiplied by it, and nothing else is.
    `looks`: for each material how its own images replace `colour`, `tint` and `normal`, None where it has
    none; empty where no material has.
    """

    colour: Floats
    irradiance: Floats
    falloff: Floats
    tint: Floats | None
    normal: Floats | None
    width: Floats | None
    around: Around
    materials: tuple[Material, ...]
    own: Floats
    rest: Floats
    through: Through | None = None
    alpha: Floats | None = None
    tangent: Floats | None = None
    looks: tuple[ImageLook | None, ...] = ()


def look_at(atlas: LayeredAtlas, at: Fragments) -> Look:
    """The materials at fragments by the atlas's maps."""
    alpha = alpha_at(atlas, at.uv)
    tint = np.repeat(alpha[:, None], 3, axis=1) if atlas.tint is None else bilinear(atlas.tint, at.uv)
    normal = at.normal
    if atlas.normal is not None:
        normal = bilinear(atlas.normal, at.uv)
        normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-6)
    return Look(bilinear(atlas.colour, at.uv), tint, normal)


def shading_normal(look: Look, at: Fragments) -> Floats:
    """The normals (N, 3) by which fragments are lit: not those of a map that lean too far from the mesh's."""
    agrees = (look.normal * at.normal).sum(axis=1, keepdims=True) > _STEEP
    return cast(Floats, np.where(agrees, look.normal, at.normal))


def sample_layered(atlas: LayeredAtlas, at: Fragments, look: Look | None = None) -> Floats:
    """Radiance seen at fragments, (N, 3) float32, linear, premultiplied by `alpha_at` them.

    `look` is what their materials' own images say, None for the atlas's maps. Raises ValueError where light
    comes through and fragments have no tangents.
    """
    look = look or look_at(atlas, at)
    normal = shading_normal(look, at)
    cosine = (normal * at.viewer).sum(axis=1)
    axis = (2 * cosine[:, None] * normal - at.viewer).astype(np.float32)
    axis = lifted(axis.T, at.normal.T).T
    cosine = np.maximum(cosine, _LEAST_COSINE)
    irradiance = bilinear(atlas.irradiance, at.uv)
    light = look.colour * irradiance
    light = light * falloff_at(atlas.falloff, at.material, cosine)
    own = look_up(atlas.own, at.uv, axis)
    offset = at.position - atlas.around.middle
    width = np.ones(len(axis), np.float32) if atlas.width is None else 2 ** bilinear(atlas.width, at.uv)[:, 0]
    direct, share = mirrored_light(
        atlas.around, atlas.materials, offset, axis, normal, cosine, at.material, width,
        own[3], atlas.own.shape[2], Lit.of(at.normal, irradiance, look.colour), at.spread,
        None if atlas.tangent is None else bilinear(atlas.tangent, at.uv),
    )  # fmt: skip
    mirrored = direct + share * own[:3]
    alpha = alpha_at(atlas, at.uv)
    mirrored *= shown_at(atlas.materials, at.material, cosine, look.tint, width, alpha).T
    rest = alpha * look_up(atlas.rest, at.uv, axis)
    light = light + mirrored.T
    light = np.maximum(light + rest.T, _LEAST_LEFT * light)
    if atlas.through is not None:
        if at.tangent is None or at.bitangent is None:
            raise ValueError("light comes through: fragments need tangents")
        frame = (at.tangent, at.bitangent, at.normal)
        through = look_through(atlas.through, atlas.around, at.uv, offset, frame, at.viewer)
        light = light + (alpha * (through + look_up(atlas.through.rest, at.uv, -at.viewer))).T
    return cast(Floats, np.maximum(light, 0).astype(np.float32))


def alpha_at(atlas: LayeredAtlas, uv: Floats) -> Floats:
    """How much of what is behind fragments is hidden, at texture coordinates (N, 2): (N,) float32."""
    if atlas.alpha is None:
        return np.ones(len(uv), dtype=np.float32)
    return cast(Floats, bilinear(atlas.alpha, uv)[:, 0].astype(np.float32))


def mirrored_light(
    around: Around,
    materials: Sequence[Material],
    offset: Floats,
    axis: Floats,
    normal: Floats,
    cosine: Floats,
    material: Ints,
    width: Floats,
    free: Floats,
    cells: int,
    lit: Lit | None = None,
    spread: Floats | None = None,
    tangent: Floats | None = None,
) -> tuple[Floats, Floats]:
    """What lobes show of the surroundings, (3, N), and how much they show of the object itself, (3, N).

    `offset` (N, 3) is from the middle, `axis` (N, 3) the mirror direction, `cosine` (N,) N.V; `width` (N,)
    what the lobes' width² is multiplied by; `free` (N,) what the kept mask of `cells` x `cells` says;
    `lit` as for `Around.look`; `spread` (N,) what is added to lobes' width², if anything; `tangent` (N, 3)
    along what they are brushed, if they are.
    """
    direct, share = (np.zeros((3, len(axis)), dtype=np.float32) for _ in range(2))
    for lobe in lobes_light(
        around, materials, offset, axis, normal, cosine, material, width, lit, spread, tangent
    ):
        lobe.add_to(direct, share, free, cells)
    return direct, share


@dataclass(frozen=True, eq=False)
class LobeLight:
    """What a lobe shows of the surroundings of `some` of N samples: `light` (3, n), and its `weight` (3, n).

    `variance` (n,): its width².
    """

    some: Some
    weight: Floats
    variance: Floats
    light: Floats

    def add_to(self, direct: Floats, share: Floats, free: Floats, cells: int) -> None:
        """Add it to what is returned by `mirrored_light`, (3, N) both; `free` and `cells` as there."""
        seen = seen_free(free[self.some], self.variance, cells)
        direct[:, self.some] += self.weight * seen * self.light
        share[:, self.some] += self.weight * (1 - seen)


def lobes_light(
    around: Around,
    materials: Sequence[Material],
    offset: Floats,
    axis: Floats,
    normal: Floats,
    cosine: Floats,
    material: Ints,
    width: Floats,
    lit: Lit | None = None,
    spread: Floats | None = None,
    tangent: Floats | None = None,
) -> Iterator[LobeLight]:
    """The lobes of all materials, with nothing before the surroundings; arguments as for `mirrored_light`."""
    for number, lobes in enumerate(materials):
        found = np.flatnonzero(material == number)
        if not len(found) or not lobes.weight.any():
            continue
        some: Some = found if len(found) < len(material) else slice(None)
        weight, variance, bend = lobes.at(cosine[some])
        turned = bent(_rows(axis, some), _rows(normal, some), bend)
        beside = _rows(offset, some)
        bounds = lit if lit is None or isinstance(some, slice) else lit.some(some)
        more = 0 if spread is None else spread[some]
        brushed = None
        if lobes.brush is not None and tangent is not None:
            wide = [one * width[some] + more for one in lobes.brush]
            brushed = Brushed.of(_rows(axis, some), _rows(normal, some), tangent[some], *wide)
        for one, wide in zip(weight, (variance * width[some] + more).astype(np.float32), strict=True):
            if not one.any():
                continue
            yield LobeLight(some, one, wide, around.look(beside, turned, wide, bounds, brushed))


def _rows(values: Floats, some: Some) -> Floats:
    """Some rows of values (N, C), whose columns lie apart in memory."""
    return values[some] if isinstance(some, slice) else values.T.take(some, axis=1).T


def look_up(buckets: Floats, uv: Floats, axis: Floats) -> Floats:
    """Buckets (H, W, n, n, C) at texture coordinates (N, 2) and axes (N, 3): (C, N), filtered in both."""
    height, width, n = buckets.shape[:3]
    flat = buckets.reshape(height * width, n * n, -1)
    corner, weights = corners(direction_to_octahedron(axis).T.astype(np.float32), n)
    cells = corner_cells(n).take(corner, axis=1)
    total = np.zeros((len(uv), flat.shape[2]), dtype=np.float32)
    for texel, share in bilinear_texels(uv.astype(np.float32), width, height):
        for cell, weight in zip(cells, weights, strict=True):
            total += (share * weight).astype(np.float32)[:, None] * flat[texel, cell]
    return cast(Floats, total.T)
