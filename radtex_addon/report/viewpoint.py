# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The view of a camera or of a 3D viewport, as matrices, and a new camera with the same view."""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np
import numpy.typing as npt
from mathutils import Matrix

from ..core.errors import InputError
from ..core.messages import Remedy, do

_SENSOR = 36.0  # millimetres
_FLAT = 1e-12  # a view matrix with a smaller determinant is invalid
_NUMBERS = 1e18  # of a view's matrices: the squares of larger ones are no numbers in float32
_FARTHEST = 1e7  # the largest clip end, times the clip start: beyond it, float32 matrices are too coarse


@dataclass(frozen=True, eq=False)
class Viewpoint:
    """A view: `matrix` (4, 4) is the viewer's in world space, looking along −z; `projection` (4, 4) OpenGL's.

    Raises InputError for other shapes and for an invalid projection.
    """

    matrix: npt.NDArray[np.float64]
    projection: npt.NDArray[np.float64]

    def __post_init__(self) -> None:
        matrices = (self.matrix, self.projection)
        numbers = all(matrix.shape == (4, 4) and (np.abs(matrix) < _NUMBERS).all() for matrix in matrices)
        if not numbers or not self.projection[0, 0] > 0 or not self.projection[1, 1] > 0:
            raise InputError("these matrices are no view: give a view's own, row by row")

    @classmethod
    def of_camera(
        cls, scene: bpy.types.Scene, layer: bpy.types.ViewLayer, instead: Remedy | None = None
    ) -> Viewpoint:
        """The view of the scene's camera. Raises InputError if there is none, or if it is panoramic.

        `instead` is what else, besides adding a camera, the error of a scene without one offers.
        """
        camera, render = scene.camera, scene.render
        if camera is None:
            remedies = (do("add one"), *(() if instead is None else (instead,)))
            raise InputError(f"scene '{scene.name}' has no camera", *remedies)
        if isinstance(camera.data, bpy.types.Camera) and camera.data.type not in {"PERSP", "ORTHO"}:
            raise InputError(f"camera '{camera.name}' is panoramic: choose a perspective or orthographic one")
        layer.update()
        projection = camera.calc_matrix_camera(
            layer.depsgraph,
            x=render.resolution_x,
            y=render.resolution_y,
            scale_x=render.pixel_aspect_x,
            scale_y=render.pixel_aspect_y,
        )
        return cls(np.array(camera.matrix_world.normalized(), float), np.array(projection, float))

    @classmethod
    def of_view(cls, view: npt.ArrayLike, window: npt.ArrayLike) -> Viewpoint:
        """The view of a 3D viewport: its `view` matrix, from world to view space, and its `window` matrix."""
        matrix = np.array(view, float)
        with np.errstate(over="ignore", invalid="ignore"):  # anybody's numbers
            volume = abs(np.linalg.det(matrix))
        if not _FLAT <= volume < np.inf:
            raise InputError("these matrices are no view: give a view's own, row by row")
        return cls(np.linalg.inv(matrix), np.array(window, float))

    @property
    def rows(self) -> tuple[list[float], list[float]]:
        """The two matrices that `of_view` takes, row by row."""
        view: list[float] = np.linalg.inv(self.matrix).ravel().tolist()
        window: list[float] = self.projection.ravel().tolist()
        return view, window

    def size(self, pixels: int) -> tuple[int, int]:
        """Width and height of a picture whose longer side has `pixels`."""
        aspect = self.projection[1, 1] / self.projection[0, 0]
        width, height = (pixels, pixels / aspect) if aspect >= 1 else (pixels * aspect, pixels)
        return max(1, round(width)), max(1, round(height))

    def camera(self) -> bpy.types.Object:
        """A new camera with this view, linked to no scene yet, for pictures of `size`."""
        data = bpy.data.cameras.new("RadTex eye")
        data.sensor_fit, data.sensor_width = "HORIZONTAL", _SENSOR
        matrix = Matrix(self.matrix.tolist())
        if self.projection[3, 3]:
            matrix @= self._as_orthographic(data)
        else:
            self._as_perspective(data)
        item = bpy.data.objects.new("RadTex eye", data)
        item.matrix_world = matrix
        return item

    def _as_perspective(self, data: bpy.types.Camera) -> None:
        p = self.projection
        data.lens = p[0, 0] * _SENSOR / 2
        data.shift_x, data.shift_y = p[0, 2] / 2, p[1, 2] / 2 * p[0, 0] / p[1, 1]
        near = p[2, 3] / (p[2, 2] - 1)
        beyond = p[2, 2] + 1
        far = p[2, 3] / beyond if beyond < 0 else np.inf
        data.clip_start, data.clip_end = near, min(far, near * _FARTHEST)

    def _as_orthographic(self, data: bpy.types.Camera) -> Matrix:
        """Returns the camera's move backwards: a viewport's orthographic view begins behind the viewer."""
        p = self.projection
        data.type, data.ortho_scale = "ORTHO", 2 / p[0, 0]
        data.shift_x, data.shift_y = -p[0, 3] / 2, -p[1, 3] / 2 * p[0, 0] / p[1, 1]
        near, far = (p[2, 3] + 1) / p[2, 2], (p[2, 3] - 1) / p[2, 2]
        data.clip_start, data.clip_end = (far - near) * 1e-6, far - near
        back: Matrix = Matrix.Translation((0, 0, -near))
        return back
