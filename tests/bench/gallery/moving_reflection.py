# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A chrome ball that no bake knew, on its way through a baked room:

    python -m tests.bench.gallery moving_reflection

Ours: the ball's reflected rays, by a BVH, end in the atlases of what they hit; so do the camera's rays. The
ball is seen by the camera alone, so that it neither darkens the room nor shows in it, which no bake could
know; what its shadow and its image change in the ball itself is measured beside.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import pi
from pathlib import Path
from typing import Any, cast

import bmesh
import bpy
import numpy as np

from radtex_addon.core.arrays import Floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.sampler import Filter
from radtex_addon.formats.containers.exr import read_buckets
from radtex_addon.report.gbuffer import Array, CameraRays, eroded
from radtex_addon.report.metrics import Mask, psnr
from radtex_addon.settings.spec import BakeSpec
from tests.reference.hits import sample_hit

from .looking import (
    FILM_PIXELS,
    FRAMES,
    SUBSAMPLES,
    Baked,
    Camera,
    Place,
    added,
    baked,
    empty_scene,
    filmed,
    principled,
    rendered,
    tiles,
)
from .row import Row, Use

SPEC = BakeSpec(denoise=True, texels=128, bucket=8, samples=16)
CAMERA = Camera((2.3, -2.7, 1.5), (-0.2, 0.3, 0.75), lens=32)
PATH: dict[str, Place] = {
    "by the window": (-1.15, 0.35, 0.6),
    "in the middle": (0.0, -0.3, 0.6),
    "near by": (1.05, -0.75, 0.6),
}
STATIC = ("Room", "Floor", "Things", "Window")
RADIUS = 0.6
CHROME = (0.9, 0.92, 0.95)  # seen straight on
_SIDE, _HEIGHT = 6.0, 3.0
_LIFT = 1e-4  # of a mirrored ray's start, off the ball


def scene() -> Any:
    """A closed room lit by its window, three things in it; returns the ball, out of the way of any bake."""
    made = empty_scene()
    made.cycles.max_bounces = made.cycles.diffuse_bounces = 3
    _room()
    floor = added("plane", "Floor", tiles(1.0, 0.6), size=_SIDE)
    floor.location.z = 0.0
    window = added("plane", "Window", _glow((1.0, 0.93, 0.8), 7.0), size=1)
    window.location, window.scale, window.rotation_euler = (-2.97, 0.4, 1.7), (1.5, 2.2, 1), (0, pi / 2, 0)
    _things()
    ball = added("uv_sphere", "Ball", _chrome(), segments=128, ring_count=64, radius=RADIUS)
    ball.hide_render = True
    return ball


def _room() -> None:
    """Walls and ceiling, seen from inside; one wall is red, one blue."""
    room = added("cube", "Room", principled("Plaster", (0.75, 0.73, 0.7), Roughness=0.9), size=1)
    room.data.materials.append(principled("Red", (0.7, 0.14, 0.1), Roughness=0.9))
    room.data.materials.append(principled("Blue", (0.12, 0.25, 0.6), Roughness=0.9))
    room.scale, room.location = (_SIDE, _SIDE, _HEIGHT), (0, 0, _HEIGHT / 2)
    bpy.ops.object.transform_apply(location=True, scale=True)
    cut: Any = bmesh.new()
    cut.from_mesh(room.data)
    cut.normal_update()
    bmesh.ops.delete(cut, geom=[face for face in cut.faces if face.normal.z < -0.5], context="FACES_ONLY")
    for face in cut.faces:
        face.material_index = 1 if face.normal.y > 0.5 else 2 if face.normal.x > 0.5 else 0
    bmesh.ops.reverse_faces(cut, faces=cut.faces)
    cut.to_mesh(room.data)
    cut.free()


def _things() -> None:
    """A ring, a head and a column, one object of three materials."""
    ring = added("torus", "Things", principled("Green", (0.1, 0.5, 0.2), Roughness=0.5), major_radius=0.5)
    ring.location, ring.rotation_euler = (-0.4, 1.9, 0.75), (1.3, 0.2, 0.5)
    head = added("monkey", "Head", principled("Orange", (0.85, 0.38, 0.06), Roughness=0.5), size=1.3)
    head.location, head.rotation_euler = (1.25, 1.35, 0.62), (-0.35, 0, -0.8)
    rounder = head.modifiers.new("Rounder", "SUBSURF")
    rounder.render_levels = rounder.levels = 2
    column = added("cylinder", "Column", principled("Ivory", (0.8, 0.75, 0.6), Roughness=0.6), radius=0.25)
    column.location = (-1.9, -1.6, 1.0)
    bpy.context.view_layer.objects.active = head
    bpy.ops.object.modifier_apply(modifier="Rounder")
    for item in (head, column, ring):
        item.select_set(True)
    bpy.context.view_layer.objects.active = ring
    bpy.ops.object.join()


def _glow(colour: tuple[float, float, float], strength: float) -> bpy.types.Material:
    glow: Any = principled("Glow", (0, 0, 0), Emission_Color=(*colour, 1.0), Emission_Strength=strength)
    glow.cycles.emission_sampling = "FRONT"
    return cast(bpy.types.Material, glow)


