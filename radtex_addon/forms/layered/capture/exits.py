# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The rays in which paths that enter the object leave it again, traced by Cycles with the object's materials.

Each path is traced three times with the same random numbers: in a white world, which tells how much gets
through; in a world that emits its rays' directions; and in a sphere that emits its points' directions from
the middle. The last two are the line that the path leaves along, whatever it met inside: refraction, normal
maps, total reflection, the scene's limits of bounces.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np

from ....bake.plan import CapturePlan
from ....core.arrays import Floats
from ....core.colour_spaces import LUMINANCE
from ....cycles.passes import Passes, raw_light_of
from ....cycles.path_ends import TURNS, Body, PathEnds, any_dark, from_directions, path_ends
from ....cycles.portal import Aim, PortalCapture
from ....cycles.sampling import LOBES, MIRRORED, THROUGH, tiles_of
from ....scene.mesh.render_contents import RAYS, Placed, Shape
from ....scene.scratch import scene_copied
from ....settings.spec import Kind
from ..samples import ExitSamples

_WIDER = 1.5  # times the object's radius: the sphere's
_MERIDIANS = 192  # of the sphere, and half as many circles of latitude
_SINGLE = 0.98  # length of a direction that is one path's


def capture_exits(
    scratch: bpy.types.Scene,
    bodies: Sequence[Body],
    middle: Floats,
    radius: float,
    plan: CapturePlan,
    times: int,
    seed: int,
    folder: Path,
) -> ExitSamples:
    """Trace `times` paths in each of the plan's cells, of which there are an even number along a side.

    `middle` (3,) and `radius` are those of a sphere around the `bodies`. Raises BakeError where Cycles fails.
    """
    count, cells = len(plan.texel), plan.layout.bucket**2
    shape = (times, count, cells)
    weight, colour = np.empty(shape, dtype=np.float32), np.zeros((count, 3), dtype=np.float32)
    direction, place = (np.empty((*shape, 3), dtype=np.float32) for _ in range(2))
    white: list[_White] = []
    with _ends(scratch, bodies, (), middle) as ends:
        trace = _Trace(ends, plan, seed, folder)
        for number in range(times):
            white.append(trace.white(number))
            found, weights = trace.ends(number, white[number]), white[number].weight
            length = np.linalg.norm(found, axis=-1, keepdims=True)
            single = length[..., 0] > _SINGLE
            weight[number] = np.where(single, weights @ LUMINANCE, 0)
            direction[number] = np.where(single[..., None], found / np.maximum(length, 1e-6), 0)
            colour += (weights * single[..., None]).sum(axis=1)
    wide = _WIDER * radius
    with _ends(scratch, bodies, (_sphere(middle, wide),), middle) as ends:
        trace = _Trace(ends, plan, seed, folder)
        for number in range(times):
            found = trace.ends(number, white[number])
            length = np.linalg.norm(found, axis=-1, keepdims=True)
            met = found * wide / np.maximum(length, 1e-6)
            along = (met * direction[number]).sum(axis=-1, keepdims=True)
            lost = (length[..., 0] < _SINGLE) | (along[..., 0] <= 0)  # the sphere is met from within
            place[number] = np.where(lost[..., None], 0, met - along * direction[number])
            weight[number][lost] = 0
    bright = colour @ LUMINANCE
    mean = colour.sum(axis=0) / max(float(bright.sum()), 1e-9)
    colour = np.where(bright[:, None] > 0, colour / np.maximum(bright, 1e-9)[:, None], mean)
    direction, place = in_texels_frames(plan, direction, place + middle)
    return ExitSamples(plan, weight, direction, place, colour.astype(np.float32))


def in_texels_frames(plan: CapturePlan, direction: Floats, point: Floats) -> tuple[Floats, Floats]:
    """Lines through points, both (S, K, m, 3) in world space, as `ExitSamples` has them."""
    frame = plan.frames.astype(np.float32)
    away = (point - plan.points[:, None]).astype(np.float32)
    away -= (away * direction).sum(axis=-1, keepdims=True) * direction
    turned = [np.einsum("kac,skmc->skma", frame, vectors, optimize=True) for vectors in (direction, away)]
    return turned[0].astype(np.float32), turned[1].astype(np.float32)


