# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The room around the baked objects: large flat things that enclose it, and what stands inside.

Both are found by ray casts. Most of what is mirrored in a room lies on its floor, ceiling or walls. Cutting
their planes puts nearly all of that in its place; a map of distances, iterated, misses it for many rays.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any

import bpy
import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from ....core.arrays import Bools, Floats, Ints
from ....core.frame import normalised
from ....core.octahedron import cell_directions
from ....scene.mesh.mesh_checks import FARTHEST
from ....scene.mesh.render_contents import Shown, read_render
from ....scene.mesh.triangle_tree import distances_from, triangle_tree
from ..lookup.environment import MOST_BOXES, MOST_PLANES, Impostor, Shell
from ..lookup.ray_ends import SAME

_RAYS = 3000  # that leave the baked objects
_FEWEST = 100  # rays that must end somewhere
_BOUNCES = 3
_TRIED = 160  # planes, for each one that is found
_FEWEST_PLANES = 3  # of a room
_MOST_TRIANGLES = 4_000_000
_THIN = 0.015  # of the room's size: what lies so near to a plane lies on it
_TURNED = 0.998  # cosine between normals of one plane
_LEAST = 0.015  # share of the hits that a plane needs
_BEHIND = 0.06  # most hits behind a plane of the room, such as what is seen through windows
_ENCLOSED = 0.5  # share of the hits that must lie on the planes
_ON_PLANES = 0.5  # share of an object's area on planes or beyond, from which on it belongs to them …
_RISES = 2.0  # … unless it rises so many times that thickness above all planes, as lamps do …
_BEARS = 0.02  # … and has less than this share of all area on planes, which what makes up a room has
_BACKS = 0.4  # share of the rays' length: if less than that ends at backs, these are the insides of things
_DIRECTIONS = 32  # along a side of the octahedron, in which planes are looked for
_OFF = 2e-6  # of the scene's size, by which rays start off surfaces
_USUAL = (2, 98)  # percentiles of where rays end, which the size of a room is told by
_AROUND = [(x, y, 0) for x in (-1, 0, 1) for y in (-1, 0, 1) if (x, y) != (0, 0)]  # the room's middle
_FLAT = 1e-3  # sine of an angle between planes that is none
_OPEN = 0.1  # sine at which a ray must meet a plane, or passes by
_PLACES = 400  # by which eyes of the room are judged
_MORE_SEEN = 0.1  # share of these, by which another eye is better than the middle
_STEPS_OF_EYES = 8  # as a power of 2: eyes lie on a grid of so small a part of the room
_CLEAR = 0.03  # of the room's size, from an eye to the nearest thing


