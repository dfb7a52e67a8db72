# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the open file lacks, so that it renders otherwise than whoever made it has seen it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import bpy

_SHADING = ("MATERIAL", "WORLD", "LIGHT", "NODETREE", "TEXTURE")  # users of images that renders look at


def lacking() -> list[str]:
    """A line for the drivers, the images and the libraries that are not there; none where all is well."""
    return [*failed_drivers(), *_missing_images(), *_missing_libraries()]


def failed_drivers(owners: Iterable[Any] | None = None) -> Iterator[str]:
    """A line if Python of drivers was not run, or failed, when their owners were last evaluated.

    The owners are all that the viewport shows; or a render's are given, of which those are told that the
    viewport does not show.
    """
    everything = _all() if owners is None else (one for one in owners if not any(_failed(one.original)))
    found = [(owner, curve) for owner in everything if not owner.is_embedded_data for curve in _failed(owner)]
    if not found:
        return
    curve = found[0][1]
    names = list(dict.fromkeys(f"{owner.bl_rna.name.lower()} '{owner.name}'" for owner, _ in found))
    others = f", as are those of {', '.join(names[1:5])}" if len(names) > 1 else ""
    yield (
        f"the driver of {curve.data_path} of {names[0]} is without a value ('{curve.driver.expression}')"
        f"{others}: a .blend's Python is not run unless you allow it (blender -b --enable-autoexec FILE -P "
        "bake.py -- ...); drive by plain maths, or bake the driver to keyframes"
    )


def _all() -> Iterator[Any]:
    """Every datablock of the open file, once."""
    data: Any = bpy.data
    collections = [one.identifier for one in data.bl_rna.properties if one.type == "COLLECTION"]
    for name in collections:
        if name != "all_ids":
            yield from getattr(data, name)


def _failed(owner: Any) -> Iterator[Any]:
    for animated in (owner, getattr(owner, "node_tree", None)):
        animation = getattr(animated, "animation_data", None)
        for curve in animation.drivers if animation else ():
            if (
                curve.driver
                and curve.driver.type == "SCRIPTED"
                and not curve.driver.is_valid
                and not curve.mute
            ):
                yield curve


def _missing_images() -> Iterator[str]:
    images: Any = bpy.data.images
    missing = {image for image in images if image.users and _is_missing(image)}
    if not missing:
        return
    users = bpy.data.user_map(subset=missing)
    for image in sorted(missing, key=lambda image: image.name):
        if any(user.id_type in _SHADING for user in users[image]):
            yield (f"image '{image.name}' is missing, and shows magenta: put {image.filepath} back")


def _is_missing(image: Any) -> bool:
    if (
        image.source not in ("FILE", "TILED")
        or image.packed_file
        or len(image.packed_files)
        or image.is_dirty
    ):
        return False
    path = bpy.path.abspath(image.filepath_raw, library=image.library)
    for tile in image.tiles[:1]:
        path = path.replace("<UDIM>", str(tile.number))
    return not Path(path).is_file()


def _missing_libraries() -> Iterator[str]:
    for library in bpy.data.libraries:
        here: Any = library
        if here.packed_file or getattr(here, "is_archive", False):
            continue
        if not Path(bpy.path.abspath(here.filepath)).is_file():
            yield f"library {here.filepath} is missing, and all that is linked from it: put it back"
