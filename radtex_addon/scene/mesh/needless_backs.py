# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Backs that can be seen from outside of their mesh, but from no place in the scene where a camera can be.

In a room, the back of a wall, floor, ceiling, mirror or rug faces the outdoors, the next wall or what it lies
on. Texels for it would take half of the atlas. Rays among all that the scene renders tell which backs these
are. It is judged of each region of triangles that hang together with no edge sharper than _SHARP: of a wall,
not of half of it. A region's back is needless

* if something lies right behind it: rays from it end within a hair, measured along its normal, or inside what
  is closed, as those of a mirror on a wall, of a rug, of a plane within a wall of a thickness of its own;
* or if nearly all rays from it end so, leave the scene, or meet other backs, and its front faces the inside
  of a room: rays from its front end, and from the middles of their ways rays in all directions end, too, a
  fifth of them no nearer than a metre, and some at other objects.

It is kept if more of its rays meet front sides that are farther than a hair: a camera between the two sees
both. So it is for a leaf above ground, and for a wall with a garden, but not with the rim of the room's own
floor. It is kept, too, of what stands in the open, whatever lies below it: a bowl, a flag, a ground, a roof
without walls. Which way a room's planes face does not matter: if their backs look inwards, their fronts see
no inside, and the backs are kept.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...bake.progress import Progress, Stage, Steps
from ...core.arrays import Bools, Floats, Ints
from ...core.frame import normalised
from ...core.islands import areas_on_surface, weld
from ...core.surface import inner_edges, ray_offset
from .face_rays import regions
from .scene_rays import Met, Thing, cast_rays, extent_of

_RAYS = 8_000  # in total from the backs of a mesh, and as many from its fronts …
_LEAST, _MOST = 64, 512  # … and from a region; the largest regions are judged, as far as the rays go
_SHARP = 40  # degrees between neighbours, from which on they are of two regions
HAIR = 0.004  # times the scene's size, in which the back of what lies on something is …
_OWN_HAIR = 0.03  # … and times the region's own size, if that is less
_OFF = 0.05  # times a bake's ray offset: how far off a triangle rays start
_FEW = 0.02  # share of rays from a needless back that may end otherwise …
_STRIP = 0.1  # … and of those from the outside of a room, that may end at front sides
_WINDOWS = 0.25  # share of rays in a room that may leave it
_FAR = 0.2  # share of them that goes on for a metre, as no ray does in a vase …
_OTHERS = 0.02  # … and that ends at other objects


def needless_backs(own: Thing, seen: Bools, others: Sequence[Thing], room: float) -> Steps[Bools]:
    """Which of a thing's triangles `seen` (F,) from behind are so from no place where a camera can be: (F,).

    `others` are the scene's other things; `room` is a metre, in scene units. Yields progress.
    """
    needless = np.zeros_like(seen)
    if not others or not seen.any():
        return needless
    position, triangles = own.position, own.triangles
    label, area = _labels(position, triangles, seen), areas_on_surface(position, triangles)
    scene = extent_of([own, *others])
    random = np.random.default_rng(0)
    labels = _judged(label[seen], area[seen])
    for done, (number, rays) in enumerate(labels):
        yield Progress(Stage.EVALUATE, done, len(labels))
        faces = np.flatnonzero(seen & (label == number))
        corners = position[triangles[faces]]
        size = float(np.linalg.norm(np.ptp(corners, axis=(0, 1))))
        hair = min(HAIR * scene, _OWN_HAIR * size)
        sent = _Sent.of(corners, area[faces], rays, _OFF * ray_offset(position), random)
        needless[faces] = _is_needless(sent, [own, *others], hair, room, random)
    return needless


