# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects of which everything is known: their light, where their paths end, what a viewer sees of them."""

from __future__ import annotations

from collections.abc import Callable, Generator
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np

from radtex_addon.bake.fit import Fitted, fit_shared
from radtex_addon.bake.light_samples import (
    EndSamples,
    LightSamples,
    SurroundingsSamples,
    mirrored,
    spread_shifts,
    straight_through,
)
from radtex_addon.bake.plan import CapturePlan, plan_capture
from radtex_addon.bake.progress import Progress, finished
from radtex_addon.core.arrays import Floats, Ints
from radtex_addon.core.frame import fallback_tangent, orthonormal_frame
from radtex_addon.core.hemisphere import cell_centres
from radtex_addon.core.octahedron import octahedron_to_direction
from radtex_addon.core.shared import Axis, SharedAtlas, sample_shared
from radtex_addon.core.texel_map import TexelMap

HEIGHT, WIDTH = 16, 32
CELLS, SIZE = 8, 48
FINE = 4  # pixels of the colour a side and texel
RAYS = 2  # samples of the surroundings along a cell's side

World: TypeAlias = Callable[[Floats], Floats]  # of directions, (..., 3) -> (..., 3)
Field: TypeAlias = Callable[[Floats, Floats, Floats], Floats]  # of uv (..., 2), position and axis (..., 3)


def chequers(shape: tuple[int, int]) -> Floats:
    """A colour a texel, two in turn, (H, W, 3)."""
    i, j = np.meshgrid(np.arange(shape[1]), np.arange(shape[0]))
    return np.where(((i + j) % 2)[..., None], [0.8, 0.3, 0.1], [0.2, 0.4, 0.7])


BLACK = np.zeros((HEIGHT, WIDTH, 3))
CHEQUERS = chequers((HEIGHT, WIDTH))


def constant(*value: float) -> Field:
    """A grey, or a colour, everywhere."""

    def everywhere(uv: Floats, position: Floats, axis: Floats) -> Floats:
        return np.broadcast_to(value, axis.shape)

    return everywhere


NOTHING, ALL = constant(0), constant(1)


def along_the_axis(uv: Floats, position: Floats, axis: Floats) -> Floats:
    """Ends in a far world that nothing bends."""
    return axis


def sky(d: Floats) -> Floats:
    """Light from far away, smooth and positive."""
    sun = np.exp(4 * (d @ np.array([0.6, 0, 0.8]) - 1))[..., None] * [2, 1.8, 1.5]
    light: Floats = 0.3 + 0.1 * d[..., 2:] + sun
    return light


def grey(value: float) -> World:
    return lambda d: np.full(d.shape, value)


def diffuse_light(normal: Floats) -> Floats:
    """Irradiance over pi, (..., 3) -> (..., 3)."""
    light: Floats = 0.6 + 0.3 * normal[..., 2:] + 0.1 * normal[..., :1] * np.array([1, 0, -1])
    return light


def uneven(uv: Floats, position: Floats, axis: Floats) -> Floats:
    """A weight that differs from place to place."""
    weight: Floats = (0.6 + 0.2 * np.sin(2 * np.pi * uv[..., :1])) * np.ones(3) + 0 * axis
    return weight


def red_from_one_side(uv: Floats, position: Floats, axis: Floats) -> Floats:
    """A glow of the object itself."""
    glow: Floats = np.maximum(-axis[..., :1], 0) * [0.1, 0.05, 0]
    return glow


@dataclass(frozen=True)
class Shine:
    """A lobe's light: so much (`weight`) of what the world shows in the direction `end`, and a `glow`."""

    weight: Field = ALL
    end: Field = along_the_axis
    glow: Field = NOTHING


NONE = Shine(weight=NOTHING)
PLAIN = Shine(weight=uneven, glow=red_from_one_side)


