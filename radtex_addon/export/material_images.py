# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The images of materials that are texture sets as glTF has them, where possible the very files."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np

from ..core.arrays import Floats
from ..core.errors import FormatError
from ..formats.containers.png import encode_png, has_colours_of_eight_bits, only_shown
from ..formats.disk.temporary import temporary_folder
from ..scene.image_materials import ImageMaterial, ImageSource, pixels_of
from ..scene.kept_images import kept_images, kept_number
from ..scene.preview_file import appended

log = logging.getLogger(__name__)

_PNG, _JPEG = "image/png", "image/jpeg"
_BEGINNINGS = {b"\x89PNG\r\n\x1a\n": _PNG, b"\xff\xd8\xff": _JPEG}
_ENDINGS = {"PNG": (".png", _PNG), "JPEG": (".jpg", _JPEG)}
_QUALITY = 92  # of JPEGs that are made smaller
_ROUGH, _METAL = 1, 2  # the channels that glTF reads


@dataclass(frozen=True)
class Picture:
    """An image's file in memory; `wrap` as in `ImageSource`."""

    data: bytes
    mime: str
    name: str
    wrap: str


@dataclass(frozen=True)
class MaterialPictures:
    """A material of images with their files: colour, metal and roughness in one, and normal."""

    facts: ImageMaterial
    base: Picture
    metal: Picture | None
    normal: Picture | None


class _Lost(Exception):
    """An image's file is missing."""


def material_pictures(
    preview: Path, names: Sequence[str], numbers: Sequence[int], limit: int
) -> dict[int, MaterialPictures]:
    """The images of the materials with these `numbers` that the objects `names` of a preview show.

    They have at most `limit` pixels along a side. A material whose images are lost is left out, and a warning
    names it. Raises FormatError for a preview that cannot be read.
    """
    found: dict[int, MaterialPictures] = {}
    with appended(preview, names) as loaded:
        slots = [slot.material for item in loaded if item is not None for slot in item.material_slots]
        for material in dict.fromkeys(slots):
            number = None if material is None else kept_number(material)
            if number is None or number not in numbers or number in found:
                continue
            try:
                found[number] = _pictures(kept_images(material), limit)
            except (_Lost, FormatError) as error:
                log.warning("%s: the export has the bake's own maps of colour and normals", error)
    return found


def _pictures(own: ImageMaterial, limit: int) -> MaterialPictures:
    base = Picture(_white(), _PNG, "white", "REPEAT")
    if own.base_image is not None:
        base = _picture(own.base_image, limit)
    metal, rough = own.metallic_image, own.roughness_image
    normal = None if own.normal is None else _picture(own.normal, limit)
    return MaterialPictures(own, base, _metal_and_roughness(own, metal, rough, limit), normal)


def _metal_and_roughness(
    own: ImageMaterial, metal: ImageSource | None, rough: ImageSource | None, limit: int
) -> Picture | None:
    """One image with roughness in green and metal in blue."""
    if metal is None and rough is None:
        return None
    either = cast(ImageSource, metal or rough)
    fits = (metal is None and own.metallic == 0) or (metal is not None and metal.channel == _METAL)
    fits = fits and rough is not None and rough.channel == _ROUGH
    if fits and (metal is None or rough is None or metal.image == rough.image):
        return _without_unread(_picture(either, limit))
    channels = {_METAL: metal, _ROUGH: rough}
    images = {place: _grey(source) for place, source in channels.items() if source is not None}
    height, width = (max(sizes) for sizes in zip(*(image.shape for image in images.values()), strict=True))
    made = np.ones((height, width, 3), dtype=np.float32)
    for place, image in images.items():
        rows = np.arange(height) * image.shape[0] // height
        columns = np.arange(width) * image.shape[1] // width
        made[..., place] = image[rows[:, None], columns]
    for axis, side in enumerate((height, width)):
        step = -(-side // limit)
        if step > 1:
            made = made.take(np.arange(step // 2, side, step), axis=axis)
    return Picture(encode_png(made[::-1]), _PNG, f"{either.image.name} metal roughness", either.wrap)


def _without_unread(picture: Picture) -> Picture:
    """A picture of metal and roughness with all other channels white, such as occlusion; if that is smaller.

    A JPEG stays as it is: encoded again it would lose.
    """
    if not has_colours_of_eight_bits(picture.data):
        return picture
    with temporary_folder() as folder:
        file = folder / "image.png"
        file.write_bytes(picture.data)
        image: Any = bpy.data.images.load(str(file))
        try:
            image.colorspace_settings.name = "Non-Color"
            pixels, size = pixels_of(image), tuple(image.size)
        finally:
            bpy.data.images.remove(image)
    if not pixels.size or pixels.shape[1::-1] != size:
        return picture
    made = np.ones((*pixels.shape[:2], 3), dtype=np.float32)
    made[..., [_ROUGH, _METAL]] = pixels[..., [_ROUGH, _METAL]]
    data = encode_png(made[::-1])
    return replace(picture, data=data) if len(data) < len(picture.data) else picture


def _grey(source: ImageSource) -> Floats:
    """The channel of an image that is read, (H, W)."""
    pixels = pixels_of(source.image)
    if not pixels.size:
        raise _Lost(f"image '{source.image.name}' is missing")
    if source.channel is not None:
        return pixels[..., min(source.channel, pixels.shape[2] - 1)]
    grey: Floats = pixels[..., :3] @ np.array([0.2126, 0.7152, 0.0722], np.float32)[: pixels.shape[2]]
    return grey


def _picture(source: ImageSource, limit: int) -> Picture:
    """The image's own file if it is one that glTF takes and is no larger than the limit, else one like it."""
    image = source.image
    if 0 in cast(Any, image.size):
        raise _Lost(f"image '{image.name}' is missing")
    data = _file_of(image) if max(cast(Any, image.size)) <= limit and not image.is_dirty else b""
    for beginning, mime in _BEGINNINGS.items():
        if data.startswith(beginning):
            data = only_shown(data) if mime == _PNG else data
            return Picture(data, mime, image.name, source.wrap)
    data, mime = _made_anew(image, limit)
    return Picture(data, mime, image.name, source.wrap)


def _file_of(image: bpy.types.Image) -> bytes:
    """The bytes of an image's file, packed or on disk; none if it has none."""
    if image.packed_file is not None:
        return cast(bytes, cast(Any, image.packed_file).data)
    path = Path(bpy.path.abspath(image.filepath)) if image.filepath else None
    return path.read_bytes() if path is not None and path.is_file() else b""


def _made_anew(image: bpy.types.Image, limit: int) -> tuple[bytes, str]:
    """An image as a file that is no larger than the limit, of its own kind if glTF takes that."""
    ending, mime = _ENDINGS.get(image.file_format, _ENDINGS["PNG"])
    copy: Any = image.copy()
    try:
        share = min(limit / max(copy.size), 1)
        if share < 1:
            copy.scale(*(max(round(side * share), 1) for side in copy.size))
        copy.file_format = "JPEG" if mime == _JPEG else "PNG"
        with temporary_folder() as folder:
            file = folder / f"image{ending}"
            copy.save(filepath=str(file), quality=_QUALITY)
            return file.read_bytes(), mime
    finally:
        bpy.data.images.remove(copy)


def _white() -> bytes:
    return encode_png(np.ones((1, 1, 3), dtype=np.float32))