@dataclass(frozen=True, eq=False)
class Room:
    """Planes of `normals` (n, 3) . p = `heights` (n,) in world space, float64, with the inside above them.

    `eye` (3,): inside, whence they are seen. What is no more than `thin` before a plane lies on it.
    `furniture`: the owners of what stands inside and is not on a plane; all other things belong to the
    planes' picture. `size`: the longest side of all that is there. `shown`: the baked objects that are in the
    pictures, too: all, if some make up the room, such as its floor, or all lie on its planes, and else none.
    `furniture_eye` (3,): whence furniture is seen, None: from the objects' middle. `boxes`: the lowest and
    highest corner (2, 3) of each piece of furniture.
    """

    normals: Floats
    heights: Floats
    eye: Floats
    thin: float
    furniture: frozenset[bpy.types.Object]
    shown: frozenset[bpy.types.Object]
    furniture_eye: Floats | None
    boxes: dict[bpy.types.Object, Floats]
    size: float

    def boxes_of(self, some: Collection[bpy.types.Object], middle: Floats) -> Floats:
        """Boxes (n, 2, 3) from the middle (3,) around furniture, at most MOST_BOXES: near ones share one."""
        boxes: list[Floats] = [
            self.boxes[owner] - middle for owner in sorted(some, key=lambda owner: owner.name)
        ]
        while len(boxes) > MOST_BOXES:
            pairs = [(first, second) for second in range(len(boxes)) for first in range(second)]
            first, second = min(pairs, key=lambda pair: _more_area(boxes[pair[0]], boxes[pair[1]]))
            boxes[first] = _joined(boxes[first], boxes.pop(second))
        return np.array(boxes, dtype=np.float32).reshape(-1, 2, 3)

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
    things = read_render(scene, things_of)
    if things is None:
        return None
    hits = _explore(things, points, facets, np.random.default_rng(seed))
    if len(hits.place) < _FEWEST:
        return None
    low, high = np.percentile(hits.place, _USUAL, axis=0)
    thin = _THIN * float((high - low).max())
    found = _planes(hits, thin)
    if found is None:
        return None
    normals, heights = found
    furniture, bearing = things.sorted_by(normals, heights, thin)
    eye = _eye_for_all(things, furniture, normals, heights, thin)
    if eye is None:
        eye = _middle_of(
            hits.place[_before(hits.place, normals, heights, -thin).all(axis=0)], normals, heights
        )
    seen = _seen_from(eye, normals, heights)  # others lie behind, such as a wall's outside
    normals, heights = normals[seen], heights[seen]
    boxes = {owner: things.box(owner) for owner in furniture}
    of_room = bool(bearing.intersection(subjects)) or furniture.isdisjoint(subjects)
    shown = frozenset(subjects) if of_room else frozenset[bpy.types.Object]()
    room = Room(normals, heights, eye, thin, furniture, shown, None, boxes, things.size)
    own = None if shown else (points.min(axis=0) + points.max(axis=0)) / 2
    seen_furniture = furniture if shown else furniture.difference(subjects)
    return replace(room, furniture_eye=_best_eye(room, things, hits, seen_furniture, own))


@dataclass(frozen=True, eq=False)
class Things:
    """Triangles `corners` (F, 3, 3) in world space, and the number of the owner of each, (F,)."""

    owners: list[bpy.types.Object]
    corners: Floats
    owner: Ints

    @property
    def size(self) -> float:
        """The longest side of their box."""
        return float(np.ptp(self.corners.reshape(-1, 3), axis=0).max())

    def box(self, owner: bpy.types.Object) -> Floats:
        """The lowest and the highest corner (2, 3) of what an owner shows."""
        corners = self.corners[self.owner == self.owners.index(owner)].reshape(-1, 3)
        return np.array([corners.min(axis=0), corners.max(axis=0)])

    def but(self, owners: Collection[bpy.types.Object]) -> Bools:
        """Which triangles (F,) are not of some owners."""
        others = np.array([owner not in owners for owner in self.owners])
        found: Bools = others[self.owner]
        return found

    def tree(self, some: Bools) -> BVHTree:
        """Of some triangles (F,)."""
        corners = self.corners[some]
        return triangle_tree(
            corners.reshape(-1, 3), np.arange(3 * len(corners), dtype=np.int32).reshape(-1, 3)
        )

    def sorted_by(
        self, normals: Floats, heights: Floats, thin: float
    ) -> tuple[frozenset[bpy.types.Object], frozenset[bpy.types.Object]]:
        """The owners that are furniture, and those that make up the room with planes of these normals (n, 3).

        All others lie on planes: most of their area is on one, less than `thin` before it, or beyond.
        """
        area = _areas(self.corners)
        above = self.corners @ normals.T  # (F, 3, n), of which there is no second copy
        above -= heights
        on = (above.max(axis=1) < thin).any(axis=1)
        count = len(self.owners)
        whole, lying = np.bincount(self.owner, area, count), np.bincount(self.owner, area * on, count)
        rise = np.zeros(count)
        np.maximum.at(rise, self.owner, above.min(axis=2).max(axis=1))
        bears = lying >= _BEARS * lying.sum()
        stands = (lying < _ON_PLANES * whole) | ~bears & (rise > _RISES * thin)
        furniture, bearing = (
            frozenset(owner for owner, chosen in zip(self.owners, some, strict=True) if chosen)
            for some in (stands, bears & ~stands)
        )
        return furniture, bearing


