# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Unwrap a surface into few, large islands with little stretch, packed to the size of the atlas.

Clean islands of an artist's UV layer are kept, if they are given. Three methods flatten the rest: uvunwrap,
whose islands are merged and cut until they use the atlas best; xatlas; and Blender's Smart UV Project. The
islands of all are packed alike.
"""

from __future__ import annotations

import logging
import math
import time
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ...bake.progress import Steps, in_a_thread
from ...core.arrays import Bools, Floats, blocks
from ...core.errors import InputError
from ...core.islands import areas_on_surface, find_overlap, signed_areas, weld
from ...core.messages import Setting, do
from ...settings.spec import Unwrap
from ...settings.texel_density import about_side, grown_side, rounded
from ..mesh.evaluated import EvaluatedMesh
from ..mesh.flatten import (
    FlatIslands,
    cut_flat,
    flatten_with_blender,
    flatten_with_uvunwrap,
    flatten_with_xatlas,
    islands_of,
    merge_flat,
)
from ..mesh.mesh_parts import taken
from .artist_islands import ArtistIslands
from .island_packing import Packed, pack_islands, packed_closer
from .island_sizes import smaller_where_flat, smaller_where_hidden
from .painted_sizes import sized_as_painted, times_as_many
from .unwrap_options import AtlasUnwrap, UnwrapOptions
from .uvunwrap_job import MERGED, check_uvunwrap, unwrap_progress
from .xatlas_process import XatlasProcess, check_xatlas

log = logging.getLogger(__name__)

_LONG = 10.0  # seconds: the log announces longer unwraps, and names the quick alternative
_THREAD = 2e3  # times the root of the area: islands this long are packed in seconds, longer ones in hours
_COVERED = 0.55  # share of an atlas that islands cover, to guess how large texels will be
_CUTS = 6  # rounds
_HUGE = 1_000_000  # triangles, of which one round takes a minute
_QUICK = 50_000  # triangles that Blender's projection takes a moment for, so that it is tried, too
_LEAST_INTERIOR = (
    0.4  # share of an artist's islands that lies a texel off their borders, or they are not kept
)
_ENOUGH = 0.45  # share of the atlas that artist's islands cover: then no other unwrap is tried
_EXACT = 0.01  # share by which a density may differ from what is asked for
_PACKINGS = 5  # tries to come that near
_NOTHING = 1e-9  # of a surface's area: so much is none
_TOLERATED_OVERLAP = 1e-3  # share of the covered area: less overlap is only a few slivers


def check_unwrapper(method: Unwrap) -> None:
    """Raise InputError if a module that the method needs is missing."""
    check_uvunwrap()  # it packs the islands of all
    if method is Unwrap.XATLAS:
        check_xatlas()


def estimate_seconds(triangles: int, options: UnwrapOptions | None = None) -> float:
    """About how long xatlas and the packing take: an estimate, from a busy 2-core machine of 2026.

    Some meshes take a third, others three times as long. Big islands cost most; loose parts run in parallel.
    """
    sized = (options or UnwrapOptions()).for_size(triangles)
    tries = sum(0.75 + 0.25 * iterations for iterations in sized.iterations)
    bounded = 0.45 if sized.max_island_share else 1.0
    packing = 0.3 * len(sized.iterations)
    return float(2.5 * (triangles / 16_000) ** 1.75 * tries * bounded + packing)


def unwrap_steps(
    evaluated: EvaluatedMesh,
    texels: int,
    method: Unwrap,
    options: UnwrapOptions | None = None,
    artist: ArtistIslands | None = None,
    seen: Bools | None = None,
    painted: Floats | None = None,
) -> Steps[AtlasUnwrap]:
    """Unwrap into an atlas whose longer side is `texels`, or as `options.density` needs, if given.

    What is in the `artist`'s islands stays as it is there, if that is worth it. Triangles that are not `seen`
    (F,) get a quarter of the texels along each side; all are seen if it is None. The weights that are
    `painted` (F,), 0 to 1, multiply what each place gets, as `times_as_many` tells.

    With a density, which weights of a half have, sides are multiples of `texel_density.STEP`, and at most
    `options.most`.

    By `Unwrap.AUTO` without a density, flat islands get fewer texels than curved ones.

    Of several tries the one with most texels in the interior of islands is returned. Yields progress while
    xatlas works; closing the generator ends xatlas. Raises InputError if the surface has no area, or too many
    islands for so few texels; BakeError if xatlas fails.
    """
    options = (options or UnwrapOptions()).for_size(len(evaluated.triangles))
    by_need = method is Unwrap.AUTO and options.density is None
    if method is Unwrap.AUTO:  # its own UV layer, which the caller has looked at, is not fit
        method = Unwrap.UVUNWRAP
    if method is Unwrap.XATLAS:
        _announce(evaluated, options)
    _check_area(evaluated)
    start = time.perf_counter()
    given = _Given(artist, seen, by_need, painted)
    if options.density is None:
        best = yield from _best(evaluated, texels, method, options, given)
        closer = yield from packed_closer(best.packed, texels, options.padding)
        best = replace(best, packed=closer)
    else:
        about = about_side(given.painted_area(evaluated), options.density)
        side = min(about, options.most)
        reachable = replace(options, density=options.density * side / about)
        best = yield from _best(evaluated, side, method, reachable, given)
        best = yield from _at_density(evaluated, best, options, options.density)
    done = unwrap_progress(1)
    made = yield from in_a_thread(lambda: _finish(evaluated, best, time.perf_counter() - start), done)
    _tell(evaluated.name, made)
    return made


def _announce(evaluated: EvaluatedMesh, options: UnwrapOptions) -> None:
    count = len(evaluated.triangles)
    seconds = estimate_seconds(count, options)
    if seconds > _LONG:
        log.warning(
            "xatlas will take some %d s for the %d triangles of '%s'; Blender's own unwrap takes seconds",
            round(seconds),
            count,
            evaluated.name,
        )


def _area(evaluated: EvaluatedMesh) -> float:
    """The surface's area in the world, in square scene units."""
    return float(areas_on_surface(evaluated.world_position, evaluated.triangles).sum())


