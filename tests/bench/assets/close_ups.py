# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Close-ups: cameras so near that a texel of the light map fills a tenth of the picture's width."""

from __future__ import annotations

from dataclasses import dataclass
from math import radians, tan

import numpy as np

from radtex_addon.core.errors import InputError
from radtex_addon.report.gbuffer import CameraRays
from radtex_addon.report.through import light_along
from tests.real.exhibit import Camera

from .judging import Part
from .views import nearer

_ACROSS = 10  # texels that fill the picture's width
_STEP = 1e-3  # of a pixel, to tell how large a texel is


@dataclass(frozen=True)
class Spot:
    """A pixel of a view, column and row from the top left, that a close-up shows in its middle."""

    view: str
    column: int
    row: int

    @classmethod
    def parse(cls, text: str) -> Spot:
        """Of text such as view0:120:64. Raises ValueError for other text."""
        view, column, row = text.split(":")
        return cls(view, int(column), int(row))


def close_up(parts: list[Part], cameras: list[Camera], spot: Spot, name: str) -> Camera:
    """The camera of a close-up. Raises InputError where the view is not there, or shows none of the parts."""
    found = [camera for camera in cameras if camera.name == spot.view]
    if not found:
        raise InputError(f"there is no view '{spot.view}' to come nearer in: the scene has {_names(cameras)}")
    (camera,) = found
    rays = _rays(camera, spot)
    met = light_along(parts, rays).first
    if met.min() < 0 or len(set(met)) > 1:
        raise InputError(f"{spot.view} shows no part of the asset at {spot.column}:{spot.row}")
    part = parts[int(met[0])]
    buffer = part.surface.gbuffer(rays, np.full(len(rays.away), np.inf))
    across, along = buffer.position[1:] - buffer.position[0]
    sidecar = part.bake.sidecar
    u, v = (buffer.uv[1:] - buffer.uv[0]) * (sidecar.width, sidecar.height)
    area = float(np.linalg.norm(np.cross(across, along)))
    texel = np.sqrt(area / max(abs(u[0] * v[1] - u[1] * v[0]), 1e-12))
    distance = float(np.linalg.norm(buffer.position[0] - rays.origin))
    print(f"{name}: {part.name}, a texel of {1000 * texel:.2f} thousandths", flush=True)
    return nearer(camera, name, rays.away[0], distance, _ACROSS * texel)


def _rays(camera: Camera, spot: Spot) -> CameraRays:
    """Through the middle of the spot's pixel, and a little to the right and above."""
    matrix, half = np.array(camera.matrix), tan(radians(camera.fovy) / 2)
    column = spot.column + 0.5 + np.array([0, _STEP, 0])
    row = spot.row + 0.5 - np.array([0, 0, _STEP])
    local = np.stack(
        [
            (column / camera.pixels * 2 - 1) * half,
            (1 - row / camera.pixels * 2) * half,
            -np.ones(3),
        ],
        axis=1,
    )
    away = local @ matrix[:3, :3].T
    return CameraRays(1, 1, matrix[:3, 3], away / np.linalg.norm(away, axis=1, keepdims=True))


def _names(cameras: list[Camera]) -> str:
    return ", ".join(camera.name for camera in cameras)