def things_of(shown: Iterator[Shown]) -> Things | None:
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
        flipped = np.linalg.det(one.matrix[:3, :3]) < 0
        corners.append(place[shape.triangles[:, ::-1] if flipped else shape.triangles])
        owner.append(np.full(len(shape.triangles), owners.setdefault(one.owner, len(owners))))
    if not corners:
        return None
    return Things(list(owners), np.concatenate(corners), np.concatenate(owner))


@dataclass(frozen=True, eq=False)
class _Hits:
    """Rays that end somewhere: `start`, `place` that they hit, `normal` there that faces them, (P, 3) each.

    `triangle` (P,): which they hit; `weight` (P,): their lengths over the sum, so that what is inside walls
    counts little. The first `first` of them leave the baked objects.
    """

    start: Floats
    place: Floats
    normal: Floats
    triangle: Ints
    weight: Floats
    first: int

    def share(self, some: Bools) -> float:
        """The weight of some of them, (P,)."""
        return float(self.weight[some].sum())


def _explore(things: Things, points: Floats, facets: Floats, random: np.random.Generator) -> _Hits:
    """Rays from points about facets, and from where these end."""
    tree = things.tree(np.ones(len(things.corners), dtype=bool))
    some = random.integers(0, len(points), _RAYS)
    place, normal = points[some].astype(np.float64), facets[some].astype(np.float64)
    found = []
    for _ in range(_BOUNCES):
        way = normalised(normal + 0.999 * normalised(random.normal(size=normal.shape)))
        found.append(_cast(tree, place + _OFF * things.size * normal, way))
        _, place, normal, *_ = found[-1]
        if not len(place):
            break
    start, place, normal, triangle, length, back = (np.concatenate(each) for each in zip(*found, strict=True))
    kept = ~back if length[back].sum() < _BACKS * length.sum() else np.ones_like(back)  # or all is inside out
    length = np.where(kept, length, 0)
    weight = length[kept] / max(length.sum(), 1e-30)
    first = int(kept[: len(found[0][0])].sum())
    return _Hits(start[kept], place[kept], normal[kept], triangle[kept], weight, first)


def _cast(tree: BVHTree, start: Floats, way: Floats) -> tuple[Floats, Floats, Floats, Ints, Floats, Bools]:
    """Of rays that hit: starts, places, normals that face them, triangles, lengths, whether at a back."""
    cast: Any = tree.ray_cast
    found = [
        cast(Vector(place), Vector(along)) for place, along in zip(start.tolist(), way.tolist(), strict=True)
    ]
    hit = np.array([one[0] is not None for one in found], dtype=bool)
    met = [one for one in found if one[0] is not None]
    place, normal = (np.array([one[k] for one in met], dtype=np.float64).reshape(-1, 3) for k in (0, 1))
    back = (normal * way[hit]).sum(axis=1) > 0
    normal[back] *= -1
    triangle = np.array([one[2] for one in met], dtype=np.int64)
    return start[hit], place, normal, triangle, np.array([one[3] for one in met], dtype=np.float64), back


def _planes(hits: _Hits, thin: float) -> tuple[Floats, Floats] | None:
    """Normals (n, 3) and heights (n,) of the planes around the hits, the largest first; None if none are."""
    left = np.ones(len(hits.place), dtype=bool)
    on_any = np.zeros_like(left)
    normals: list[Floats] = []
    heights: list[float] = []
    while len(normals) < MOST_PLANES and left.any():
        on, way, height = _largest_plane(hits, left, thin)
        if hits.share(on) < _LEAST:
            break
        left &= ~on
        if hits.share(hits.place @ way - height < -thin) < _BEHIND:
            normals.append(way)
            heights.append(height)
            on_any |= np.abs(hits.place @ way - height) < thin
    if len(normals) < _FEWEST_PLANES or hits.share(on_any) < _ENCLOSED:
        return None
    return np.array(normals), np.array(heights)