def _check_area(evaluated: EvaluatedMesh) -> None:
    place, area = evaluated.world_position, _area(evaluated)
    if not (np.isfinite(area) and area > 0):
        raise InputError(f"object '{evaluated.name}' has faces, but no area to unwrap: give it a size")
    longest = 0.0
    for some in blocks(len(evaluated.triangles)):
        corners = place[evaluated.triangles[some]]
        longest = max(longest, float(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=-1).max()))
    if longest > _THREAD * math.sqrt(area):
        raise InputError(
            f"object '{evaluated.name}' is as thin as a thread, with an edge of {longest:.3g} scene units "
            f"and an area of {area:.3g}",
            do("give it a width"),
            do("bake it on a UV layer of its own", Setting.UV),
        )


@dataclass(frozen=True, eq=False)
class _Given:
    """What the caller knows of the surface, as in `unwrap_steps`, and if flat islands get fewer texels."""

    artist: ArtistIslands | None
    seen: Bools | None
    by_need: bool
    painted: Floats | None

    def sized(self, evaluated: EvaluatedMesh, flat: FlatIslands) -> FlatIslands:
        """The islands, larger or smaller as was painted."""
        return flat if self.painted is None else sized_as_painted(evaluated, flat, self.painted)

    def painted_area(self, evaluated: EvaluatedMesh) -> float:
        """About the area that the surface would have if it were as large as its texels are many."""
        if self.painted is None:
            return _area(evaluated)
        area = areas_on_surface(evaluated.world_position, evaluated.triangles)
        return float((area * times_as_many(self.painted) ** 2).sum())


def _best(
    evaluated: EvaluatedMesh, texels: int, method: Unwrap, options: UnwrapOptions, given: _Given
) -> Steps[_Try]:
    """The best try with the artist's islands, if that covers enough of the atlas; else the best of all."""
    kept: _Try | None = None
    if given.artist is not None and given.artist.kept.any():
        tries = yield from _with_artist_islands(evaluated, texels, method, options, given.artist)
        with suppress(InputError):  # too many islands for so few texels
            kept = yield from _best_of(evaluated, tries, texels, method, options, given)
        if kept is not None and kept.covered >= _ENOUGH:
            return kept
    tries = yield from _flattened(evaluated, texels, method, options)
    if kept is None:
        return (yield from _best_of(evaluated, tries, texels, method, options, given))
    with suppress(InputError):
        anew = yield from _best_of(evaluated, tries, texels, method, options, given)
        return anew if anew.interior > kept.interior else kept
    return kept


