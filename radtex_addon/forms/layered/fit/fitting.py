# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Fitting the layered layout to its captures."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import dataclass, replace
from typing import cast

import numpy as np

from ....bake.blocks import in_blocks
from ....bake.computed_rows import computed
from ....bake.light_samples import EndSamples, LightSamples
from ....bake.plan import CapturePlan
from ....bake.pooling import Neighbours
from ....bake.progress import Progress, Stage
from ....core import large_arrays
from ....core.arrays import Bools, Floats, Ints, blocks
from ....core.octahedron import cell_directions
from ....settings.rays import coarser
from ..cells import CELLS
from ..lookup.atlas import LayeredAtlas
from ..lookup.environment import Around, Lit
from ..lookup.lobes import LOWEST, Material
from ..lookup.ways import Through
from ..samples import LayeredSamples
from .bucket_grid import BucketGrid
from .buckets import ALL_PARTS, Parts, fit_buckets, free_share
from .diffuse import facing_of, fit_falloffs, fit_irradiance
from .glow import fit_glow
from .known import Known
from .light_map import LightMap
from .lobes import Paths
from .own_light import Surface
from .texel_maps import at_texels, mean_colours, shading_normals, tints
from .through import fit_through, fit_through_rest
from .turned import mirrored_about, octahedral
from .view_dependence import view_dependence
from .widths import Lobes, fit_lobes

_STEPS = 5  # of progress
_ROWS = 1 << 12  # texels whose samples are in hand at once
_ABOVE = 1.1 * LOWEST  # sine above mesh and facet: of axes that are lower, Cycles turns the shading normal
_FREE = 0.98  # of a direction, above which a path is taken to leave the object straight away


def fit_layered(
    capture: LayeredSamples, parts: Parts = ALL_PARTS, known: Known | None = None, imaged: Sequence[bool] = ()
) -> Generator[Progress, None, LayeredAtlas]:
    """Fit the layered layout to a capture; what is `known` of a bake that is there stays. Yields progress.

    `imaged`: of which materials their own images take the place of the map of colours, which then tells none
    of their glow; of none, if empty.
    """
    yield Progress(Stage.FIT, 0, _STEPS)
    light, plan = capture.light, capture.light.plan
    neighbours = Neighbours(plan)
    facing = facing_of(light)
    used, count = _counted(facing), capture.material_count
    around = _around(capture.around, parts)
    maps = (capture.fine, capture.coarse)
    normal, normal_map = shading_normals(plan, *maps, parts.normals)
    tint, tint_map = tints(plan, capture.material, *maps, parts.tint)
    grid = BucketGrid.of(plan, coarser(max(plan.layout.width, plan.layout.height)))
    matt = _matt(capture, facing, neighbours, parts, known, imaged)
    light = matt.light
    del facing
    yield Progress(Stage.FIT, 1, _STEPS)
    own = capture.own  # its rays were traced about the mesh's normals, whatever the shading normals
    free = free_share(own.rays, own.hit, grid, CELLS[0].own)
    yield Progress(Stage.FIT, 2, _STEPS)
    if capture.alone is not None:
        if capture.passing:
            alone = np.ones_like(free)
        elif own.misled is None:
            alone = free
        else:
            alone = free_share(own.rays, own.meets, grid, CELLS[0].own)
        paths = _open_paths(capture, capture.alone, normal, alone, grid)
        vary = parts.widths and normal_map is None  # normals that vary in a texel would count as roughness
        glossy = mean_colours(capture.material, capture.coarse["glossy"], plan, count) if parts.tint else None
        lobes = fit_lobes(
            paths, capture.material, neighbours, vary, _evaluated(capture, parts), tint, glossy,
            at_texels(capture.coarse.get("tangent"), plan), count,
        )  # fmt: skip
        width_map = lobes.image(plan, capture.fine)
        del paths
    else:
        lobes, width_map = _known_lobes(known, plan)
    del neighbours
    materials = lobes.materials
    if not parts.second_lobe:
        materials = tuple(map(_single, materials))
    tangent_map = _tangents(capture, known, materials)
    surface = Surface(
        grid, normal, matt.diffuse, matt.falloff, tint,
        lobes.width, capture.material, materials, around, free,
        Lit.of(plan.normals, matt.irradiance, matt.colour), at_texels(tangent_map, plan),
    )  # fmt: skip
    yield Progress(Stage.FIT, 3, _STEPS)
    found = fit_buckets(surface, own, light, used, parts, known)
    rest = found.rest
    if parts.rest:
        cells = found.rest_cells
        more = view_dependence(light, _alike(used, capture.light_map), surface, found.rest_grid, cells)
        if more is not None:
            rest += more
    yield Progress(Stage.FIT, 4, _STEPS)
    through = _through(capture, light, around, used, grid, known)
    yield Progress(Stage.FIT, _STEPS, _STEPS)
    return LayeredAtlas(
        colour=large_arrays.as_type(matt.colour_map, np.float32),
        irradiance=matt.irradiance_map,
        falloff=matt.falloff,
        tint=tint_map,
        normal=normal_map,
        width=width_map,
        around=around,
        materials=materials,
        own=grid.placed(found.own, found.free),
        rest=found.rest_grid.placed(rest),
        through=through,
        alpha=capture.alpha,
        tangent=tangent_map,
    )


