# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Captions inside pictures, and files of limited size: animated WebP, JPEG, PNG."""

from __future__ import annotations

import io
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np
from PIL import Image, ImageDraw, ImageFont

from radtex_addon.core.errors import InputError
from radtex_addon.formats.disk.atomic import replacing
from radtex_addon.report.metrics import Picture

_QUALITIES = (92, 86, 80, 74, 68, 60, 52, 44, 36, 28, 20)
_MARGIN = 9  # pixels between a caption and the pane's edge


def captioned(shown: Picture, text: str, size: int = 15, right: bool = False) -> Picture:
    """Display values (H, W, 3) with a line of text in the lower left corner, or the right one."""
    image = as_image(shown)
    draw = ImageDraw.Draw(image)
    font = ImageFont.load_default(size)
    margin = round(_MARGIN * size / 15)
    place = (image.width - margin if right else margin, image.height - margin)
    dark, pale = (25, 24, 23), (250, 248, 244)
    anchor = "rs" if right else "ls"
    draw.text(place, text, fill=pale, font=font, anchor=anchor, stroke_width=2, stroke_fill=dark)
    found: Picture = np.asarray(image, dtype=np.float64) / 255
    return found


def graded(light: Picture) -> Picture:
    """Display values of linear light (H, W, 3) as Blender shows it by default, in AgX, with more contrast.

    By an image and the open scene's colour management, which are left as they were.
    """
    scene = cast(Any, bpy.context.scene)
    view, kind = scene.view_settings, scene.render.image_settings
    height, width = light.shape[:2]
    pixels = np.ones((height, width, 4), dtype=np.float32)
    pixels[..., :3] = light[::-1]
    image: Any = bpy.data.images.new("Light", width, height, float_buffer=True)
    image.colorspace_settings.name = "Linear Rec.709"
    kept = view.view_transform, view.look, kind.file_format, kind.color_mode, kind.color_depth
    try:
        image.pixels.foreach_set(pixels.ravel())
        if hasattr(kind, "media_type"):
            kind.media_type = "IMAGE"
        kind.file_format, kind.color_mode, kind.color_depth = "PNG", "RGB", "8"
        view.view_transform, view.look = "AgX", "AgX - Medium High Contrast"
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "shown.png")
            image.save_render(str(path), scene=scene)
            shown: Picture = np.asarray(Image.open(path).convert("RGB"), dtype=np.float64) / 255
    finally:
        view.view_transform, view.look = kept[:2]
        kind.file_format, kind.color_mode, kind.color_depth = kept[2:]
        bpy.data.images.remove(image)
    return shown


def as_image(shown: Picture) -> Image.Image:
    """Display values (H, W, 3) as an image of eight bits."""
    return Image.fromarray((np.clip(shown, 0, 1) * 255 + 0.5).astype(np.uint8))


def save_film(path: Path, frames: Sequence[Picture], per_second: float, most_bytes: int) -> int:
    """Save display values as a WebP that repeats for ever, as well as `most_bytes` allow; returns its bytes.

    Raises InputError where it is larger at the lowest quality.
    """
    images = [as_image(frame) for frame in frames]
    duration = round(1000 / per_second)

    def encode(quality: int, into: io.BytesIO) -> None:
        images[0].save(
            into,
            "WEBP",
            save_all=True,
            append_images=images[1:],
            duration=duration,
            loop=0,
            quality=quality,
            method=5,
            kmax=1,  # every frame whole: else what hardly changes keeps blocks of frames long past
        )

    return _save(path, encode, most_bytes)


def save_jpeg(path: Path, image: Image.Image, most_bytes: int) -> int:
    """Save a JPEG as well as `most_bytes` allow; returns its bytes. Raises InputError as `save_film` does."""
    return _save(
        path,
        lambda quality, into: image.save(into, "JPEG", quality=quality + 8, optimize=True, subsampling=0),
        most_bytes,
    )


def save_png(path: Path, image: Image.Image, most_bytes: int) -> int:
    """Save a PNG of all colours, or of as many as `most_bytes` allow; returns its bytes.

    Raises InputError as `save_film` does.
    """
    colours = (1 << 24, *range(256, 31, -32))

    def encode(step: int, into: io.BytesIO) -> None:
        few = colours[min(step, len(colours) - 1)]
        kept = image if few > 256 else image.quantize(few, dither=Image.Dither.FLOYDSTEINBERG)
        kept.save(into, "PNG", optimize=True)

    return _save(path, encode, most_bytes, range(len(colours)))


def _save(
    path: Path,
    encode: Callable[[int, io.BytesIO], None],
    most_bytes: int,
    qualities: Sequence[int] = _QUALITIES,
) -> int:
    """Write the first encoding, from the best quality down, that is small enough."""
    for quality in qualities:
        encoded = io.BytesIO()
        encode(quality, encoded)
        if encoded.tell() <= most_bytes:
            path.parent.mkdir(parents=True, exist_ok=True)
            with replacing(path) as beside:
                beside.write_bytes(encoded.getvalue())
            return encoded.tell()
    raise InputError(f"{path.name} takes more than {most_bytes} bytes: make it smaller, or of fewer frames")
