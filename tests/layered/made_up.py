# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A layered bake of nothing in particular, that has every part, and places to look at it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from radtex_addon.bake.light_samples import LightSamples
from radtex_addon.bake.plan import CapturePlan
from radtex_addon.core.arrays import Floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.fragments import Fragments
from radtex_addon.core.frame import normalised
from radtex_addon.forms.layered.capture.panoramas import panorama_directions
from radtex_addon.forms.layered.cells import CELLS, Cells
from radtex_addon.forms.layered.fit.bucket_grid import BucketGrid
from radtex_addon.forms.layered.fit.own_light import Surface
from radtex_addon.forms.layered.fit.rows import Places
from radtex_addon.forms.layered.lookup.atlas import LayeredAtlas
from radtex_addon.forms.layered.lookup.distance_field import DistanceField, FieldFacts
from radtex_addon.forms.layered.lookup.environment import (
    Around,
    Impostor,
    Lamp,
    Pictures,
    Plane,
    SurroundingLayer,
)
from radtex_addon.forms.layered.lookup.lobes import LOBES, STEPS, Material

BALL = 0.7  # radius of the ball that fragments lie on


def made_up_atlas(texels: int, size: int, cells: Cells = CELLS[0]) -> LayeredAtlas:
    """With buckets of texels / 2, colours of 4 texels and pictures of `size` cells along their sides.

    Buckets of what the object shows of itself and of the rest have so many `cells`.
    """
    rng = np.random.default_rng(1)
    direction = panorama_directions(2 * size)
    flat = direction.reshape(-1, 3)
    world = Pictures.of(direction, _waves(rng, flat, 3) ** 4 * 4, size)
    below, beside = flat[:, 2:] < -0.3, np.abs(flat[:, 2:] - 0.2) < _waves(rng, flat, 1) * 0.4
    layers = []
    for where, light in ((below, _waves(rng, flat, 3)), (beside, _waves(rng, flat, 3) * 2)):
        layers.append(Pictures.of(direction, np.concatenate([light * where, where], axis=1), size))
    distance = 1.6 + _waves(rng, flat[beside[:, 0]], 1)[:, 0]
    things = Impostor.of(flat[beside[:, 0]], distance.astype(np.float32))
    plane = Plane(np.array([0, 0, 1], np.float32), -1.1, np.array([0, 0, 0.6], np.float32))
    lamp = Lamp(np.array([1.5, -1, 2.5], np.float32), np.array([3, 2.5, 2], np.float32), 2e-3)
    middle = np.array([0.1, 0.2, -0.1], np.float32)
    around = Around(
        middle, world, (SurroundingLayer(layers[0], plane), SurroundingLayer(layers[1], things)), (lamp,)
    )
    bend = np.linspace(0.3, 0.0, STEPS).astype(np.float32)
    materials = []
    for narrow, wide in ((5e-4, 0.02), (0.01, 0.2)):
        weight = rng.uniform(0.2, 0.7, (LOBES, 1, 3)) * np.linspace(1.5, 0.8, STEPS)[:, None]
        variance = np.array([[narrow], [wide]]) * np.linspace(0.7, 1.3, STEPS)
        materials.append(Material(weight.astype(np.float32), variance.astype(np.float32), bend * narrow * 20))
    half = texels // 2
    uv = _middles(half)
    own = _buckets(rng, uv, cells.own, 4)
    own[..., 3] = np.clip(own[..., 3] * 3 - 1, 0, 1)
    return LayeredAtlas(
        colour=_image(rng, 4 * texels, 3),
        irradiance=_image(rng, texels, 3) * 3,
        falloff=np.linspace([[0.6, 0.7, 0.8], [1.4, 1.3, 1.2]], 1, 16, axis=1).astype(np.float32),
        tint=None,
        normal=None,
        width=None,
        around=around,
        materials=tuple(materials),
        own=own,
        rest=_buckets(rng, _middles(texels if cells.every else half), cells.rest, 3) * 0.4 - 0.2,
    )


def made_up_fragments(atlas: LayeredAtlas, count: int, framed: bool = False) -> Fragments:
    """Anywhere on a ball around the middle, seen from its front, with tangents if they are `framed`."""
    rng = np.random.default_rng(2)
    normal, viewer = (normalised(rng.normal(size=(count, 3))) for _ in range(2))
    viewer *= np.sign((normal * viewer).sum(axis=1, keepdims=True))
    position = atlas.around.middle + BALL * normal
    fields = (rng.uniform(size=(count, 2)), normal, viewer, position)
    uv, normal, viewer, position = (field.astype(np.float32) for field in fields)
    at = Fragments(uv, normal, viewer, position, rng.integers(len(atlas.materials), size=count))
    if not framed:
        return at
    tangent = normalised(np.cross(normal, [0.1, 0.2, 0.97])).astype(np.float32)
    return replace(at, tangent=tangent, bitangent=np.cross(normal, tangent).astype(np.float32))