def _largest_plane(hits: _Hits, left: Bools, thin: float) -> tuple[Bools, Floats, float]:
    """Of the hits that are `left`, those on the plane that has most (P,), its unit normal and its height."""
    place, normal = hits.place, hits.normal
    rest = np.flatnonzero(left)
    tried = rest[np.linspace(0, len(rest) - 1, min(_TRIED, len(rest))).astype(np.intp)]

    def lying_on(way: Floats, height: float) -> Bools:
        found: Bools = left & (normal @ way > _TURNED) & (np.abs(place @ way - height) < thin / 2)
        return found

    best = max((lying_on(normal[one], float(place[one] @ normal[one])) for one in tried), key=hits.share)
    way = normalised(normal[best].mean(axis=0))
    height = float(np.median(place[best] @ way))
    return lying_on(way, height), way, height


def _joined(one: Floats, other: Floats) -> Floats:
    """The box (2, 3) around two."""
    return np.array([np.minimum(one[0], other[0]), np.maximum(one[1], other[1])])


def _more_area(one: Floats, other: Floats) -> float:
    """By how much the surface of the box around two is larger than theirs."""
    return _area(_joined(one, other)) - _area(one) - _area(other)


def _area(box: Floats) -> float:
    x, y, z = box[1] - box[0]
    return float(x * y + y * z + z * x)


def _seen_from(eye: Floats, normals: Floats, heights: Floats) -> Bools:
    """Which planes are met first in some direction from an eye, (n,)."""
    sine = normals @ cell_directions(_DIRECTIONS).T
    above = (normals @ eye - heights)[:, None]
    far = np.where(sine < 0, above / np.maximum(-sine, 1e-9), np.inf)
    found: Bools = np.bincount(far.argmin(axis=0), minlength=len(normals)) > 0
    return found


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


def _eye_for_all(
    things: Things, furniture: Collection[bpy.types.Object], normals: Floats, heights: Floats, thin: float
) -> Floats | None:
    """Whence a room is seen, (3,): the same for all that is baked in it, so that its picture is, too.

    From its middle, or where it is angled and a place a quarter in from its sides sees more, from there. None
    if nothing but furniture lies inside.
    """
    shell = things.but(furniture)
    middles = things.corners[shell].mean(axis=1)
    inside = things.corners[shell][_before(middles, normals, heights, -thin).all(axis=0)]
    if not _areas(inside).any():
        return None
    corners = _corners_of(normals, heights, thin)
    if not len(corners):  # of a room that is open at a side
        corners = inside.reshape(-1, 3)
        corners = corners[_before(corners, normals, heights, -thin).all(axis=0)]
        if not len(corners):
            return None
    low, high = corners.min(axis=0), corners.max(axis=0)
    tried = (low + high) / 2 + np.array([(0, 0, 0), *_AROUND]) * (high - low) / 4
    step = 2.0 ** (math.floor(math.log2(max(float((high - low).max()), 1e-30))) - _STEPS_OF_EYES)
    tried = np.round(tried / step) * step + 0.0  # the mesh of what is baked is rounded otherwise
    free = _before(tried, normals, heights, thin).all(axis=0)
    if not free.any():
        return None
    tree, places = things.tree(shell), _places_on(inside)
    seen = np.array([_share_seen(tree, eye, places, thin) for eye in tried])
    seen[0] += _MORE_SEEN
    found: Floats = tried[np.where(free, seen, -1).argmax()]
    return found