def _chrome() -> bpy.types.Material:
    return principled("Chrome", CHROME, Metallic=1.0, Roughness=0.0)


@dataclass(frozen=True, eq=False)
class Atlas:
    """A static object's bake, and its pixels (H*n, W*n, 4)."""

    bake: Baked
    pixels: Floats
    layout: AtlasLayout

    @classmethod
    def of(cls, name: str, spec: BakeSpec, folder: Path) -> Atlas:
        """Bake an object of the open scene."""
        bake = baked(spec, folder, name)
        pixels, facts = read_buckets(bake.sidecar)
        layout = AtlasLayout(facts.width, facts.height, facts.bucket)
        return cls(bake, pixels.astype(np.float32), layout)


def found(atlases: Sequence[Atlas], rays: CameraRays) -> tuple[Array, Array]:
    """What rays find that end in the nearest of the atlases: light (N, 3), and how far away it is (N,)."""
    light, nearest = np.zeros_like(rays.away), np.full(len(rays.away), np.inf)
    for atlas in atlases:
        seen = atlas.bake.surface.gbuffer(rays, nearest)
        hit = seen.hit
        light[hit] = sample_hit(
            atlas.pixels,
            atlas.layout,
            seen.uv[hit],
            rays.away[hit],
            seen.normal[hit],
            seen.tangent[hit],
            seen.sign[hit],
            Filter.QUADRILINEAR,
        )[:, :3]
        nearest[hit] = np.linalg.norm(seen.position - rays.origin, axis=1)[hit]
    return light, nearest


def drawn(atlases: Sequence[Atlas], rays: CameraRays, centre: Place) -> tuple[Array, Mask]:
    """The room with the ball at its place, (pixels, pixels, 3), and which pixels the ball fills."""
    light, distance = found(atlases, rays)
    away = rays.origin - np.array(centre)
    along = rays.away @ away
    root = along**2 - (away @ away - RADIUS**2)
    near = -along - np.sqrt(np.maximum(root, 0))
    hit = (root > 0) & (near > 0) & (near < distance)
    normal = (away + rays.away[hit] * near[hit, None]) / RADIUS
    facing = -np.sum(normal * rays.away[hit], axis=1, keepdims=True)
    mirrored = replace(
        rays,
        origin=np.array(centre) + (RADIUS + _LIFT) * normal,
        away=rays.away[hit] + 2 * facing * normal,
    )
    fresnel = np.array(CHROME) + (1 - np.array(CHROME)) * (1 - facing) ** 5  # Schlick's, as Principled has it
    light[hit] = fresnel * found(atlases, mirrored)[0]
    side = rays.pixels
    mask: Mask = hit.reshape(side, side, -1).all(axis=2)
    return light.reshape(side, side, -1, 3).mean(axis=2), mask


def rows(spec: BakeSpec = SPEC, stills: bool = True) -> Iterator[Row]:
    """The gallery's rows: the ball at three places along its way, by the same bakes."""
    ball = scene()
    with tempfile.TemporaryDirectory() as folder:
        atlases = [Atlas.of(name, spec, Path(folder, name)) for name in STATIC]
    words = f"{len(STATIC)} atlases of {spec.texels} texels, {spec.bucket} cells, {spec.samples} spp"
    ball.hide_render = False
    rays = CAMERA.rays(SUBSAMPLES)
    for name, place in PATH.items() if stills else ():
        ball.location = place
        ours, mask = drawn(atlases, rays, place)
        mask = eroded(mask)
        _seen_by_all(ball, True)
        shadowed = rendered(CAMERA)[..., :3]
        _seen_by_all(ball, False)
        truth = rendered(CAMERA)[..., :3]
        whole = np.ones_like(mask)
        note = (
            f"{words}; the whole picture {psnr(ours, truth, whole):.1f} dB; "
            f"the ball beside one that shadows the room {psnr(ours, shadowed, mask):.1f} dB"
        )
        yield Row(f"Moving reflections, {name}", truth, ours, mask, note, whole)
    _seen_by_all(ball, False)
    yield from _film(ball, atlases)


def _film(ball: Any, atlases: Sequence[Atlas]) -> Iterator[Row]:
    """The ball on its way, there and back."""
    rays = CAMERA.rays(pixels=FILM_PIXELS)
    ends = np.array(PATH["by the window"]), np.array(PATH["near by"])
    for share in (1 - np.cos(2 * np.pi * np.arange(FRAMES) / FRAMES)) / 2:
        x, y, z = ((1 - share) * ends[0] + share * ends[1]).tolist()
        ball.location = x, y, z
        ours, mask = drawn(atlases, rays, (x, y, z))
        whole = np.ones_like(mask)
        yield Row(
            "Moving reflections, film", filmed(CAMERA)[..., :3], ours, eroded(mask), "", whole, Use.FILM
        )


def _seen_by_all(item: Any, seen: bool) -> None:
    """Whether anything but the camera sees it."""
    item.visible_diffuse = item.visible_glossy = item.visible_transmission = item.visible_shadow = seen
