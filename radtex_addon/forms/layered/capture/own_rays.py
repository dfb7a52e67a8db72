# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Where mirror rays meet the objects themselves: asked of objects that emit their own texture coordinates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np

from ....bake.light_samples import Axis, LobeSamples, spread_shifts
from ....bake.plan import CapturePlan, plan_of_some
from ....core import large_arrays
from ....core.arrays import Bools, Floats, Ints
from ....core.gutter import nearest_covered
from ....core.surface import SurfaceMesh
from ....cycles.building_blocks import float_image
from ....cycles.path_ends import Body, path_ends
from ....cycles.portal import Aim, PortalCapture
from ....cycles.sampling import tiles_of
from ....scene.mesh.backs import fronts, twin_numbers
from ....scene.nodes import open_material, open_world
from ....settings.kinds import Kind
from ..samples import OwnRays

_AHEAD = 5  # of the bake's seed
_FRONT, _BACK = "radtex_front_uv", "radtex_back_uv"  # attributes of corners
_OUTSIDE = 2.0  # texels: where a hit lies further from its texel's middle, the texel's own point is taken
_AT_ONCE = 1 << 18  # rays
_COVERED, _APART = 1.0, 2.0  # in blue: what the atlas covers, and parts of the object with other atlases
_FLAT = 1e-12  # doubled area of a triangle in UV: with less, places on it are not told by UV


@dataclass(frozen=True, eq=False)
class SurfaceUV:
    """Texture coordinates of the triangles of a rendered mesh, (F, 3, 2): of their `front` and their `back`.

    `inside` (F,): which triangles the atlas covers; the coordinates of others do not matter.
    """

    front: Floats
    back: Floats
    inside: Bools

    @property
    def two_sided(self) -> bool:
        """Whether a back may have other coordinates than the front."""
        return self.back is not self.front


def capture_own_rays(
    scene: bpy.types.Scene,
    bodies: Sequence[Body],
    uvs: Sequence[SurfaceUV],
    plan: CapturePlan,
    surface: SurfaceMesh,
    triangle: Ints,
    seed: int,
    folder: Path,
    alpha: Floats | None = None,
    uv_layer: str = "",
) -> OwnRays:
    """One mirror ray in each of the plan's cells. Raises BakeError where Cycles fails.

    `uvs` are those of the `bodies`; `triangle` (K,) is each of the plan's texels' in `surface`. Where a map
    of `alpha` (H, W, 1), over the UV layer, says less than 1, so many rays go on. Where rays meet triangles
    that the atlas does not cover, a path is traced along each of them in `scene`.
    """
    aim = own_aim(plan, seed)
    with path_ends(scene, bodies, (), np.zeros(3, np.float32)) as ends:
        two_sided = any(uv.two_sided for uv in uvs)
        material = _shows_uv(alpha, uv_layer, two_sided)
        for copy, uv in zip(ends.copies, uvs, strict=True):
            copy.data = _with_uv(cast(bpy.types.Mesh, copy.data), uv, material, two_sided)
        del uvs, uv  # of large meshes, a hundred megabytes
        ends.scene.world = dark_world()
        capture = PortalCapture(ends.scene, plan, Kind.REFLECTION, 1, seed, folder, aim)
        count = plan.layout.bucket**2
        hits, told = [], []
        for tile in tiles_of(plan):
            coded = capture.render_passes(tile).raw_whole[..., :3].reshape(-1, count, 3)
            hits.append(coded[..., 2] > 0.5)
            told.append(large_arrays.stowed(coded[hits[-1]]))
    hit, seen = large_arrays.concatenated(hits), large_arrays.concatenated(told)
    inside = seen[:, 2] < _COVERED + 0.5
    met, place = texels_met(
        plan, surface, triangle, large_arrays.from_blocks(len(seen), lambda some: seen[some, :2] - 1)
    )
    met[~inside], place[~inside] = -1, 0
    light = None if inside.all() else light_along(scene, plan, aim, hit, ~inside, seed, folder)
    return OwnRays(own_samples(plan, aim, hit), hit, met, place, light)