@dataclass(frozen=True, eq=False)
class Known:
    """An object on a plan, its lobes, its diffuse colours (H, W, 3), and the world at a distance."""

    plan: CapturePlan
    mirror: Shine = NONE
    through: Shine = NONE
    colour: Floats = field(default_factory=lambda: BLACK)
    world: World = sky
    nearness: float = 0.0

    def light(self, directions: int = 256) -> LightSamples:
        """Samples of its light, without noise unless its ends are random."""
        square = squares(len(self.plan.texel), directions)
        own = self.colour.reshape(-1, 3)[self.plan.texel]
        _, position = self._places()
        diffuse = np.broadcast_to((own * diffuse_light(position[:, 0]))[:, None], (*square.shape[:2], 3))
        mirrored_light, through = (
            self._shine(shine, *self._places(), axis).astype(np.float32) for shine, axis in self._axes(square)
        )
        return LightSamples(
            self.plan,
            square,
            diffuse.astype(np.float32),
            mirrored_light,
            through,
            own.astype(np.float32),
            np.ones(square.shape[:2], dtype=bool),
        )

    def ends(self, directions: int = 100) -> EndSamples:
        """Samples of where its paths end, 0 where none does."""
        square = squares(len(self.plan.texel), directions, seed=5)
        found = []
        for shine, axis in self._axes(square):
            weight, end = (part(*self._places(), axis) for part in (shine.weight, shine.end))
            found += [weight, np.where(weight.any(axis=-1, keepdims=True), end, 0)]
        return EndSamples(self.plan, square, *(part.astype(np.float32) for part in found))

    def surroundings(self, size: int = SIZE) -> SurroundingsSamples:
        """Samples of the world, RAYS² in each of size x size cells."""
        middle = (np.arange(size * RAYS) + 0.5) / (size * RAYS)
        direction = octahedron_to_direction(np.stack(np.meshgrid(middle, middle), axis=-1).reshape(-1, 2))
        nearness = np.full(len(direction), self.nearness)
        samples = (np.zeros(3), direction, self.world(direction), nearness)
        return SurroundingsSamples(*(part.astype(np.float32) for part in samples))

    def fitting(
        self,
        light: LightSamples | None = None,
        ends: EndSamples | None = None,
        surroundings: SurroundingsSamples | None = None,
        size: int = SIZE,
    ) -> Generator[Progress, None, Fitted]:
        """The steps of the fit to its samples, or to those given instead."""
        return fit_shared(
            light or self.light(),
            ends or self.ends(),
            surroundings or self.surroundings(size),
            enlarged(self.colour),
            CELLS,
            size,
        )

    def fit(
        self,
        light: LightSamples | None = None,
        ends: EndSamples | None = None,
        surroundings: SurroundingsSamples | None = None,
        size: int = SIZE,
    ) -> Fitted:
        """The fit to its samples, or to those given instead; every number in it is a number."""
        fitted = finished(self.fitting(light, ends, surroundings, size))
        atlas = fitted.atlas
        buckets = [part for lobe in atlas.lobes for part in (lobe.ends, lobe.gain, lobe.rest)]
        for part in (atlas.colour, atlas.irradiance, atlas.falloff, *atlas.surroundings, *buckets):
            assert np.isfinite(part).all()
            assert part.dtype == np.float32
        return fitted

    def shown(self, atlas: SharedAtlas, lowest: float = 0.15, paths: int = 1) -> tuple[Floats, Floats]:
        """What fresh fragments of the sphere show by the atlas, and what they should, (K, 3) both.

        They lie on covered texels, away from the chequers' edges, their viewers above cosines of `lowest`.
        The truth is a mean of `paths`, for random ends.
        """
        texel, uv, viewer = self.fragments(lowest)
        normal = normals(uv)
        mirror = 2 * np.sum(normal * viewer, axis=1, keepdims=True) * normal - viewer
        truth: Floats = self.colour.reshape(-1, 3)[texel] * diffuse_light(normal)
        for shine, axis in ((self.mirror, mirror), (self.through, -viewer)):
            truth = truth + np.mean([self._shine(shine, uv, normal, axis) for _ in range(paths)], axis=0)
        return sample_shared(atlas, uv, normal, viewer), truth

    def fragments(self, lowest: float = 0.15) -> tuple[Ints, Floats, Floats]:
        """Texels (K,), their fragments' uv (K, 2), and unit directions to viewers (K, 3)."""
        rng = np.random.default_rng(9)
        texel = rng.choice(self.plan.texel, 4000)
        uv = centres().reshape(-1, 2)[texel] + rng.uniform(-0.35, 0.35, (len(texel), 2)) / [WIDTH, HEIGHT]
        return texel, uv, viewers(rng, normals(uv), tangents(uv), lowest)

    def _shine(self, shine: Shine, uv: Floats, position: Floats, axis: Floats) -> Floats:
        parts = (uv, position, axis)
        light: Floats = shine.weight(*parts) * self.world(shine.end(*parts)) + shine.glow(*parts)
        return light

    def _places(self) -> tuple[Floats, Floats]:
        """Texels' uv (K, 1, 2) and positions (K, 1, 3)."""
        uv = centres().reshape(-1, 1, 2)[self.plan.texel]
        return uv, self.plan.points[:, None]

    def _axes(self, square: Floats) -> tuple[tuple[Shine, Floats], tuple[Shine, Floats]]:
        return (
            (self.mirror, mirrored(self.plan, square)),
            (self.through, straight_through(self.plan, square)),
        )


def with_lobe(
    axis: Axis, shine: Shine, colour: Floats = BLACK, world: World = sky, nearness: float = 0.0
) -> Known:
    """The sphere with one lobe."""
    mirror, through = (shine, NONE) if axis is Axis.MIRROR else (NONE, shine)
    return Known(sphere(), mirror, through, colour, world, nearness)


