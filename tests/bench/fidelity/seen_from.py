# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a G-buffer was seen from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radtex_addon.report.gbuffer import Array, GBuffer


@dataclass(frozen=True, eq=False)
class Camera:
    """A camera at `place` (3,), turned by `turn` (3, 3), that looks along its own -z.

    `half` is the tangent of half its angle of view, as in `Rays.of_camera`.
    """

    place: Array
    turn: Array
    half: float


def camera_of(buffer: GBuffer) -> Camera:
    """The camera whose rays a G-buffer's are, from those of them that hit.

    All rays start where their lines meet, in the sense of least squares. Their directions are a linear
    function of the place in the picture, but for their lengths: the direct linear transform (Hartley and
    Zisserman, "Multiple View Geometry in Computer Vision", 2004). Raises ValueError where too few rays hit to
    tell.
    """
    position, away = buffer.position[buffer.hit], -buffer.incoming[buffer.hit]
    if len(away) < 3:
        raise ValueError("too few rays hit the object to tell the camera")
    across = np.eye(3) - away[:, :, None] * away[:, None, :]
    place = np.linalg.solve(across.sum(axis=0), np.einsum("kab,kb->a", across, position))
    x, y = _places(buffer)[buffer.hit].T
    columns = np.stack([x, y, np.ones_like(x)], axis=1)
    crossed = np.cross(away[:, None], np.eye(3))  # away x axis, for each axis: (K, 3, 3)
    equations = (columns[:, :, None, None] * crossed[:, None]).transpose(0, 3, 1, 2).reshape(-1, 9)
    solution = np.linalg.eigh(equations.T @ equations)[1][:, 0].reshape(3, 3)
    right, up, forward = solution * np.sign(np.sum(solution[2] * away.mean(axis=0)))
    half = float(np.linalg.norm(right) / np.linalg.norm(forward))
    axes = [right / np.linalg.norm(right), up / np.linalg.norm(up), -forward / np.linalg.norm(forward)]
    u, _, v = np.linalg.svd(np.stack(axes, axis=1))
    return Camera(place, u @ v, half)


def _places(buffer: GBuffer) -> Array:
    """Each ray's place in the picture, from -1 to 1 to the right and upwards: (N, 2)."""
    pixels = buffer.pixels
    subsamples = round((len(buffer.hit) / pixels**2) ** 0.5)
    count = pixels * subsamples
    steps = (np.arange(count) + 0.5) / count * 2 - 1
    grid = np.stack(np.meshgrid(steps, -steps), axis=2)
    grid = grid.reshape(pixels, subsamples, pixels, subsamples, 2).swapaxes(1, 2)
    return grid.reshape(-1, 2)
