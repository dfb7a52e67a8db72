# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Texels whose points lie under, behind or inside a neighbour: their light is not what is seen beside it.

Along the edges of a floor, texels lie below the walls, or beyond them, outdoors; others below a table's legs
or behind a picture. What they see is black, or the sky, and where textures are blended, a dark or a bright
line would follow each edge. Such texels get no light of their own, but their neighbours', as the gutter does;
their colour stays. Rays from each point among all that the scene renders tell. A texel is covered

* if a seventh of its rays meets the inside of something closed, or the back of what has a needless one
  (`scene/mesh/needless_backs.py`), which no camera sees: the point is in it, or behind a wall; or meets
  something before a bake's rays start: a texel in the corner of two walls would be looked at through one;
* if it lies in the very place of another object's surface that faces it, as below what stands on a floor;
* or if nearly all of its rays end so, or within a hair of the surface at another object, or nearer than a
  metre at backs: the point lies under a rug, behind a picture, or below a leg that is open at its ends.

What an object has of itself does not count, but for its needless backs, and its corners if it is not closed:
see `cycles/find_hidden.py`.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import sqrt

import bpy
import numpy as np

from ..bake.plan import CapturePlan
from ..bake.progress import Progress, Stage, Steps
from ..core.arrays import Bools, Floats, Ints, blocks
from ..core.frame import fallback_tangent
from ..core.islands import areas_on_surface, components
from ..core.texel_map import TexelMap
from ..cycles.path_ends import Body
from ..scene.mesh.needless_backs import HAIR, needless_backs
from ..scene.mesh.scene_rays import Met, Thing, cast_rays, extent_of, read_things
from ..scene.units import metres_per_unit
from .prepared import Prepared

_FIRST, _RAYS = 8, 32  # rays of a texel: of each, and of those that may be covered
_BEHIND = 0.15  # share of rays that meet insides or needless backs
_CLOSED_IN = 0.95  # share of rays that end in any of these ways
_DOUBT = 0.8  # share of the first rays that casts doubt on a texel, though they may have gone astray
_OFF = 0.05  # times a bake's ray offset: how far off the surface rays start
_CRUMB = 4  # texels that hang together between covered ones, and no more, are covered, too
_AT_ONCE = 1 << 12  # texels between two reports of progress


def covered_texels(
    scratch: bpy.types.Scene,
    bodies: Sequence[Body],
    prepared: Prepared,
    plan: CapturePlan,
    texels: TexelMap,
    every_back: bool,
) -> Steps[Bools]:
    """Which of the plan's `texels` are under, behind or inside something in renders of a scratch scene: (K,).

    The `bodies` are what they lie on. With `every_back`, cameras may be anywhere: no back is needless. If all
    would be covered, none is. Yields progress in texels. Raises BakeError where Blender does not render.
    """
    covered = np.zeros(len(plan.texel), dtype=bool)
    hiding = [body.hiding for body in bodies]
    own = [Thing.of(shape, body.matrix, {}) for shape, body in zip(hiding, bodies, strict=True) if shape]
    things = [*own, *read_things(scratch, [body.original for body in bodies])]
    if len(things) < 2:
        return covered
    there = np.array([shape is not None for shape in hiding])
    number = np.where(there, np.cumsum(there) - 1, len(things))  # of a body's thing; clear ones are none
    surface, owner = prepared.surface, number[prepared.owners(plan, texels)]
    area = float(areas_on_surface(surface.position, surface.triangles).sum())
    hair = min(HAIR * extent_of(things), sqrt(area / len(covered)) / 2)
    backs = _Backs(things, 1 / metres_per_unit(scratch), every_back)
    for some in blocks(len(covered), _AT_ONCE):
        yield Progress(Stage.PROBE, some.start, len(covered))
        texel = np.arange(len(covered))[some]
        covered[texel] = _stands(plan, texel, owner[texel], things)
        texel = texel[~covered[texel]]
        for rays, most_behind, most_closed in ((_FIRST, _BEHIND / 2, _DOUBT), (_RAYS, _BEHIND, _CLOSED_IN)):
            behind, closed = yield from _shares(plan, texel, owner[texel], rays, backs, hair)
            texel = texel[(behind >= most_behind) | (closed >= most_closed)]
        covered[texel] = True
    covered |= _crumbs(plan, covered)
    return covered & (not covered.all())