def _corners_of(normals: Floats, heights: Floats, thin: float) -> Floats:
    """The corners (P, 3) that some planes enclose, none where they are open to some side."""
    if not ((normals @ cell_directions(_DIRECTIONS).T) < -_OPEN).any(axis=0).all():
        return np.zeros((0, 3))
    three = np.array(list(combinations(range(len(normals)), 3)))
    three = three[np.abs(np.linalg.det(normals[three])) > _FLAT]
    found = np.linalg.solve(normals[three], heights[three][..., None])[..., 0]
    kept: Floats = found[_before(found, normals, heights, -thin).all(axis=0)]
    return kept


def _places_on(corners: Floats) -> Floats:
    """Places (P, 3) all over triangles (F, 3, 3), by their areas."""
    random, area = np.random.default_rng(0), _areas(corners)
    some = random.choice(len(corners), _PLACES, p=area / max(float(area.sum()), 1e-30))
    weight = random.dirichlet(np.ones(3), _PLACES)
    found: Floats = (weight[:, :, None] * corners[some]).sum(axis=1)
    return found


def _share_seen(tree: BVHTree, eye: Floats, places: Floats, thin: float) -> float:
    """The share of places (P, 3) before which nothing lies, seen from an eye."""
    away = places - eye
    distance = np.maximum(np.linalg.norm(away, axis=1), 1e-30)
    return float((distances_from(tree, eye, away / distance[:, None]) > distance - thin).mean())


def _areas(corners: Floats) -> Floats:
    """Of triangles (F, 3, 3), doubled: (F,)."""
    a, b, c = corners.transpose(1, 0, 2)
    found: Floats = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return found


def _best_eye(
    room: Room, things: Things, hits: _Hits, seen: frozenset[bpy.types.Object], own: Floats | None
) -> Floats | None:
    """The eye (3,) from which the furniture that is `seen` is met best, by rays that leave the baked objects.

    None: from their middle. Tried are the room's eye, places a quarter in from its corners that lie before
    all planes, and the objects' `own` middle (3,), if it may be.
    """
    some = np.array([owner in seen for owner in things.owners])[things.owner]
    if not some.any():
        return None
    tree, first = things.tree(some), slice(hits.first)
    middle, (low, high) = room.eye, np.percentile(hits.place, _USUAL, axis=0)
    boxes, shell = room.boxes_of(seen, middle), room.shell(middle)
    length = np.linalg.norm(hits.place[first] - hits.start[first], axis=1)
    offset = (hits.start[first] - middle).astype(np.float32)
    axis = normalised(hits.place[first] - hits.start[first]).astype(np.float32)
    none = np.zeros(len(axis), dtype=np.float32)
    on_shell = shell.seen_at(shell.meet(offset, axis, none)[0].astype(np.float32)) + middle

    def right(eye: Floats) -> float:
        """The share of the rays that would be shown the right place."""
        nearest: Any = tree.find_nearest(Vector(eye.tolist()))
        if nearest[3] < _CLEAR * float((high - low).max()) and eye is not own:
            return -1.0
        direction = cell_directions(_DIRECTIONS)
        far = distances_from(tree, eye, direction)
        solid = np.isfinite(far)
        if not solid.any():
            return 0.0
        place = (eye - middle).astype(np.float32)
        impostor = Impostor.of(direction[solid].astype(np.float32), far[solid], place)
        met = replace(impostor, boxes=boxes, shell=shell).meet(offset, axis, none)[0].astype(np.float64)
        far = distances_from(tree, eye, met)
        solid = np.isfinite(far)
        shown = np.where(solid[:, None], eye + np.where(solid, far, 0)[:, None] * met, on_shell)
        apart = np.linalg.norm(shown - hits.place[first], axis=1)
        return float((apart < np.maximum(SAME * length, room.thin / 2)).mean())

    signs = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 0, 1)]
    eyes = [room.eye, *((low + high) / 2 + np.array(sign) * (high - low) / 4 for sign in signs)]
    eyes = [eye for eye in eyes if _before(eye[None], room.normals, room.heights, room.thin).all()]
    best = max((eyes or [room.eye]) if own is None else [own, *eyes], key=right)
    return None if best is own else best