def sphere() -> CapturePlan:
    """A unit sphere, one column of gutter at either side."""
    normal = normals(centres()).astype(np.float32)
    tangent = tangents(centres()).astype(np.float32)
    triangle = np.zeros((HEIGHT, WIDTH), dtype=np.int32)
    triangle[:, [0, -1]] = -1
    ones = np.ones((HEIGHT, WIDTH), dtype=np.float32)
    return plan_capture(TexelMap(normal, normal, tangent, ones, normal, triangle, triangle >= 0), CELLS)


def floor() -> CapturePlan:
    """The square [-1, 1]^2 at z = 0, whose texels all look up."""
    position = np.concatenate([centres() * 2 - 1, np.zeros((HEIGHT, WIDTH, 1))], axis=-1).astype(np.float32)
    normal, tangent = (np.broadcast_to(np.eye(3, dtype=np.float32)[k], position.shape) for k in (2, 0))
    ones = np.ones((HEIGHT, WIDTH), dtype=np.float32)
    triangle = np.zeros((HEIGHT, WIDTH), dtype=np.int32)
    return plan_capture(TexelMap(position, normal, tangent, ones, normal, triangle, triangle >= 0), CELLS)


def normals(uv: Floats) -> Floats:
    """Those of the unit sphere, +z at v = 1: (..., 2) -> (..., 3). They are its positions, too."""
    azimuth, polar = 2 * np.pi * uv[..., 0], np.pi * (1 - uv[..., 1])
    across = np.sin(polar)
    normal: Floats = np.stack([across * np.cos(azimuth), across * np.sin(azimuth), np.cos(polar)], axis=-1)
    return normal


def tangents(uv: Floats) -> Floats:
    azimuth = 2 * np.pi * uv[..., 0]
    return np.stack([-np.sin(azimuth), np.cos(azimuth), 0 * azimuth], axis=-1)


def centres() -> Floats:
    i, j = np.meshgrid(np.arange(WIDTH), np.arange(HEIGHT))
    return np.stack([(i + 0.5) / WIDTH, (j + 0.5) / HEIGHT], axis=-1)


def squares(texels: int, directions: int, seed: int = 1) -> Floats:
    """B of evenly spread directions, turned from texel to texel: (texels, directions, 2)."""
    side = round(directions**0.5)
    even = (cell_centres(side).reshape(-1, 2) + 1) / 2
    turned = (even + spread_shifts(texels, seed)[:, None]) % 1.0
    return (2 * turned - 1).astype(np.float32)


def viewers(rng: np.random.Generator, normal: Floats, tangent: Floats, lowest: float) -> Floats:
    """Random directions to viewers, evenly over the sphere above cosines of `lowest`."""
    cosine, azimuth = rng.uniform(lowest, 1, (len(normal), 1)), rng.uniform(-np.pi, np.pi, (len(normal), 1))
    across = np.cos(azimuth) * tangent + np.sin(azimuth) * np.cross(normal, tangent)
    viewer: Floats = np.sqrt(1 - cosine**2) * across + cosine * normal
    return viewer


def scattered(variance: float, seed: int = 7) -> Field:
    """Random ends around the axis, of a von Mises-Fisher lobe of that variance along each of two axes."""
    rng = np.random.default_rng(seed)

    def end(uv: Floats, position: Floats, axis: Floats) -> Floats:
        share = rng.random((*axis.shape[:-1], 1))
        cosine = 1 + variance * np.log(share + (1 - share) * np.exp(-2 / variance))
        sine, turn = np.sqrt(np.maximum(1 - cosine**2, 0)), rng.uniform(-np.pi, np.pi, cosine.shape)
        tangent, bitangent, _ = orthonormal_frame(axis, fallback_tangent(axis), np.ones(axis.shape[:-1]))
        around: Floats = cosine * axis + sine * (np.cos(turn) * tangent + np.sin(turn) * bitangent)
        return around

    return end


def on_a_wall(radius: float) -> Field:
    """Ends on the wall of a round room around the origin."""

    def end(uv: Floats, position: Floats, axis: Floats) -> Floats:
        towards = np.sum(position * axis, axis=-1, keepdims=True)
        inside = np.sum(position**2, axis=-1, keepdims=True) - radius**2
        point: Floats = position + (np.sqrt(towards**2 - inside) - towards) * axis
        return point / radius

    return end


def enlarged(colour: Floats) -> Floats:
    return np.repeat(np.repeat(colour, FINE, axis=0), FINE, axis=1)


def relative_error(found: Floats, truth: Floats) -> Floats:
    """The worst channel's error of each fragment, relative to the mean light: (K,)."""
    error: Floats = (np.abs(found - truth) / truth.mean()).max(axis=1)
    return error
