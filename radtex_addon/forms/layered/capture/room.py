# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The room around the baked objects: large flat things that enclose it, and what stands inside.

Both are found by ray casts. Most of what is mirrored in a room lies on its floor, ceiling or walls. Cutting
their planes puts nearly all of that in its place; a map of distances, iterated, misses it for many rays.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from typing import Any

import bpy
import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from ....core.arrays import Bools, Floats, Ints
from ....core.frame import normalised
from ....scene.mesh.mesh_checks import FARTHEST
from ....scene.mesh.render_contents import Shown, read_render
from ....scene.mesh.triangle_tree import triangle_tree
from ..lookup.environment import MOST_PLANES, Shell

_RAYS = 3000  # that leave the baked objects
_BOUNCES = 3
_TRIED = 160  # planes, for each one that is found
_FEWEST_PLANES = 3  # of a room
_MOST_TRIANGLES = 4_000_000
_THIN = 0.015  # of the room's size: what lies so near to a plane lies on it
_TURNED = 0.998  # cosine between normals of one plane
_LEAST = 0.015  # share of the hits that a plane needs
_BEHIND = 0.06  # most hits behind a plane of the room, such as what is seen through windows
_ENCLOSED = 0.5  # share of the hits that must lie on the planes
_ON_PLANES = 0.5  # share of an object's area on planes or beyond, from which on it belongs to them
_OFF = 2e-6  # of the scene's size, by which rays start off surfaces
_USUAL = (2, 98)  # percentiles of where rays end, which the size of a room is told by
_CLEAR = 0.03  # of the room's size, from an eye to the nearest thing
_SEEN = 0.02  # of a distance: what is hit so near before a place does not hide it


@dataclass(frozen=True, eq=False)
class Room:
    """Planes of `normals` (n, 3) . p = `heights` (n,) in world space, float64, with the inside above them.

    `eye` (3,): inside, whence they are seen. What is no more than `thin` before a plane lies on it.
    `furniture`: the owners of what stands inside and is not on a plane; all other things belong to the
    planes' picture. `furniture_eye` (3,): whence furniture is seen, None: from the baked objects' middle.
    """

    normals: Floats
    heights: Floats
    eye: Floats
    thin: float
    furniture: frozenset[bpy.types.Object]
    furniture_eye: Floats | None

    def hidden(self, subjects: Collection[bpy.types.Object]) -> frozenset[bpy.types.Object]:
        """Those of the baked `subjects` that no picture shows: furniture that is seen from its middle."""
        return frozenset(subjects) & self.furniture if self.furniture_eye is None else frozenset()

    def encloses(self, subjects: Collection[bpy.types.Object]) -> bool:
        """Whether any of the baked `subjects` is part of the room itself, such as its floor."""
        return not self.furniture.issuperset(subjects)

    def holds(self, points: Floats) -> Bools:
        """Which points (P, 3) in world space lie in the room, or on its planes, (P,)."""
        inside: Bools = _before(points, self.normals, self.heights, -self.thin).all(axis=0)
        return inside

    def shell(self, middle: Floats) -> Shell:
        """The planes as seen from the middle (3,) of the surroundings."""
        heights = self.heights - self.normals @ middle.astype(np.float64)
        normals, eye = self.normals.astype(np.float32), (self.eye - middle).astype(np.float32)
        return Shell(normals, heights.astype(np.float32), eye)


def find_room(
    scene: bpy.types.Scene,
    subjects: Collection[bpy.types.Object],
    points: Floats,
    facets: Floats,
    seed: int,
) -> Room | None:
    """The room that a scratch scene renders around the baked `subjects`; None if they stand in none.

    Rays leave the subjects at some of `points` (K, 3) about their `facets` (K, 3), unit normals, and are
    reflected diffusely. Large planes are taken that have nearly all that is hit before them; if most hits
    lie on them, they are a room. Raises BakeError where Blender does not render.
    """
    things = read_render(scene, _things_of)
    if things is None:
        return None
    hits = _explore(things, points, facets, np.random.default_rng(seed))
    low, high = np.percentile(hits.place, _USUAL, axis=0)
    thin = _THIN * float((high - low).max())
    found = _planes(hits, thin)
    if found is None:
        return None
    normals, heights = found
    on_planes = things.shares_on(normals, heights, thin)
    furniture = frozenset(owner for owner, share in on_planes.items() if share < _ON_PLANES)
    inside = hits.place[_before(hits.place, normals, heights, -thin).all(axis=0)]
    eye = _middle_of(inside, normals, heights)
    room = Room(normals, heights, eye, thin, furniture, None)
    if not room.encloses(subjects):
        return room
    return replace(room, furniture_eye=_best_eye(things, furniture, hits, eye, inside))