def light_along(
    scene: bpy.types.Scene,
    plan: CapturePlan,
    aim: Aim,
    hit: Bools,
    wanted: Bools,
    seed: int,
    folder: Path,
) -> Floats:
    """The light (P, 3) of one path along each `wanted` (P,) ray of those that `hit` (K, n*n), 0 of others."""
    row, _ = np.nonzero(hit)
    some = np.zeros(len(hit), dtype=bool)
    some[row[wanted]] = True
    part = plan_of_some(plan, some)
    aim = Aim(aim.shift[some])
    capture = PortalCapture(scene, part, Kind.REFLECTION, 1, seed, folder, aim)
    light, first = large_arrays.zeros((len(row), 3)), 0
    texels, start = np.flatnonzero(some), np.searchsorted(row, np.arange(len(hit) + 1))
    for tile in tiles_of(part):
        found = capture.render_passes(tile).whole[..., :3].reshape(-1, plan.layout.bucket**2, 3)
        for texel, rays in zip(texels[first:], found, strict=False):
            light[start[texel] : start[texel + 1]] = rays[hit[texel]]
        first += len(found)
    light[~wanted] = 0
    return light


def own_aim(plan: CapturePlan, seed: int) -> Aim:
    """Where the rays of each texel aim in its cells."""
    return Aim(spread_shifts(len(plan.texel), seed + _AHEAD))


def own_samples(plan: CapturePlan, aim: Aim, hit: Bools) -> LobeSamples:
    """The rays as samples without light."""
    none = np.broadcast_to(np.float16(0), (*hit.shape, 3))
    every = np.broadcast_to(np.True_, hit.shape)
    return LobeSamples(plan, Axis.MIRROR, aim.squares(plan.layout.bucket), none, every)


def texels_met(plan: CapturePlan, surface: SurfaceMesh, triangle: Ints, uv: Floats) -> tuple[Ints, Floats]:
    """The plan's texels (P,) at texture coordinates (P, 2), and the places there in the world (P, 3).

    `triangle` (K,) is each texel's in `surface`. Where the plan has no texel, the nearest one in the atlas.
    """
    width, height = plan.layout.width, plan.layout.height
    frames, corner = _uv_frames(surface, triangle), surface.uv[triangle, 0]
    number = np.full(width * height, -1, dtype=np.int32)
    number[plan.texel] = np.arange(len(plan.texel), dtype=np.int32)
    rows, columns = nearest_covered((number >= 0).reshape(height, width))
    filled = number.reshape(height, width)[rows, columns]
    met, place = large_arrays.empty(len(uv), np.int32), large_arrays.empty((len(uv), 3))
    for first in range(0, len(uv), _AT_ONCE):
        some = slice(first, first + _AT_ONCE)
        met[some], place[some] = _met(plan, filled, frames, corner, uv[some])
    return met, place


def _met(
    plan: CapturePlan,
    nearest: Ints,
    frames: tuple[Floats, Floats],
    corner: Floats,
    uv: Floats,
) -> tuple[Ints, Floats]:
    """As `texels_met`; `nearest` (H, W) are texels, `frames` and `corner` (K, 2) of the texels' triangles."""
    height, width = nearest.shape
    column = np.clip(np.floor(uv[:, 0] * width), 0, width - 1).astype(np.intp)
    row = np.clip(np.floor(uv[:, 1] * height), 0, height - 1).astype(np.intp)
    met = nearest[row, column]
    place = plan.points[met].astype(np.float32)
    origin, along = frames
    moved = uv - corner[met]
    told = origin[met] + (along[met] * moved[:, None]).sum(axis=2)
    j, i = np.divmod(plan.texel[met], width)
    off = np.maximum(np.abs(uv[:, 0] * width - i - 0.5), np.abs(uv[:, 1] * height - j - 0.5))
    usable = (off < _OUTSIDE) & np.isfinite(told).all(axis=1)
    return met.astype(np.int32), np.where(usable[:, None], told, place).astype(np.float32)


def _uv_frames(surface: SurfaceMesh, triangle: Ints) -> tuple[Floats, Floats]:
    """Of triangles (K,) the first corners (K, 3), and how places change with u and v, (K, 3, 2), or NaN."""
    first = large_arrays.from_blocks(
        len(triangle), lambda some: surface.position[surface.triangles[triangle[some], 0]]
    )
    return first, large_arrays.from_blocks(len(triangle), lambda some: _uv_slopes(surface, triangle[some]))


