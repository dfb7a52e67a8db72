# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Render a picture of a saved preview with Cycles."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy

from ..core.errors import BakeError
from ..formats.disk.atomic import replacing_together
from ..formats.disk.path_checks import render_path
from ..scene.render_settings import reset_render_settings


def render_picture(preview: Path, picture: Path, pixels: int = 512, samples: int = 32) -> None:
    """Open the .blend `preview` in place of the open file, and render its camera's view as a PNG, `picture`.

    Raises BakeError if Blender renders nothing.
    """
    bpy.ops.wm.open_mainfile(filepath=str(preview), load_ui=False, use_scripts=False)
    scene: Any = bpy.context.scene
    reset_render_settings(scene, graded=True)
    render = scene.render
    render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising = samples, False
    render.resolution_x = render.resolution_y = pixels
    if hasattr(render.image_settings, "media_type"):  # Blender 5: set before the format
        render.image_settings.media_type = "IMAGE"
    render.image_settings.file_format = "PNG"
    with replacing_together(picture) as beside:
        render.filepath = render_path(beside)
        render.use_file_extension = False
        bpy.ops.render.render(write_still=True)
        if not beside.exists():
            raise BakeError(f"Blender rendered no picture of {preview}")