class _Sent:
    """Cosine-distributed rays from all over a region: from `place` (K, 3), so far `off`, along `way` (K, 3).

    `normal` (K, 3) is that of the front; `way` goes there, and its mirror image to the back.
    """

    def __init__(self, place: Floats, normal: Floats, way: Floats, off: float) -> None:
        self.place, self.normal, self.way, self.off = place, normal, way, off

    @classmethod
    def of(cls, corners: Floats, area: Floats, rays: int, off: float, random: np.random.Generator) -> _Sent:
        """From triangles with `corners` (F, 3, 3) and an `area` (F,)."""
        so_far = np.cumsum(area)
        face = np.searchsorted(so_far, (np.arange(rays) + random.random(rays)) / rays * so_far[-1])
        a, b, c = corners[np.minimum(face, len(area) - 1)].transpose(1, 0, 2)
        root, along = np.sqrt(random.random(rays))[:, None], random.random(rays)[:, None]
        place = a * (1 - root) + root * ((1 - along) * b + along * c)
        normal = normalised(np.cross(b - a, c - a))
        way = normalised(normal + 0.999 * normalised(random.normal(size=normal.shape)))
        return cls(place, normal, way, off)

    def front(self, things: Sequence[Thing]) -> tuple[Met, Floats]:
        """What rays from the front meet, and where they start, (K, 3)."""
        start = self.place + self.off * self.normal
        return cast_rays(things, start, self.way), start

    def back(self, things: Sequence[Thing]) -> tuple[Met, Floats]:
        """What rays from the back meet, and how far behind it, (K,)."""
        way = self.way - 2 * np.sum(self.way * self.normal, axis=1, keepdims=True) * self.normal
        met = cast_rays(things, self.place - self.off * self.normal, way)
        return met, self.off - met.distance * np.sum(way * self.normal, axis=1)

    def covered(self, others: Sequence[Thing]) -> Bools:
        """Where another thing lies in the very place of the region, (K,)."""
        met = cast_rays(others, self.place + self.off * self.normal, -self.normal)
        return met.distance < 2 * self.off


def _is_needless(
    sent: _Sent, things: Sequence[Thing], hair: float, room: float, random: np.random.Generator
) -> bool:
    """Whether no camera can be where rays from the back go; the first of the `things` is the mesh itself."""
    met, deep = sent.back(things)
    blocked = met.solid | (deep < hair) | sent.covered(things[1:])
    if (~blocked).mean() <= _FEW:
        return True
    return bool((met.front & ~blocked).mean() <= _STRIP) and _faces_inside(sent, things, room, random)


def _faces_inside(sent: _Sent, things: Sequence[Thing], room: float, random: np.random.Generator) -> bool:
    """Whether the front of a region looks into a room."""
    met, start = sent.front(things)
    if met.leaves.mean() > _WINDOWS:
        return False
    ends = ~met.leaves
    middle = start[ends] + 0.5 * met.distance[ends, None] * sent.way[ends]
    around = cast_rays(things, middle, normalised(random.normal(size=middle.shape)))
    return bool(
        around.leaves.mean() <= _WINDOWS
        and (around.distance >= room).mean() >= _FAR
        and (around.thing > 0).mean() >= _OTHERS
    )


def _labels(position: Floats, triangles: Ints, seen: Bools) -> Ints:
    """Numbers (F,) of regions of `seen` triangles that hang together with no sharp edge."""
    a, b, c = position[triangles].transpose(1, 0, 2)
    normal = normalised(np.cross(b - a, c - a))
    first, second = inner_edges(weld(position)[triangles]).starts.T // 3
    smooth = np.sum(normal[first] * normal[second], axis=1) > np.cos(np.radians(_SHARP))
    return regions(seen, first[smooth], second[smooth])


def _judged(label: Ints, area: Floats) -> list[tuple[int, int]]:
    """The numbers of regions that are judged, the largest first, and how many rays each gets.

    `label`, `area` (K,): of triangles.
    """
    whole = np.bincount(label, area)
    order = np.argsort(-whole, kind="stable")
    rays = np.clip(np.rint(_RAYS * whole[order] / whole.sum()), _LEAST, _MOST).astype(int)
    some = (np.cumsum(rays) <= _RAYS) & (whole[order] > 0)
    return list(zip(order[some].tolist(), rays[some].tolist(), strict=True))
