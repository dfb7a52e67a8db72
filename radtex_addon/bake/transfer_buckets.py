# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Turn the light under suns, which are fixed in the world, into buckets in each texel's own frame.

Every texel was captured under the same suns, from the directions of a `settings.choices.View`. Its light is
interpolated between them once, in world space: by kriging from means over the suns' discs, which also removes
the blur of the discs. Each bucket is then the octahedral map whose bilinear lookup comes nearest to this
light in the texel's frame, by least squares. Blending between suns, and again between cells in the lookup,
would blur twice. An odd number of cells suits octahedral maps better, as their creases then run through the
middles of cells: lookups of a cosine have an RMS error of 0.030 at 8 x 8 cells, of 0.020 at 9 x 9.
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass

import numpy as np

from ..core.arrays import Floats, Ints
from ..core.atlas import AtlasLayout
from ..core.errors import ShapeError
from ..core.frame import normalised, to_frame
from ..core.hemisphere import direction_to_square
from ..core.octahedron import (
    cell_directions,
    cell_places,
    direction_to_octahedron,
    octahedron_cell,
    octahedron_taps,
)
from ..formats.transfer_files import with_views
from .plan import CapturePlan
from .progress import Progress, Stage

_STRAIGHT = 0.51  # almost along the normal: the exact middle of a bucket has no azimuth
_FINER = 2  # cells of the world's map, and fitted places, along the side of a bucket's cell
_DISC = 37  # points that represent a sun's disc: with 7, energy varies by 2 % with the direction
_GOLDEN = np.pi * (3 - np.sqrt(5))
_CONSTANT = 10.0  # prior variance of the light's mean over directions, relative to that around the mean
_NOISE = 1e-3  # variance of the captured light's noise, in the same unit
_SMOOTHNESS = 1e-3  # weight of differences between neighbouring cells, against errors of the light
_ENERGY = 10.0  # weight of a bucket's total energy, against the light at all places together
_ROUNDS = 8
_CHUNK_VALUES = 1 << 23  # values of looked-up light in memory at once


@dataclass(frozen=True)
class Eye:
    """A camera's place in world space; if `far`, as for an orthographic camera, the unit direction to it."""

    place: tuple[float, float, float]
    far: bool = False

    def direction_from(self, points: Floats) -> Floats:
        """Unit vectors (K, 3) float64 from points (K, 3) to the eye."""
        place = np.asarray(self.place, dtype=np.float64)
        return normalised(np.broadcast_to(place, points.shape) if self.far else place - points)


def view_shift(plan: CapturePlan, eye: Eye | None = None) -> Floats:
    """The place in its cells from which each texel is looked at: (K, 2) float32, 0 to 1 along a side.

    Without an `eye` it is the cells' middle, which for buckets of one cell is along the normal. A texel that
    faces away from the eye is looked at from the eye's mirror image in its plane: near a silhouette that is
    almost the same direction, and elsewhere nobody sees such texels.
    """
    count = len(plan.texel)
    if eye is None:
        return np.full((count, 2), _STRAIGHT, dtype=np.float32)
    frame = (field.reshape(-1, 3)[:count] for field in (plan.tangent, plan.bitangent, plan.normal))
    local = to_frame(eye.direction_from(plan.points.astype(np.float64)), *frame)
    local[:, 2] = np.abs(local[:, 2])
    place: Floats = ((direction_to_square(normalised(local)) + 1) / 2).astype(np.float32)
    middle = np.abs(place - 0.5).max(axis=1) < _STRAIGHT - 0.5
    place[middle] = _STRAIGHT
    return place


def sun_directions(count: int) -> Floats:
    """World-space unit directions to suns spread evenly over the sphere in a spiral, (count, 3) float64."""
    index = np.arange(count)
    z = 1 - (2 * index + 1) / count
    across, angle = np.sqrt(1 - z * z), index * _GOLDEN
    return np.stack([across * np.cos(angle), across * np.sin(angle), z], axis=1)


def sun_radius(count: int) -> float:
    """Angular radius of a sun, in radians, at which `count` suns together have the area of the sphere.

    Smaller suns would miss shadow edges that fall between them.
    """
    return 2 / float(np.sqrt(count))