def field_of_ball(size: tuple[int, int, int], slopes: float = 0.0) -> DistanceField:
    """Of a ball around the middle; its box has three samples more at each end, of the fewest."""
    step = 2 * BALL / (min(size) - 7)
    low = (-0.5 * step * (np.array(size) - 1)).astype(np.float32)
    axes = [start + step * np.arange(count) for start, count in zip(low, size, strict=True)]
    place = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).transpose(2, 1, 0, 3)
    away = np.linalg.norm(place, axis=-1, keepdims=True)
    values = np.concatenate([place / np.maximum(away, 1e-9), (away - BALL) / step], axis=-1)
    facts = FieldFacts(size, low, float(np.float32(step)), 1.45, slopes, 4, 0.75, (0.8, 0.9, 1.0), True)
    return DistanceField(np.ascontiguousarray(values, dtype=np.float32), facts)


def flat_plan(side: int, cells: int, axes: Floats | None = None) -> CapturePlan:
    """Texels of a unit square that faces +Z; `axes` are its T, Bt and N, the world's if there are none."""
    step = (np.arange(side) + 0.5) / side
    x, y = np.meshgrid(step, step)
    place = np.stack([x, y, np.zeros_like(x)], axis=-1).astype(np.float32)
    axes = np.eye(3) if axes is None else axes
    along, across, up = (np.tile(axis, (side, side, 1)).astype(np.float32) for axis in axes)
    return CapturePlan(AtlasLayout(side, side, cells), np.arange(side * side), place, along, across, up, up)


def light_samples(plan: CapturePlan, square: Floats, **light: Floats) -> LightSamples:
    """Samples of which all are seen, of a white surface, black but for the `light` that is given."""
    black = np.zeros((*square.shape[:2], 3), np.float16)
    parts = dict.fromkeys(("diffuse", "mirrored", "through"), black)
    parts |= {name: values.astype(np.float16) for name, values in light.items()}
    seen, colour = np.ones(square.shape[:2], dtype=bool), np.ones((len(plan.texel), 3), np.float32)
    return LightSamples(plan, square, seen=seen, colour=colour, **parts)


def white_surface(plan: CapturePlan, around: Around, free: Floats, **other: Any) -> Surface:
    """A white matt surface that faces +Z, but for what is given."""
    count = len(plan.texel)
    white = np.ones((count, 3), np.float32)
    parts: dict[str, Any] = {
        "normal": np.tile(np.array([0, 0, 1], np.float32), (count, 1)),
        "diffuse": white,
        "falloff": np.ones((1, 16, 3), np.float32),
        "tint": white,
        "width": white[:, 0],
        "material": np.zeros(count, np.int32),
        "materials": (),
    }
    return Surface(BucketGrid.of(plan, 1), around=around, free=free, **parts | other)


def _middles(side: int) -> Floats:
    """Texture coordinates of the middles of side x side texels, row by row."""
    along = (np.arange(side) + 0.5) / side
    return np.stack(np.meshgrid(along, along), axis=-1).reshape(-1, 2)


def _waves(rng: np.random.Generator, place: Floats, channels: int) -> Floats:
    """Smooth values (N, channels) float32 in 0..1 of places (N, D)."""
    turn = rng.normal(size=(place.shape[1], channels)) * 3
    found: Floats = (0.5 + 0.5 * np.sin(place @ turn + rng.uniform(0, 6, channels))).astype(np.float32)
    return found


def _image(rng: np.random.Generator, size: int, channels: int) -> Floats:
    along = (np.arange(size) + 0.5) / size
    place = np.stack(np.meshgrid(along, along), axis=-1).reshape(-1, 2)
    return _waves(rng, place * 4, channels).reshape(size, size, channels)


def _buckets(rng: np.random.Generator, uv: Floats, cells: int, channels: int) -> Floats:
    along = (np.arange(cells) + 0.5) / cells
    cell = np.stack(np.meshgrid(along, along), axis=-1).reshape(-1, 2)
    place = np.concatenate([uv.repeat(len(cell), axis=0), np.tile(cell, (len(uv), 1))], axis=1)
    side = round(len(uv) ** 0.5)
    return _waves(rng, place, channels).reshape(side, side, cells, cells, channels)


def places_of(place: Floats) -> Places:
    """Places (2, K, S) as they are kept."""
    kept = Places(place.shape[1:])
    kept.keep(slice(None), place)
    return kept