@dataclass(frozen=True, eq=False)
class _Matt:
    """The diffuse light of the texels, and what they emit as far as it is told with it: see `glow`.

    It is `colour` times `irradiance` (K, 3) times the `falloff` (M, B, 3); also as maps, gutters filled.
    `light`: the samples of it, and of all other light.
    """

    light: LightSamples
    falloff: Floats
    colour: Floats
    irradiance: Floats
    colour_map: Floats
    irradiance_map: Floats

    @property
    def diffuse(self) -> Floats:
        """The light before the falloff, (K, 3)."""
        return self.irradiance * self.colour


def _matt(
    capture: LayeredSamples,
    facing: Floats,
    neighbours: Neighbours,
    parts: Parts,
    known: Known | None,
    imaged: Sequence[bool],
) -> _Matt:
    light, plan, colour_map = capture.light, capture.light.plan, capture.fine["diffuse"]
    colour = capture.coarse["diffuse"].reshape(-1, 3)[plan.texel].astype(np.float32)
    falloff, irradiance = _diffuse(capture, facing, colour, neighbours, parts, known)
    image = plan.placed(irradiance, gutter=True)
    fixed = np.array(imaged, dtype=bool)[capture.material] if imaged else None
    glow = fit_glow(capture, facing, falloff, irradiance * colour, imaged, known)
    if glow is None:
        return _Matt(light, falloff, colour, irradiance, colour_map, image)
    colour_map, image = glow.folded(plan, colour_map, image, fixed, known)
    diffuse = irradiance * colour + glow.light
    irradiance = image.reshape(-1, 3)[plan.texel]
    colour = np.divide(diffuse, irradiance, out=np.zeros_like(diffuse), where=irradiance > 0)
    light = glow.taken_from(light, capture.material)
    return _Matt(light, glow.falloff, colour, irradiance, colour_map, image)


def _diffuse(
    capture: LayeredSamples,
    facing: Floats,
    colour: Floats,
    neighbours: Neighbours,
    parts: Parts,
    known: Known | None,
) -> tuple[Floats, Floats]:
    """The materials' falloffs (M, B, 3), those that are `known` if any, and the texels' irradiance (K, 3)."""
    light, material, share, found = capture.light, capture.material, 1.0, capture.light_map
    frontal: Floats | None = None
    if known is not None:
        falloff, share = known.atlas.falloff, known.share
    elif found is not None:
        falloff = found.falloff
    else:
        falloff, frontal = fit_falloffs(light, facing, material)
    unseen = capture.material_count - len(falloff)
    if unseen > 0:
        falloff = np.concatenate([falloff, np.ones((unseen, *falloff.shape[1:]), np.float32)])
    if frontal is not None and not parts.smooth:
        return falloff, np.divide(frontal, colour, out=np.zeros_like(frontal), where=colour > 1e-3)
    irradiance = fit_irradiance(light, facing, falloff, material, colour, neighbours, share)
    return falloff, irradiance if found is None else found.onto(irradiance, falloff, material)


def _counted(facing: Floats) -> Bools:
    """Which samples (K, S) count, by their N.I."""
    return large_arrays.from_blocks(len(facing), lambda some: facing[some] > 0, _ROWS)


def _alike(used: Bools, light_map: LightMap | None) -> Bools:
    """Those samples (K, S) that are `used` and not of texels that an edge of light may cross."""
    if light_map is None:
        return used
    smooth = ~light_map.edge[:, None]
    return large_arrays.from_blocks(len(used), lambda some: used[some] & smooth[some], _ROWS)


def _evaluated(capture: LayeredSamples, parts: Parts) -> Floats | None:
    """As for `fit_lobes`."""
    found = capture.coarse.get("width")
    return None if found is None or not parts.widths else found.reshape(-1)[capture.light.plan.texel]


def _tangents(capture: LayeredSamples, known: Known | None, materials: Sequence[Material]) -> Floats | None:
    """The map of tangents (H, W, 3), None where no material is brushed."""
    if not any(material.brush for material in materials):
        return None
    found = capture.coarse["tangent"] if known is None else known.atlas.tangent
    return None if found is None else large_arrays.as_type(found, np.float32)


