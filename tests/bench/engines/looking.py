# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A stage's cameras as every program takes them, and what the reference lookup sees of a finished bake."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, partial
from math import atan, degrees
from typing import Any, cast

import bpy
import numpy as np

from radtex_addon.forms.layered.files.layered_files import read_layered
from radtex_addon.report.finished_bake import Finished
from radtex_addon.report.gbuffer import Array, BakedSurface, GBuffer
from radtex_addon.report.metrics import Mask, Picture, psnr
from radtex_addon.scene.preview_file import baked_copy
from radtex_addon.settings.spec import Layout
from tests.bench.fidelity.composite import seen_light
from tests.bench.fidelity.method import Baked
from tests.bench.fidelity.methods.layered import look_alpha
from tests.bench.fidelity.references import View, view_of
from tests.bench.fidelity.scenes import PIXELS, Stage
from tests.real.exhibit import Camera

RAYS = 3  # a pixel's along its side in every program: as many as Godot's screen has room for
_SAME = 1e-4  # of a matrix's values


@dataclass(frozen=True, eq=False)
class Look:
    """A held-out camera: for programs, and as the bench's `view`, with the path-traced picture."""

    camera: Camera
    view: View

    @property
    def name(self) -> str:
        """Without spaces, for files."""
        return self.camera.name


@dataclass(frozen=True, eq=False)
class Seen:
    """What the reference lookup sees in a look: `picture` (PIXELS, PIXELS, 3), linear, and the G-buffer."""

    look: Look
    buffer: GBuffer
    picture: Picture

    @cached_property
    def inside(self) -> Mask:
        """Pixels that the object covers wholly, (PIXELS, PIXELS)."""
        return self.buffer.inside

    def decibels(self, picture: Picture) -> float:
        """PSNR of a linear picture against the path-traced one, as the bench takes it."""
        return psnr(picture, self.look.view.reference, self.buffer.eroded)


def looks(stage: Stage, count: int, samples: int) -> list[Look]:
    """The first `count` held-out cameras of the stage that the open file holds; `samples`: of a reference."""
    return [Look(_camera(item), view_of(stage, item, samples)) for item in stage.held_out[:count]]


def looked_up(finished: Finished, matrix_world: Array, looked_from: list[Look]) -> list[Seen]:
    """What the reference lookup sees of a bake with a preview, under `matrix_world` (4, 4)."""
    facts = finished.sidecar
    with baked_copy(finished.preview, facts.surfaces, facts.uv_map) as (_, copy):
        mesh = cast(bpy.types.Mesh, copy.data)
        surface = BakedSurface(mesh, matrix_world, facts.uv_map)
        baked = Baked(0, 0.0, 0, finished.radiance, mesh, matrix_world, facts.uv_map, _alpha(finished))
        return [_seen(baked, surface, look) for look in looked_from]


def averaged(picture: Picture) -> Picture:
    """The pixels of a picture of RAYS x RAYS rays a pixel, (RAYS P, RAYS P, C) to (P, P, C): their means."""
    side = len(picture) // RAYS
    mean: Picture = picture.reshape(side, RAYS, side, RAYS, -1).mean(axis=(1, 3))
    return mean


def _seen(baked: Baked, surface: BakedSurface, look: Look) -> Seen:
    view = look.view
    buffer = surface.gbuffer(view.rays, view.blocked)
    light = seen_light(baked, surface, view.rays, view.blocked, buffer, view.behind)
    return Seen(look, buffer, buffer.resolve(light))


def _alpha(finished: Finished) -> Any:
    """How a layered bake with an alpha hides what lies behind, as `Baked.alpha`; None for others."""
    if finished.form.traits.layout != Layout.LAYERED:
        return None
    atlas, _ = read_layered(finished.file)
    return None if atlas.alpha is None else partial(look_alpha, atlas)


def _camera(item: bpy.types.Object) -> Camera:
    """A stage's camera as programs take it, with RAYS x RAYS of the bench's pixels for each of its."""
    data = cast(bpy.types.Camera, item.data)
    bpy.context.view_layer.update()
    matrix = np.array(item.matrix_world, dtype=np.float64)
    place, target = matrix[:3, 3].tolist(), (matrix[:3, 3] - matrix[:3, 2]).tolist()
    camera = Camera(
        name=item.name.replace(" ", "-"),
        place=(place[0], place[1], place[2]),
        target=(target[0], target[1], target[2]),
        fovy=degrees(2 * atan(data.sensor_width / 2 / data.lens)),
        pixels=RAYS * PIXELS,
    )
    assert np.abs(np.array(camera.matrix) - matrix).max() < _SAME, "the camera's head is not level"
    return camera