def _best_of(
    evaluated: EvaluatedMesh,
    tries: list[FlatIslands],
    texels: int,
    method: Unwrap,
    options: UnwrapOptions,
    given: _Given,
) -> Steps[_Try]:
    """The best of some ways to flatten the mesh. Raises InputError if none fits into the atlas."""
    if given.seen is not None and not given.seen.all():
        tries = [smaller_where_hidden(evaluated, flat, given.seen) for flat in tries]
    if given.by_need:
        tries = [smaller_where_flat(evaluated, flat) for flat in tries]
    best: _Try | None = None
    failure: InputError | None = None
    for flat in tries:
        sized = given.sized(evaluated, flat)
        grown = 1.0 if sized is flat else sized.area / flat.area
        try:
            found = yield from _tried(evaluated, sized, texels, options, grown)
        except InputError as error:
            failure = failure or error
            continue
        if best is None or found.interior > best.interior:
            best = found
    if best is None:
        raise failure or InputError(f"object '{evaluated.name}' cannot be unwrapped: it has no area")
    if method is Unwrap.UVUNWRAP:
        best = yield from _with_cuts(evaluated, best, texels, options)
    return best


def _with_artist_islands(
    evaluated: EvaluatedMesh, texels: int, method: Unwrap, options: UnwrapOptions, artist: ArtistIslands
) -> Steps[list[FlatIslands]]:
    """Several ways to flatten what is in no island of the artist's, which are in all; none if too small."""
    rest = ~artist.kept
    own = islands_of(evaluated, artist.uv, artist.island)
    density = options.density or texels * math.sqrt(_COVERED / max(own.area, 1e-30))
    if own.interior(density) < _LEAST_INTERIOR * own.area * density**2:
        log.info("the islands of the UV layer of '%s' are too small for so few texels", evaluated.name)
        return []
    area = areas_on_surface(evaluated.world_position, evaluated.triangles)
    if not area[rest].sum() > _NOTHING * area.sum():  # triangles without area belong to no island
        return [own]
    tries = yield from _flattened(taken(evaluated, rest), texels, method, options)
    found = []
    for flat in tries:
        uv, island = artist.uv.copy(), artist.island.copy()
        uv[rest] = flat.uv
        island[rest] = np.where(flat.island >= 0, flat.island + own.count, -1)
        found.append(islands_of(evaluated, uv, island))
    return found


def _flattened(
    evaluated: EvaluatedMesh, texels: int, method: Unwrap, options: UnwrapOptions
) -> Steps[list[FlatIslands]]:
    """Several ways to flatten the mesh, of which one is to be chosen."""
    if method is Unwrap.BLENDER:
        return [flatten_with_blender(evaluated, options)]
    if method is Unwrap.UVUNWRAP:
        flat = yield from flatten_with_uvunwrap(evaluated, options)
        density = options.density or texels * math.sqrt(_COVERED / max(flat.area, 1e-30))
        tries = [flat, *(yield from merge_flat(evaluated, flat, 1 / density, options))]
        if len(evaluated.triangles) <= _QUICK:
            tries.append(flatten_with_blender(evaluated, options))
        return tries
    tries = []
    with XatlasProcess() as xatlas:
        for iterations in options.iterations:
            tries.append((yield from flatten_with_xatlas(xatlas, evaluated, options, iterations)))
    return tries


@dataclass(frozen=True, eq=False)
class _Try:
    """Packed islands, and about how many texels, their `interior`, show the surface as it is.

    Of many texels those within a texel of a border, on both sides of it, do not count, as a seam shows there;
    of few a share remains, or sparse islands would be the best. Those that see the surface squeezed along
    some direction count less: see `FlatIslands`. With a density, `interior` is their share of the atlas that
    has it, and `needed` is as in `AtlasUnwrap`. By what is painted, the islands have `grown` to so many times
    their area.
    """

    flat: FlatIslands
    packed: Packed
    interior: float
    grown: float
    needed: int = 0

    @property
    def covered(self) -> float:
        """The share that islands cover of a square as wide as the longer side."""
        side = max(self.packed.width, self.packed.height)
        return float(np.abs(signed_areas(self.packed.uv)).sum()) / side**2


def _tried(
    evaluated: EvaluatedMesh, flat: FlatIslands, texels: int, options: UnwrapOptions, grown: float
) -> Steps[_Try]:
    packed = yield from _fitted(flat, texels, options)
    if packed.islands > flat.count:
        flat = islands_of(evaluated, flat.uv, packed.island)
    density = options.density or packed.density
    interior = flat.interior(density)
    log.debug("%d islands, %.4g texels per unit, interior %.0f", flat.count, packed.density, interior)
    if options.density is not None:  # all show as much: the smallest is the best
        interior /= packed.width * packed.height * (options.density / packed.density) ** 2
    return _Try(flat, packed, interior, grown)