def fit_buckets(plan: CapturePlan, light: Floats, cells: int) -> Generator[Progress, None, Floats]:
    """Turn the light under suns into buckets: (K, cells * cells, 3) float32, never below 0.

    `light` (S, K, 3) is what each of the plan's texels shows under each of the suns at `sun_directions(S)`,
    with `sun_radius(S)` and irradiance 1. Yields progress in texels.
    """
    count, side = light.shape[1], _FINER * cells
    between = _between_suns(len(light), side) @ _common(light)
    fit = _Fit.of(cells)
    frame = plan.frames
    buckets = np.empty((count, cells**2, 3), dtype=np.float32)
    step = max(1, _CHUNK_VALUES // (3 * side**2))
    for first in range(0, count, step):
        yield Progress(Stage.FIT, first, count)
        some = slice(first, first + step)
        captured = light[:, some].astype(np.float32)
        world = np.tensordot(between, captured, axes=1).transpose(1, 0, 2)  # (k, side * side, 3)
        buckets[some] = fit.buckets(_seen(np.maximum(world, 0), frame[some], fit.places, side))
    yield Progress(Stage.FIT, count, count)
    return buckets


def _common(light: Floats) -> Floats:
    """A filter (S, S) float32 that removes noise from the light under suns (S, K, 3).

    A Wiener filter in the light's own principal components. Neighbouring suns light most texels alike, so
    light is in few components, but noise is equal in all: it is measured in the weaker half of them, which
    hold little else.
    """
    flat = light.reshape(len(light), -1).astype(np.float32)
    power, components = np.linalg.eigh((flat @ flat.T).astype(np.float64))
    noise = float(np.median(power[: max(1, len(power) // 2)]))
    kept = (
        np.maximum(1 - noise / np.maximum(power, max(noise, 1e-30)), 0) if noise > 0 else np.ones_like(power)
    )
    return np.asarray((components * kept) @ components.T).astype(np.float32)


def _between_suns(suns: int, side: int) -> Floats:
    """The weight of each sun in each cell of a map of world directions: (side * side, S) float32.

    Kriging: the light is modelled as a Gaussian process with the covariance `_covariance`; known are its
    means over the discs, which Cycles scales so that a plane facing a sun has the irradiance 1.
    """
    middle = sun_directions(suns)
    discs = _discs(middle, sun_radius(suns))
    facing = float(np.einsum("sdi,si->sd", discs, middle).mean())

    def with_discs(directions: Floats) -> Floats:
        each = [_covariance(directions, discs[:, point]) for point in range(_DISC)]
        return np.asarray(np.mean(each, axis=0) / facing)

    known = np.mean([with_discs(discs[:, point]) for point in range(_DISC)], axis=0) / facing
    sought = with_discs(cell_directions(side).astype(np.float64))
    weights: Floats = np.linalg.solve(known + _NOISE * np.eye(suns), sought.T).T
    return weights.astype(np.float32)


def _covariance(a: Floats, b: Floats) -> Floats:
    """Covariance (A, B) of light from directions (A, 3) and (B, 3): Matérn's of smoothness 3/2, by chord."""
    chord = np.sqrt(3 * np.maximum(2 - 2 * (a @ b.T), 0))
    return np.asarray(_CONSTANT + (1 + chord) * np.exp(-chord))


def _discs(suns: Floats, radius: float) -> Floats:
    """Unit directions (S, _DISC, 3), spread evenly over each sun's disc."""
    upright = np.where(np.abs(suns[:, 2:]) < 0.9, (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))
    x = np.cross(suns, upright)
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    y = np.cross(suns, x)
    index = np.arange(_DISC)
    away, angle = np.sqrt((index + 0.5) / _DISC) * np.tan(radius), index * _GOLDEN
    shift = np.cos(angle)[:, None] * x[:, None] + np.sin(angle)[:, None] * y[:, None]
    directions = suns[:, None] + away[:, None] * shift
    return np.asarray(directions / np.linalg.norm(directions, axis=2, keepdims=True))


def _seen(world: Floats, frame: Floats, places: Floats, side: int) -> Floats:
    """Look maps of world directions, (k, side * side, 3), up at places in each texel's frame: (k, P, 3).

    `places` (P, 3) are directions in the frame, whose axes T, Bt, N are the rows of `frame` (k, 3, 3).
    """
    directions = np.einsum("pi,kij->kpj", places, frame)
    total = np.zeros((len(world), len(places), 3), dtype=np.float32)
    for cell, weight in octahedron_taps(direction_to_octahedron(directions), side):
        total += np.take_along_axis(world, cell[..., None], axis=1) * weight[..., None]
    return total


class _Fit:
    """Fits cells to the light at `places`, directions (P, 3) in the frame; the same for all texels."""

    def __init__(self, places: Floats, lookup: Floats, cells: int) -> None:
        """`lookup` (P, cells * cells) is the weight of each cell in a lookup at each place."""
        self.places = places.astype(np.float32)
        area = np.abs(places).sum(axis=1) ** 3  # around each place: see lookup_solid_angles_sr
        weighed = lookup * (area / area.sum() * cells**2)[:, None]
        normal = lookup.T @ weighed + _SMOOTHNESS * _roughness(cells)
        share = lookup_solid_angles_sr(cells) / (4 * np.pi)
        self._share, self._energy = share.astype(np.float32), (_ENERGY * cells**2 * share).astype(np.float32)
        self._sought = weighed.T.astype(np.float32)
        self._free = np.linalg.solve(normal, weighed.T).astype(np.float32)
        whole = normal + _ENERGY * cells**2 * np.outer(share, share)
        self._whole, self._step = whole.astype(np.float32), np.float32(1 / np.linalg.norm(whole, 2))

    @classmethod
    def of(cls, cells: int) -> _Fit:
        """With _FINER x _FINER places in each cell."""
        places = cell_directions(_FINER * cells).astype(np.float64)
        lookup = np.zeros((len(places), cells**2))
        for cell, weight in octahedron_taps(direction_to_octahedron(places), cells):
            np.add.at(lookup, (np.arange(len(places)), cell), weight)
        return cls(places, lookup, cells)

    def buckets(self, seen: Floats) -> Floats:
        """The cells (k, C, 3) >= 0 whose lookups come nearest to light (k, P, 3) at the places.

        Where light ends abruptly, the unconstrained solution has negative cells, and clipping them would add
        energy. So the fit also aims at the unconstrained solution's energy, by accelerated projected
        gradients (Beck and Teboulle, 2009).
        """
        light = seen.transpose(1, 0, 2).reshape(seen.shape[1], -1)
        free = self._free @ light
        sought = self._sought @ light + np.outer(self._energy, self._share @ free)
        found = ahead = np.maximum(free, 0)
        pace = 1.0
        for _ in range(_ROUNDS):
            moved = np.maximum(ahead - self._step * (self._whole @ ahead - sought), 0)
            later = (1 + float(np.sqrt(1 + 4 * pace * pace))) / 2
            ahead = moved + np.float32((pace - 1) / later) * (moved - found)
            found, pace = moved, later
        return found.reshape(-1, len(seen), 3).transpose(1, 0, 2)


def _roughness(cells: int) -> Floats:
    """Lᵀ L, where L sums each cell's differences from its four neighbours on the sphere: (cells², cells²)."""
    total = cells**2
    differences = np.zeros((total, total))
    for neighbour in _neighbours(cells):
        np.add.at(differences, (np.arange(total), neighbour), -1.0)
    differences[np.arange(total), np.arange(total)] += 4.0
    return np.asarray(differences.T @ differences)


def _neighbours(cells: int) -> list[Ints]:
    """For every cell the index of its neighbour on each of four sides; beyond an edge the map is folded."""
    places = cell_places(cells).astype(np.float64)
    sides = ((1, 0), (-1, 0), (0, 1), (0, -1))
    return [octahedron_cell(_folded(places + np.array(side) / cells), cells) for side in sides]


def _folded(place: Floats) -> Floats:
    """Places beyond an edge brought back to where they lie on the square."""
    beyond = (place < 0) | (place > 1)
    crossed = beyond[..., ::-1]
    back = np.where(place < 0, -place, 2 - place)
    inside = np.where(beyond, back, place)
    return np.where(crossed, 1 - inside, inside)


def lookup_solid_angles_sr(size: int, finer: int = 16) -> Floats:
    """Weight of each cell of a map in the integral of bilinear lookups over the sphere: (size * size,).

    Computed from `finer` x `finer` directions for each cell. A direction's solid angle is proportional to
    1 / |p|^3, p being its point on |x| + |y| + |z| = 1. The sum is 4 pi.
    """
    direction = cell_directions(size * finer).astype(np.float64)
    share = np.abs(direction).sum(axis=-1) ** 3
    total = np.zeros(size * size)
    for cell, weight in octahedron_taps(direction_to_octahedron(direction), size):
        total += np.bincount(cell, weight * share, size * size)
    return total * (4 * np.pi / total.sum())


def mean_over_lights(image: Floats, layout: AtlasLayout, views: int = 1) -> Floats:
    """Radiance of texels under white surroundings of radiance 1: (H, W, C), float32, the mean of all views.

    A piece of sky of solid angle w gives an irradiance of w on a plane facing it. Raises ShapeError if the
    image does not fit the layout.
    """
    n, stored = layout.bucket, with_views(layout, views)
    if image.shape[:2] != (stored.pixel_height, stored.pixel_width):
        raise ShapeError(f"transfer atlas: expected {stored.pixel_height} x {stored.pixel_width} pixels")
    weight = lookup_solid_angles_sr(n).astype(np.float32).reshape(n, n)
    rows = (np.einsum("wqpc,qp->wc", row.astype(np.float32), weight) for row in stored.to_buckets(image))
    light = np.stack(list(rows)).reshape(layout.height, views, layout.width, views, -1)
    mean: Floats = light.mean(axis=(1, 3))
    return mean
