# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Fix image sequences at one frame."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, cast

import bpy

from ..core.errors import InputError

_KEPT = ("alpha_mode", "use_half_precision", "use_view_as_render")


def hold_images(scene: bpy.types.Scene) -> None:
    """Replace image sequences in nodes by the files of the scene's current frame.

    Raises InputError for movies, for a sequence without that file, and for nodes that read the frame number.
    """
    for tree in _trees():
        for node in tree.nodes:
            if node.type in {"TEX_IMAGE", "TEX_ENVIRONMENT"} and node.image is not None:
                _hold(node, scene.frame_current)
            elif _reads_frame(node):
                raise InputError(
                    f"node '{node.name}' of '{tree.name}' reads the scene's {node.attribute_name}: "
                    "put a number in its place, for a farm's frames are no time"
                )


def _hold(node: Any, frame: int) -> None:
    image = node.image
    if image.source == "MOVIE":
        raise InputError(f"image '{image.name}' is a movie: save the picture that is meant, and show that")
    if image.source != "SEQUENCE":
        return
    path = _file_at(Path(bpy.path.abspath(image.filepath, library=image.library)), node.image_user, frame)
    if not path.is_file():
        raise InputError(
            f"{path} is not there, which image '{image.name}' shows at frame {frame}: put it back"
        )
    still: Any = bpy.data.images.load(str(path))
    cast(Any, still.colorspace_settings).name = image.colorspace_settings.name
    for name in _KEPT:
        setattr(still, name, getattr(image, name))
    node.image = still


def _reads_frame(node: Any) -> bool:
    return node.type == "ATTRIBUTE" and node.attribute_type == "VIEW_LAYER" and "frame" in node.attribute_name


def _file_at(first: Path, user: Any, frame: int) -> Path:
    """The file of a sequence at a frame: like Blender, counts by the last number in the name."""
    number = frame - user.frame_start + 1
    if user.use_cyclic:
        number = (number - 1) % max(user.frame_duration, 1) + 1
    number = min(max(number, 0), user.frame_duration) + user.frame_offset
    found = re.fullmatch(r"(.*?)(\d+)(\D*)", first.name)
    if found is None:
        return first
    return first.with_name(f"{found[1]}{number:0{len(found[2])}d}{found[3]}")


def _trees() -> Iterator[Any]:
    data = bpy.data
    for kind in (data.materials, data.worlds, data.lights):
        yield from (block.node_tree for block in cast(Any, kind) if block.node_tree is not None)
    yield from data.node_groups