def _known_lobes(known: Known | None, plan: CapturePlan) -> tuple[Lobes, Floats | None]:
    """The lobes of a bake that is there, and its map of widths."""
    if known is None:
        raise ValueError("neither paths through the object alone nor the lobes of a bake are there")
    materials = known.atlas.materials
    none = np.zeros(len(materials), dtype=bool)
    return Lobes(materials, known.widths(plan), none, none.astype(np.float32)), known.atlas.width


def _through(
    capture: LayeredSamples,
    light: LightSamples,
    around: Around,
    used: Bools,
    grid: BucketGrid,
    known: Known | None,
) -> Through | None:
    exits, share = capture.exits, None
    if known is not None:
        through, share = known.atlas.through, known.share
    elif exits is not None:
        through = fit_through(exits, light, around, used, grid)
    else:
        through = None
    if through is None:
        return None
    return fit_through_rest(through, light, around, used, grid, share)


def _around(around: Around, parts: Parts) -> Around:
    if not parts.layers:
        levels = tuple(_flat_level(around, level) for level in around.world.levels)
        around = replace(around, world=replace(around.world, levels=levels), layers=())
    return around if parts.lamps else replace(around, lamps=())


def _flat_level(around: Around, level: Floats) -> Floats:
    """A level of the world's picture with the layers before it, as they are seen from the middle."""
    size = len(level)
    variance = np.full(
        size * size, around.world.sharpest * (len(around.world.levels[0]) / size) ** 2, dtype=np.float32
    )
    direction = cell_directions(size).astype(np.float32)
    without = replace(around, lamps=())
    return cast(Floats, without.look(np.zeros_like(direction), direction, variance).T.reshape(level.shape))


def _open_paths(
    capture: LayeredSamples, ends: EndSamples, normal: Floats, free: Floats, grid: BucketGrid
) -> Paths:
    """The paths that are taken to leave the object straight away."""
    shape = ends.square.shape[:2]
    axis = large_arrays.empty((*shape, 3))
    open_to, cosine, above = (large_arrays.empty(shape) for _ in range(3))
    faces = [one.reshape(-1, 3)[: shape[0], None] for one in (ends.plan.normal, ends.plan.facet)]

    def look(some: slice) -> None:
        axes, cosine[some] = mirrored_about(ends.plan, ends.square, normal, some)
        axis[some] = np.moveaxis(axes, 0, -1)
        above[some] = np.min([(axis[some] * face[some]).sum(axis=-1) for face in faces], axis=0)
        open_to[some] = grid.gather(free, octahedral(axes), some)[0]

    in_blocks(look, *shape)
    least = _least_open(open_to, capture.material)[:, None]
    every = shape[0] * shape[1]
    chosen = large_arrays.from_blocks(
        shape[0], lambda some: (open_to[some] >= least[some]) & (above[some] > _ABOVE), _ROWS
    ).reshape(every)
    path = large_arrays.flatnonzero(every, lambda some: chosen[some])
    texel = large_arrays.from_blocks(len(path), lambda some: (path[some] // shape[1]).astype(np.intp))

    def vectors(values: Floats, number: Ints) -> Floats:
        """Some of the vectors as float32, of which all would be as much as what is captured."""
        flat = values.reshape(-1, 3)
        return computed((len(path), 3), lambda some: flat[number[some]].astype(np.float32))

    return Paths(
        texel=texel,
        weight=vectors(ends.mirrored_weight, path),
        end=vectors(ends.mirrored_end, path),
        axis=vectors(axis, path),
        normal=vectors(normal, texel),
        cosine=large_arrays.taken(cosine.reshape(every), path),
        material=large_arrays.taken(capture.material, texel),
    )


def _least_open(open_to: Floats, material: Ints) -> Floats:
    """How open the paths that are taken are at least, in each texel (K,), of which `open_to` (K, S) tells.

    Of a material that lies in hollows alone, they are its openest ones.
    """
    above = np.nextafter(np.float32(_FREE), np.float32(2))
    least = np.full(len(material), above, dtype=np.float64)
    for number in np.unique(material):
        own = np.flatnonzero(material == number)
        taken = sum(int((open_to[own[some]] >= above).sum()) for some in blocks(len(own), _ROWS))
        if taken < 0.02 * len(own) * open_to.shape[1]:
            all_of_it = large_arrays.taken(open_to, own).reshape(-1)
            openest = np.quantile(all_of_it, 0.95, overwrite_input=True)
            least[own] = min(np.asarray(openest, np.result_type(open_to, openest)), above)
    return least


def _single(material: Material) -> Material:
    """The same with one lobe, of both ones' mean variance."""
    bright = material.weight.sum(axis=2)
    total = np.maximum(bright.sum(axis=0), 1e-9)
    variance = (bright * material.variance).sum(axis=0) / total
    weight = np.stack([material.weight.sum(axis=0), np.zeros_like(material.weight[0])])
    return replace(material, weight=weight, variance=np.stack([np.maximum(variance, 1e-6)] * 2))
