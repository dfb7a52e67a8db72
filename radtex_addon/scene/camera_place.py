# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The places of a scene's cameras."""

from __future__ import annotations

from typing import Any, cast

import bpy
import numpy as np

from ..bake.transfer_buckets import Eye
from ..core.arrays import Floats
from ..core.errors import InputError


def find_camera_place(scene: bpy.types.Scene) -> Eye:
    """The place of the scene's camera. Raises InputError if it has no camera."""
    camera = scene.camera
    if camera is None or camera.type != "CAMERA":
        raise InputError(
            f"scene '{scene.name}' has no camera to be seen from: add one (Add > Camera), "
            "or choose the view normal"
        )
    return place_of_camera(camera)


def place_of_camera(camera: bpy.types.Object) -> Eye:
    """The place of a camera, which may be an evaluated one."""
    far = cast(bpy.types.Camera, camera.data).type == "ORTHO"
    x, y, z = cast(Any, camera.matrix_world).col[2 if far else 3][:3]
    length = (x * x + y * y + z * z) ** 0.5 if far else 1.0
    return Eye((x / length, y / length, z / length), far)


def camera_points(scene: bpy.types.Scene) -> Floats:
    """Where all of a scene's cameras stand, in world space: (C, 3) float64."""
    cameras = [item for item in scene.objects if item.type == "CAMERA"]
    return np.array([item.matrix_world.translation for item in cameras], dtype=np.float64).reshape(-1, 3)
