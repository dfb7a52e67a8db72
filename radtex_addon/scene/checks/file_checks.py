# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Find missing files and failed drivers, because of which the open file renders differently than intended.

File paths that lead to pipes or devices are refused: Blender would wait for a pipe for ever.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, cast

import bpy

from ...core.errors import InputError
from ...core.messages import Message, Setting, do
from ...formats.disk.regular import FOLDER, other_kind

_SHADING = ("MATERIAL", "WORLD", "LIGHT", "NODETREE", "TEXTURE")  # users of images that renders look at


def check_outside_files() -> None:
    """Raise InputError, which names the data-block, if its file is a pipe, a device or a socket."""
    owner: Any
    for owner, paths in cast(Any, bpy.data).file_path_map().items():
        for written in sorted(paths):
            path = bpy.path.abspath(written, library=owner.library)
            kind = other_kind(Path(path))
            if kind not in (None, FOLDER):  # caches are folders
                raise InputError(
                    f"{owner.bl_rna.name.lower()} '{owner.name}' names {path}, which is {kind} and no file: "
                    "put a file there, or take it out of the scene"
                )


def file_warnings() -> list[Message]:
    """Warnings about failed drivers, missing images and missing libraries; empty if all is well."""
    return [*failed_drivers(), *map(Message, _missing_images()), *map(Message, _missing_libraries())]


def failed_drivers(owners: Iterable[Any] | None = None) -> Iterator[Message]:
    """A warning if the Python of drivers was not run, or failed, when their owners were last evaluated.

    By default the owners are all data-blocks of the file, as the viewport evaluated them. Given the evaluated
    `owners` of a render, drivers that fail in the viewport too are not reported again.
    """
    everything = _all() if owners is None else (one for one in owners if not any(_failed(one.original)))
    found = [(owner, curve) for owner in everything if not owner.is_embedded_data for curve in _failed(owner)]
    if not found:
        return
    curve = found[0][1]
    names = list(dict.fromkeys(f"{owner.bl_rna.name.lower()} '{owner.name}'" for owner, _ in found))
    others = f", as are those of {', '.join(names[1:5])}" if len(names) > 1 else ""
    yield Message(
        f"the driver of {curve.data_path} of {names[0]} has no value ('{curve.driver.expression}')"
        f"{others}, for a .blend's Python is not run unless you allow it",
        (do("allow it", Setting.SCRIPTS), do("drive by plain maths"), do("bake the driver to keyframes")),
    )


def _all() -> Iterator[Any]:
    """Yield every data-block of the open file once."""
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
