# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Show a comparison: pictures as Blender images, figures as text, and a window for them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import bpy
import numpy as np

from ...scene.working_space import REC_709
from ..operators.undo import in_a_window, push_step
from ..panel.labels import iface_

if TYPE_CHECKING:
    from ...report.metrics import Picture

TRACED, BAKED, DIFFERENCE = "RadTex Path Traced", "RadTex Baked", "RadTex Difference"
_OURS = "radtex_comparison"  # custom property of an image: which of the three it is
_SOURCE = "radtex_source"  # custom property of an image: its source file


def make_images(traced: Picture, baked: Picture, source: str = "") -> list[bpy.types.Image]:
    """Create packed images of path traced, baked and difference; replaces those of an earlier comparison.

    Pushes one undo step.
    """
    from ...report.side_by_side import difference

    pictures = {TRACED: traced, BAKED: baked, DIFFERENCE: difference(traced, baked)}
    images: list[Any] = [_image(name, picture, name == DIFFERENCE) for name, picture in pictures.items()]
    for image in images:
        image[_SOURCE] = source
    push_step("Compare with Cycles")
    return images


def load_images(facts: Mapping[str, Any]) -> list[bpy.types.Image]:
    """The same images from the files in a worker's `facts`, unless already loaded. Raises FormatError."""
    from ...report.side_by_side import read_picture

    source = str(facts["traced"])
    images = [image for name in (TRACED, BAKED, DIFFERENCE) if (image := _ours(name)) is not None]
    if len(images) == 3 and all(image.get(_SOURCE) == source for image in images):
        return images
    return make_images(read_picture(Path(source)), read_picture(Path(facts["baked"])), source)


def figures(facts: Mapping[str, Any]) -> Iterator[str]:
    """The results of a comparison, one line each."""
    yield iface_("{:.1f} dB (at 40 dB hardly anybody sees a difference)").format(facts["psnr"])
    if facts["flip"] is not None:
        yield iface_("FLIP {:.3f} (0 is alike)").format(facts["flip"])
    yield iface_("{:.0%} of the light").format(facts["energy"])


def show_images(images: Sequence[bpy.types.Image]) -> bool:
    """Show images in empty Image Editors, the difference first, unless they are shown already.

    Returns whether any of them is visible.
    """
    seen = {editor.image.name for editor in _editors() if editor.image in images}
    unseen = [image for image in reversed(images) if image.name not in seen]
    empty = [editor for editor in _editors() if editor.image is None]
    for editor, image in zip(empty, unseen, strict=False):
        editor.image = image
    return bool(seen or empty)


def open_window(images: Sequence[bpy.types.Image]) -> None:
    """Show images side by side in a new window."""
    context: Any = bpy.context  # the stubs do not type temp_override as a context manager
    with in_a_window():
        bpy.ops.wm.window_new()
    window = context.window_manager.windows[-1]
    window.screen.areas[0].ui_type = "IMAGE_EDITOR"
    for left in range(len(images) - 1, 0, -1):
        with context.temp_override(window=window, area=window.screen.areas[0]):
            bpy.ops.screen.area_split(direction="VERTICAL", factor=1 / (left + 1))
    last, *others = window.screen.areas  # each split adds one on the left; x is not set before drawing
    for area, image in zip([*others, last], images, strict=True):
        area.spaces.active.image = image


def _editors() -> list[Any]:
    """The spaces of all open Image Editors."""
    manager = bpy.context.window_manager
    windows = manager.windows if manager is not None and not bpy.app.background else ()
    areas = (area for window in windows for area in window.screen.areas)
    return [area.spaces.active for area in areas if area.ui_type == "IMAGE_EDITOR"]


def _ours(name: str) -> Any:
    """The comparison image called `name`; None if there is none."""
    every = cast("list[Any]", list(bpy.data.images))
    return next((image for image in every if image.get(_OURS) == name), None)


def _image(name: str, picture: Picture, data: bool) -> bpy.types.Image:
    """Create an image of the picture (H, W, 3), row 0 at the bottom, which replaces the earlier one.

    `data` images have no colour management. (Undo does not restore the pixels of an overwritten image, so a
    new one is made.)
    """
    height, width = picture.shape[:2]
    before = _ours(name)
    image: Any = bpy.data.images.new(name, width, height, float_buffer=True, is_data=data)
    if not data:
        image.colorspace_settings.name = REC_709  # the default is the file's working space
    pixels = np.ones((height, width, 4), dtype=np.float32)
    pixels[..., :3] = picture
    image.pixels.foreach_set(pixels.ravel())
    image.update()
    image.pack()
    if before is not None:
        before.user_remap(image)
        bpy.data.images.remove(before)
        image.name = name
    image[_OURS] = name
    return cast("bpy.types.Image", image)
