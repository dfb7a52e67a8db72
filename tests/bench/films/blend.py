# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The still life as a file, to open in Blender and bake."""

from __future__ import annotations

from pathlib import Path
from typing import Any, cast

import bpy

from .hero import CAMERA, SIZE
from .still_life import hero_scene


def make(folder: Path) -> None:
    """Save still-life.blend in a folder, with the picture's camera, the HDRI packed."""
    hero_scene()
    scene: Any = bpy.context.scene
    data: Any = bpy.data.cameras.new("Camera")
    data.lens = CAMERA.lens
    item: Any = bpy.data.objects.new("Camera", data)
    item.location, item.rotation_mode, item.rotation_quaternion = CAMERA.place, "QUATERNION", CAMERA.turn
    scene.collection.objects.link(item)
    scene.camera = item
    scene.render.resolution_x, scene.render.resolution_y = SIZE
    scene.view_settings.look = "AgX - Medium High Contrast"
    cast(Any, bpy.ops.file).pack_all()
    bpy.ops.wm.save_as_mainfile(filepath=str(folder.resolve() / "still-life.blend"), compress=True)