def _fitted(flat: FlatIslands, texels: int, options: UnwrapOptions) -> Steps[Packed]:
    """Pack into `texels`; if a density is asked for, and these are too few, into more."""
    while True:
        try:
            return (yield from pack_islands(flat, texels, options.padding))
        except InputError:
            if options.density is None or texels >= options.most:
                raise
        texels = min(2 * texels, options.most)


def _at_density(evaluated: EvaluatedMesh, best: _Try, options: UnwrapOptions, density: float) -> Steps[_Try]:
    """Pack again, into other sizes, until the surface has the `density`, in texels per unit, in the mean.

    The size is as large as `options.most` allows. Sides become multiples of `STEP`, by free texels.
    """
    surface = _area(evaluated) * best.grown
    flat, packed = best.flat, best.packed
    lacks = density / _reached(packed, surface)
    for _ in range(_PACKINGS):
        side = max(packed.width, packed.height)
        wanted = min(round(side * max(lacks, 0.5)), options.most)
        if abs(lacks - 1) < _EXACT or wanted in (0, side):
            break
        try:
            other = yield from pack_islands(flat, wanted, options.padding)
        except InputError:  # too many islands for fewer texels
            break
        closer = density / _reached(other, surface)
        if abs(math.log(closer)) >= abs(math.log(lacks)):
            break
        packed, lacks = other, closer
    side = max(packed.width, packed.height)
    needed = grown_side(side, lacks) if side == options.most and lacks > 1 + _EXACT else 0
    packed = replace(packed, width=rounded(packed.width), height=rounded(packed.height))
    return replace(best, packed=packed, needed=needed)


def _reached(packed: Packed, surface: float) -> float:
    """The mean density of a surface of so many square scene units, in texels per unit."""
    return math.sqrt(max(float(np.abs(signed_areas(packed.uv)).sum()), 1e-30) / surface)


def _with_cuts(evaluated: EvaluatedMesh, best: _Try, texels: int, options: UnwrapOptions) -> Steps[_Try]:
    """Cut islands that pack badly, as often as that may help."""
    flat = best.flat
    for _ in range(_CUTS if len(flat.uv) <= _HUGE else 1):
        cut = yield from in_a_thread(partial(cut_flat, evaluated, flat), unwrap_progress(MERGED))
        if cut is None:
            break
        flat = cut
        try:
            found = yield from _tried(evaluated, flat, texels, options, best.grown)
        except InputError:  # too many islands now
            break
        if found.interior > best.interior:
            best = found
    return best


def _finish(evaluated: EvaluatedMesh, best: _Try, seconds: float) -> AtlasUnwrap:
    flat, packed = best.flat, best.packed
    uv = packed.uv / [packed.width, packed.height]
    _settle_thin(uv, evaluated, flat.island >= 0)
    return AtlasUnwrap(
        uv=uv,
        width=packed.width,
        height=packed.height,
        islands=packed.islands,
        utilisation=float(np.abs(signed_areas(uv)).sum()),
        density=packed.density,
        overlap=find_overlap(uv).fraction,
        seconds=seconds,
        needed=best.needed,
    )


def _tell(name: str, done: AtlasUnwrap) -> None:
    if done.overlap > _TOLERATED_OVERLAP:
        log.warning(
            "the unwrap of '%s' overlaps itself in %.1f %% of its area: try the other, or your UV layer",
            name,
            100 * done.overlap,
        )
    log.info(
        "unwrapped '%s': %d islands, %d x %d texels, %.0f %% used, %.4g texels per unit, %.1f s",
        name,
        done.islands,
        done.width,
        done.height,
        100 * done.utilisation,
        done.density,
        done.seconds,
    )


def _settle_thin(uv: Floats, evaluated: EvaluatedMesh, real: Bools) -> None:
    """Give each triangle without area, which belongs to no island, one uv point of a neighbour."""
    if real.all():
        return
    vertex = weld(evaluated.position)[evaluated.triangles]
    somewhere = np.full((int(vertex.max()) + 1, 2), np.nan)
    somewhere[vertex[real]] = uv[real]
    points = somewhere[vertex[~real]]
    known = np.isfinite(points[..., 0])
    chosen = points[np.arange(len(points)), known.argmax(axis=1)]
    chosen[~known.any(axis=1)] = uv[real][0, 0]
    uv[~real] = chosen[:, None]