@dataclass(frozen=True, eq=False)
class _Things:
    """Triangles `corners` (F, 3, 3) in world space, and the number of the owner of each, (F,)."""

    owners: list[bpy.types.Object]
    corners: Floats
    owner: Ints

    @property
    def size(self) -> float:
        """The longest side of their box."""
        return float(np.ptp(self.corners.reshape(-1, 3), axis=0).max())

    def tree(self, some: Bools) -> BVHTree:
        """Of some triangles (F,)."""
        corners = self.corners[some]
        return triangle_tree(
            corners.reshape(-1, 3), np.arange(3 * len(corners), dtype=np.int32).reshape(-1, 3)
        )

    def shares_on(self, normals: Floats, heights: Floats, thin: float) -> dict[bpy.types.Object, float]:
        """The share of each owner's area that lies on a plane, or less than `thin` before it, or beyond."""
        a, b, c = self.corners.transpose(1, 0, 2)
        area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
        above = (self.corners @ normals.T).max(axis=1) - heights  # (F, n), of the corner that lies highest
        on = (above < thin).any(axis=1)
        whole = np.bincount(self.owner, area, len(self.owners))
        share = np.bincount(self.owner, area * on, len(self.owners)) / np.maximum(whole, 1e-30)
        return dict(zip(self.owners, share.tolist(), strict=True))


def _things_of(shown: Iterator[Shown]) -> _Things | None:
    """All that glossy rays see; None if that is too much, or nothing."""
    owners: dict[bpy.types.Object, int] = {}
    corners, owner, total = [], [], 0
    for one in shown:
        if "glossy" not in one.seen_by or one.evaluated.type != "MESH":
            continue
        shape = one.shape
        if shape is None or not (np.abs(one.bounds) < FARTHEST).all():
            continue
        total += len(shape.triangles)
        if total > _MOST_TRIANGLES:
            return None
        place = shape.position @ one.matrix[:3, :3].T + one.matrix[:3, 3]
        corners.append(place[shape.triangles])
        owner.append(np.full(len(shape.triangles), owners.setdefault(one.owner, len(owners))))
    if not corners:
        return None
    return _Things(list(owners), np.concatenate(corners), np.concatenate(owner))


@dataclass(frozen=True, eq=False)
class _Hits:
    """Where rays end: the `place` (P, 3), its unit `normal` (P, 3) that faces the ray, the `triangle` (P,).

    The first `first` of them are of rays that leave the baked objects.
    """

    place: Floats
    normal: Floats
    triangle: Ints
    first: int


def _explore(things: _Things, points: Floats, facets: Floats, random: np.random.Generator) -> _Hits:
    """Rays from points about facets, and from where these end."""
    tree = things.tree(np.ones(len(things.corners), dtype=bool))
    some = random.integers(0, len(points), _RAYS)
    place, normal = points[some].astype(np.float64), facets[some].astype(np.float64)
    found = []
    for _ in range(_BOUNCES):
        way = normalised(normal + 0.999 * normalised(random.normal(size=normal.shape)))
        start = place + _OFF * things.size * normal
        place, normal, triangle = _cast(tree, start, way)
        found.append((place, normal, triangle))
        if not len(place):
            break
    parts = [np.concatenate(each) for each in zip(*found, strict=True)]
    return _Hits(parts[0], parts[1], parts[2], len(found[0][0]))


def _cast(tree: BVHTree, start: Floats, way: Floats) -> tuple[Floats, Floats, Ints]:
    """Of the rays that hit: the places, the normals that face the rays, and the triangles."""
    cast: Any = tree.ray_cast
    found = [
        cast(Vector(place), Vector(along)) for place, along in zip(start.tolist(), way.tolist(), strict=True)
    ]
    hit = np.array([one[0] is not None for one in found], dtype=bool)
    met = [one for one in found if one[0] is not None]
    place = np.array([one[0] for one in met], dtype=np.float64).reshape(-1, 3)
    normal = np.array([one[1] for one in met], dtype=np.float64).reshape(-1, 3)
    normal *= -np.sign((normal * way[hit]).sum(axis=1, keepdims=True) + 1e-30)
    return place, normal, np.array([one[2] for one in met], dtype=np.int64)


