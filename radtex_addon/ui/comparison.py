# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A comparison's pictures as images of the file, and in the windows that show images."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, cast

import bpy
import numpy as np

if TYPE_CHECKING:
    from ..report.metrics import Picture
    from ..report.side_by_side import Comparison

TRACED, BAKED, DIFFERENCE = "RadTex Path Traced", "RadTex Baked", "RadTex Difference"
_OURS = "radtex_comparison"  # of an image: which of the three it is


def make_images(found: Comparison) -> list[bpy.types.Image]:
    """Path traced, baked and the difference, packed; those of an earlier comparison are written over."""
    pictures = {TRACED: found.traced, BAKED: found.baked, DIFFERENCE: found.difference}
    return [_image(name, picture, data=name == DIFFERENCE) for name, picture in pictures.items()]


def show_images(images: Sequence[bpy.types.Image]) -> None:
    """Show them in the Image Editors that are open, the difference in the first."""
    manager = bpy.context.window_manager
    windows = manager.windows if manager is not None and not bpy.app.background else ()
    editors = [
        area.spaces.active
        for window in windows
        for area in window.screen.areas
        if area.ui_type == "IMAGE_EDITOR"
    ]
    for editor, image in zip(editors, reversed(images), strict=False):
        cast(Any, editor).image = image


def _image(name: str, picture: Picture, *, data: bool) -> bpy.types.Image:
    """An image of the picture (H, W, 3), row 0 at the bottom; `data` is shown as it is."""
    height, width = picture.shape[:2]
    every = cast("list[Any]", list(bpy.data.images))
    image = next((image for image in every if image.get(_OURS) == name), None)
    if image is None:
        made: Any = bpy.data.images.new(name, width, height, float_buffer=True, is_data=data)
        made[_OURS] = name
        image = made
    if tuple(image.size) != (width, height):
        image.scale(width, height)
    pixels = np.ones((height, width, 4), dtype=np.float32)
    pixels[..., :3] = picture
    image.pixels.foreach_set(pixels.ravel())
    image.update()
    image.pack()
    return cast("bpy.types.Image", image)