def _crumbs(plan: CapturePlan, covered: Bools) -> Bools:
    """Texels that are not covered, but that a few of hang together, with covered ones beside them: (K,).

    At a corner, a texel beyond two walls may see neither of them from behind.
    """
    height, width = plan.layout.height, plan.layout.width
    number = np.full((height, width), -1, dtype=np.int64)
    number.ravel()[plan.texel] = np.arange(len(plan.texel))
    beside = np.concatenate(
        [
            np.stack([number[:, 1:], number[:, :-1]], axis=-1).reshape(-1, 2),
            np.stack([number[1:], number[:-1]], axis=-1).reshape(-1, 2),
        ]
    )
    beside = beside[(beside >= 0).all(axis=1)]
    alike = covered[beside[:, 0]] == covered[beside[:, 1]]
    label = components(beside[alike], len(covered))
    touches = np.zeros(len(covered), dtype=bool)
    touches[label[beside[~alike]]] = True
    found: Bools = ~covered & touches[label] & (np.bincount(label)[label] <= _CRUMB)
    return found


class _Backs:
    """The things of a scene, and which of their triangles have needless backs, found when it is asked for."""

    def __init__(self, things: Sequence[Thing], room: float, none: bool) -> None:
        self.things, self.room, self._none = things, room, none
        self._needless: dict[int, Bools] = {}

    def needless(self, met: Met) -> Steps[Bools]:
        """Which rays meet needless backs."""
        found = np.zeros(len(met.thing), dtype=bool)
        if self._none:
            return found
        behind = ~met.leaves & ~met.front & ~met.solid
        for number in np.unique(met.thing[behind]).tolist():
            thing = self.things[number]
            if number not in self._needless:
                others = [*self.things[:number], *self.things[number + 1 :]]
                every = np.ones(len(thing.triangles), dtype=bool)
                self._needless[number] = yield from needless_backs(thing, every, others, self.room)
            some = behind & (met.thing == number)
            found[some] = self._needless[number][met.triangle[some]]
        return found


def _stands(plan: CapturePlan, texel: Ints, owner: Ints, things: Sequence[Thing]) -> Bools:
    """Which of some `texel` (K,) lie on another thing's surface that faces theirs, in the same place."""
    place, normal, off = _points(plan, texel)
    found = np.zeros(len(texel), dtype=bool)
    for number in np.unique(owner).tolist():
        some, others = owner == number, [*things[:number], *things[number + 1 :]]
        met = cast_rays(others, place[some] - off[some] * normal[some], normal[some])
        found[some] = met.front & (met.distance < 2 * off[some, 0])
    return found


def _points(plan: CapturePlan, texel: Ints) -> tuple[Floats, Floats, Floats]:
    """Where some texels lie, the normals of their facets, (K, 3), and how far off rays start, (K, 1)."""
    place, normal, offset = (
        values.reshape(plan.rows * plan.columns, -1)[texel].astype(np.float64)
        for values in (plan.position, plan.facet, plan.offset)
    )
    return place, normal, _OFF * offset


def _shares(
    plan: CapturePlan, texel: Ints, owner: Ints, rays: int, backs: _Backs, hair: float
) -> Steps[tuple[Floats, Floats]]:
    """Of each `texel` (K,) the shares of rays that end behind something, and that end in any bad way."""
    place, normal, off = _points(plan, texel)
    tangent = fallback_tangent(normal)
    local, frame = _cosine(rays), np.stack([tangent, np.cross(normal, tangent), normal])
    way = np.einsum("rc,ckx->krx", local, frame).reshape(-1, 3)
    start = np.repeat(place + off * normal, rays, axis=0)
    met = cast_rays(backs.things, start, way)
    others = met.thing != np.repeat(owner, rays)
    sheet = ~np.array([*(thing.solid for thing in backs.things), False])[owner]
    beyond = met.distance < np.repeat(off[:, 0] / _OFF, rays)
    behind = (met.solid & others) | (yield from backs.needless(met))
    behind |= beyond & (others | np.repeat(sheet, rays))
    deep = met.distance.reshape(-1, rays) * local[:, 2]
    near = others & ~met.leaves & (deep < hair).ravel()
    closed = behind | near | (others & ~met.leaves & ~met.front & (met.distance < backs.room))
    return behind.reshape(-1, rays).mean(axis=1), closed.reshape(-1, rays).mean(axis=1)


def _cosine(count: int) -> Floats:
    """Unit vectors (count, 3), cosine-distributed about z: a spiral by the golden angle."""
    height = np.sqrt(1 - (np.arange(count) + 0.5) / count)
    turn = np.arange(count) * np.pi * (3 - 5**0.5)
    wide = np.sqrt(1 - height**2)
    return np.stack([wide * np.cos(turn), wide * np.sin(turn), height], axis=1)