def _uv_slopes(surface: SurfaceMesh, triangle: Ints) -> Floats:
    """How places on triangles (K,) change with u and v, (K, 3, 2), or NaN."""
    corners, uv = surface.position[surface.triangles[triangle]], surface.uv[triangle]
    edges = np.stack([corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]], axis=2)
    first, second = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
    area = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    area = np.where(np.abs(area) > _FLAT, area, np.nan)
    inverse = np.stack(
        [
            np.stack([second[:, 1], -second[:, 0]], axis=1),
            np.stack([-first[:, 1], first[:, 0]], axis=1),
        ],
        axis=1,
    )
    slopes: Floats = np.einsum("fce,fea->fca", edges, inverse) / area[:, None, None]
    return slopes


def sides_of(surface_uv: Floats, mesh: bpy.types.Mesh, inside: Bools) -> SurfaceUV:
    """The texture coordinates of both sides of a baked copy's faces, without its twins.

    `surface_uv` (F, 3, 2) are those of all faces of `mesh`, and `inside` (F,) are those that the atlas
    covers; the back of a face without a twin has the front's.
    """
    twin = twin_numbers(mesh)
    if twin is None:
        return SurfaceUV(surface_uv, surface_uv, inside)
    own = fronts(twin)
    front, pair = surface_uv[own], twin[own]
    back = front.copy()
    back[pair >= 0] = surface_uv[pair[pair >= 0]][:, ::-1]  # a twin's corners are in the opposite order
    return SurfaceUV(front, back, inside[own])


def _with_uv(
    mesh: bpy.types.Mesh, surface: SurfaceUV, material: bpy.types.Material, two_sided: bool
) -> bpy.types.Mesh:
    """A copy of the mesh with this material alone, which reads the texture coordinates of both sides.

    If no mesh is `two_sided`, those of the front alone.
    """
    copy: Any = cast(bpy.types.ID, mesh).copy()
    copy.materials.clear()
    copy.materials.append(material)
    flag = np.where(surface.inside, _COVERED, _APART).repeat(3)
    sides = {_FRONT: surface.front, _BACK: surface.back} if two_sided else {_FRONT: surface.front}
    for name, uv in sides.items():
        values = np.zeros((uv.shape[0] * 3, 3), dtype=np.float32)
        values[:, :2] = uv.reshape(-1, 2) + 1
        values[:, 2] = flag
        copy.attributes.new(name, "FLOAT_VECTOR", "CORNER").data.foreach_set("vector", values.ravel())
    return cast(bpy.types.Mesh, copy)


def _shows_uv(alpha: Floats | None, uv_layer: str, two_sided: bool) -> bpy.types.Material:
    """A material that emits the texture coordinates of the side that is met, plus 1, and the flag in blue."""
    material, build = open_material("RadTex UV")
    shown = build.attribute(_FRONT)
    if two_sided:
        shown = build.mix(build.geometry("Backfacing"), shown, build.attribute(_BACK))
    shader = build.node("ShaderNodeEmission", shown, 1.0).outputs[0]
    if alpha is not None:
        image = float_image("RadTex alpha", np.repeat(alpha, 3, axis=2))
        share = build.image(image, build.uv_map(uv_layer), "Linear")[0]
        chance = build.node("ShaderNodeTexWhiteNoise", build.geometry("Position")).outputs["Value"]
        through = build.node("ShaderNodeBsdfTransparent").outputs[0]
        apart = build.math("GREATER_THAN", build.separate(shown)[2], (_COVERED + _APART) / 2)
        stops = build.math("GREATER_THAN", build.math("MAXIMUM", share, apart), chance)
        shader = build.node("ShaderNodeMixShader", stops, through, shader).outputs[0]
    build.node("ShaderNodeOutputMaterial", shader)
    cast(Any, material).cycles.emission_sampling = "NONE"
    return material


def dark_world() -> bpy.types.World:
    """A world that sends out no light."""
    world, build = open_world("RadTex dark")
    background = build.node("ShaderNodeBackground", (0.0, 0.0, 0.0, 1.0), 0.0)
    build.node("ShaderNodeOutputWorld", background.outputs[0])
    return world