@contextmanager
def _ends(
    scratch: bpy.types.Scene, bodies: Sequence[Body], others: Sequence[Placed], middle: Floats
) -> Iterator[PathEnds]:
    with scene_copied(scratch) as copy, path_ends(copy, bodies, others, middle) as ends:
        yield ends


@dataclass(frozen=True, eq=False)
class _White:
    """What paths let through of white light, (K, n*n, 3): `raw`, as rendered, and `weight` in Rec.709."""

    raw: Floats
    weight: Floats


class _Trace:
    """Paths through the middles of a plan's cells, the same each time the same `number` is asked for."""

    def __init__(self, ends: PathEnds, plan: CapturePlan, seed: int, folder: Path) -> None:
        self._ends, self._plan, self._seed = ends, plan, seed
        aim = Aim(np.full((len(plan.texel), 2), 0.5), MIRRORED + THROUGH)
        self._capture = PortalCapture(ends.scene, plan, Kind.RADIANCE, 1, seed, folder, aim)

    def white(self, number: int) -> _White:
        """What they let through."""
        self._ends.emit_white()
        passes = self._render(number)
        raw = [raw_light_of(one, LOBES["through"]) for one in passes]
        weight = [np.maximum(one.in_rec709(light), 0) for one, light in zip(passes, raw, strict=True)]
        return _White(self._whole(raw), self._whole(weight).astype(np.float32))

    def ends(self, number: int, white: _White) -> Floats:
        """Where they end, (K, n*n, 3), as `path_ends` has it."""
        coded = []
        for turn in range(TURNS if any_dark(white.raw) else 1):
            self._ends.emit_directions(turn)
            coded.append(self._whole([raw_light_of(one, LOBES["through"]) for one in self._render(number)]))
        return from_directions(coded, white.raw).astype(np.float32)

    def _render(self, number: int) -> list[Passes]:
        self._capture.reseed(self._seed + number)
        with self._ends.named_alike():
            return [self._capture.render_passes(tile) for tile in tiles_of(self._plan)]

    def _whole(self, tiles: list[Floats]) -> Floats:
        return np.concatenate(tiles).reshape(len(self._plan.texel), -1, 3)


def _sphere(middle: Floats, radius: float) -> Placed:
    """A sphere that all rays meet."""
    turn = np.arange(_MERIDIANS) / _MERIDIANS * 2 * np.pi
    rise = (np.arange(1, _MERIDIANS // 2) / (_MERIDIANS // 2) - 0.5) * np.pi
    rings = [np.outer(np.cos(rise), part) for part in (np.cos(turn), np.sin(turn))]
    rings.append(np.repeat(np.sin(rise)[:, None], _MERIDIANS, axis=1))
    place = np.concatenate([np.stack(rings, axis=-1).reshape(-1, 3), [[0, 0, -1], [0, 0, 1]]])
    here = np.arange(len(rise) * _MERIDIANS).reshape(len(rise), _MERIDIANS)
    beside = np.roll(here, -1, axis=1)
    south, north = len(place) - 2, len(place) - 1
    faces = [
        np.stack([here[:-1], beside[:-1], beside[1:]], axis=-1).reshape(-1, 3),
        np.stack([here[:-1], beside[1:], here[1:]], axis=-1).reshape(-1, 3),
        np.stack([beside[0], here[0], np.full(_MERIDIANS, south)], axis=-1),
        np.stack([here[-1], beside[-1], np.full(_MERIDIANS, north)], axis=-1),
    ]
    matrix = np.eye(4)
    matrix[:3, 3] = middle
    shape = Shape((place * radius).astype(np.float32), np.concatenate(faces).astype(np.int32))
    return Placed(shape, matrix, frozenset(RAYS))
