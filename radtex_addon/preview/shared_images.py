# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Packed images of the surroundings, such as an HDRI, are stored once for all previews of a folder.

The surroundings light what stands beside the bake, so a preview needs their images. An image with a file on
disk stays a link to it. One that is packed into the user's .blend would be in each object's preview again:
it is written to the folder `preview-images` beside them instead, named after its content, and linked by a
relative path. If the file that it was packed from is still there, unchanged, that is linked.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, cast

import bpy

from ..formats.disk.atomic import replacing
from ..scene.objects import is_linked
from .trimmed_scene import replaced

FOLDER = "preview-images"  # beside the previews
_LARGE = 1 << 16  # bytes: smaller ones stay packed
_SUFFIXES = {"HDR": ".hdr", "OPEN_EXR": ".exr", "OPEN_EXR_MULTILAYER": ".exr", "JPEG": ".jpg", "TIFF": ".tif"}


@contextmanager
def packed_images_shared(images: Iterable[bpy.types.Image], folder: Path) -> Iterator[None]:
    """Within the context, links to files replace the large packed ones of these images, for all users.

    Files are written to FOLDER in `folder`, unless they are there. Images of several files (UDIM tiles,
    views) and those of libraries stay as they are. Raises BakeError where the system refuses.
    """
    with ExitStack() as session:
        for image in sorted(images, key=lambda image: image.name):
            data = _packed_data(image)
            if data is None:
                continue
            path = _source_of(image, data) or _stored(image, data, folder / FOLDER)
            link = cast("bpy.types.Image", image.copy())
            session.callback(bpy.data.images.remove, link)
            link.unpack(method="REMOVE")
            link.filepath_raw = path
            session.enter_context(replaced(image, link))
        yield


def relative_path(path: str) -> str:
    """The path relative to the open file, or as it is, on another Windows drive."""
    try:
        return bpy.path.relpath(bpy.path.abspath(path))
    except ValueError:
        return path


def _packed_data(image: bpy.types.Image) -> bytes | None:
    packed = image.packed_file
    if packed is None or is_linked(image) or image.source != "FILE" or len(image.packed_files) != 1:
        return None
    return cast(bytes, cast(Any, packed).data) if packed.size >= _LARGE else None


def _source_of(image: bpy.types.Image, data: bytes) -> str | None:
    """The image's path if its file has this content."""
    path = Path(bpy.path.abspath(image.filepath_raw)) if image.filepath_raw else None
    try:
        if path is None or not path.is_file() or path.stat().st_size != len(data):
            return None
        return image.filepath_raw if path.read_bytes() == data else None
    except OSError:
        return None


def _stored(image: bpy.types.Image, data: bytes, folder: Path) -> str:
    """The path of a file with this content, which is written if it is not there."""
    named = Path(bpy.path.basename(image.filepath_raw) or image.name)
    suffix = _SUFFIXES.get(image.file_format, f".{image.file_format.lower()}")
    path = folder / f"{bpy.path.clean_name(named.stem)}-{hashlib.sha256(data).hexdigest()[:12]}{suffix}"
    if not path.is_file() or path.stat().st_size != len(data):
        with replacing(path) as beside:
            beside.write_bytes(data)
    return relative_path(str(path)) if bpy.data.filepath else str(path)