def _planes(hits: _Hits, thin: float) -> tuple[Floats, Floats] | None:
    """Normals (n, 3) and heights (n,) of the planes around the hits, the largest first; None if none are."""
    place, normal = hits.place, hits.normal
    left = np.ones(len(place), dtype=bool)
    on_any = np.zeros(len(place), dtype=bool)
    normals: list[Floats] = []
    heights: list[float] = []
    while len(normals) < MOST_PLANES and left.any():
        on, way, height = _largest_plane(place, normal, left, thin)
        if on.sum() < _LEAST * len(place):
            break
        left &= ~on
        if (place @ way - height < -thin).mean() < _BEHIND:
            normals.append(way)
            heights.append(height)
            on_any |= np.abs(place @ way - height) < thin
    if len(normals) < _FEWEST_PLANES or on_any.mean() < _ENCLOSED:
        return None
    return np.array(normals), np.array(heights)


def _largest_plane(place: Floats, normal: Floats, left: Bools, thin: float) -> tuple[Bools, Floats, float]:
    """Of the hits that are `left`, those on the plane that has most (P,), its unit normal and its height."""
    rest = np.flatnonzero(left)
    tried = rest[np.linspace(0, len(rest) - 1, min(_TRIED, len(rest))).astype(np.intp)]

    def lying_on(way: Floats, height: float) -> Bools:
        found: Bools = left & (normal @ way > _TURNED) & (np.abs(place @ way - height) < thin / 2)
        return found

    best = max((lying_on(normal[one], float(place[one] @ normal[one])) for one in tried), key=np.sum)
    way = normalised(normal[best].mean(axis=0))
    height = float(np.median(place[best] @ way))
    return lying_on(way, height), way, height


def _before(place: Floats, normals: Floats, heights: Floats, least: float) -> Bools:
    """Which places (P, 3) lie before each plane, by at least so much: (n, P)."""
    found: Bools = normals @ place.T - heights[:, None] >= least
    return found


def _middle_of(inside: Floats, normals: Floats, heights: Floats) -> Floats:
    """The middle of what is hit inside, moved before all planes if need be."""
    middle: Floats = (inside.min(axis=0) + inside.max(axis=0)) / 2
    mean: Floats = inside.mean(axis=0)
    for share in np.linspace(0, 1, 11):
        found: Floats = middle + share * (mean - middle)
        if _before(found[None], normals, heights, 0).all():
            return found
    return mean


def _best_eye(
    things: _Things,
    furniture: frozenset[bpy.types.Object],
    hits: _Hits,
    middle: Floats,
    inside: Floats,
) -> Floats | None:
    """The eye that sees most of the furniture that rays from the baked objects hit; None if they hit none.

    Tried are the room's `middle` (3,) and places a quarter in from the corners of what is hit `inside` (P,
    3).
    """
    some = np.array([owner in furniture for owner in things.owners])[things.owner]
    first = np.arange(len(hits.place)) < hits.first
    seen = hits.place[first & some[hits.triangle]]
    if not len(seen):
        return None
    tree, quarter = things.tree(some), np.ptp(inside, axis=0) / 4
    clear = _CLEAR * 4 * float(quarter.max())
    signs = [(0, 0, 0), *((x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (0, 1))]
    eyes = [middle + np.array(sign) * quarter for sign in signs]

    def shown(eye: Floats) -> float:
        nearest: Any = tree.find_nearest(Vector(eye.tolist()))
        if nearest[3] is not None and nearest[3] < clear:
            return -1.0
        away = seen - eye
        distance = np.linalg.norm(away, axis=1)
        cast: Any = tree.ray_cast
        ways = (away / distance[:, None]).tolist()
        met = [cast(Vector(eye.tolist()), Vector(way))[3] for way in ways]
        reached = np.array([np.inf if one is None else one for one in met])
        return float((reached > (1 - _SEEN) * distance - _OFF * things.size).mean())

    return max(eyes, key=shown)
