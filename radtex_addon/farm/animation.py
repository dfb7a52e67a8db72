# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Read animated properties at one frame, and fix them and image sequences there."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import bpy

from ..core.errors import InputError

_KEPT = ("alpha_mode", "use_half_precision", "use_view_as_render")
_OF_IMAGES = ("TEX_IMAGE", "TEX_ENVIRONMENT")  # nodes
_EMBEDDED = ("node_tree", "shape_keys")  # parts of data-blocks, with animation of their own


def hold_images(scene: bpy.types.Scene) -> None:
    """Replace image sequences in nodes by the files of the scene's current frame.

    Raises InputError for movies, for a sequence without that file, and for nodes that read the frame number.
    """
    for tree in _trees():
        for node in tree.nodes:
            if node.type in _OF_IMAGES and node.image is not None:
                _hold(node, scene.frame_current)
            elif _reads_frame(node):
                raise InputError(
                    f"node '{node.name}' of '{tree.name}' reads the scene's {node.attribute_name}: "
                    "put a number in its place, for a farm's frames are no time"
                )


def hold_sequences(frames: Collection[int]) -> None:
    """Replace image sequences in nodes by the files of the only one of the `frames`.

    Raises InputError for movies, for a sequence without that file, and for sequences where there are several
    frames: no .blend holds them.
    """
    for tree in _trees():
        for node in tree.nodes:
            if node.type not in _OF_IMAGES or node.image is None:
                continue
            if node.image.source == "SEQUENCE" and len(frames) > 1:
                raise InputError(
                    f"image '{node.image.name}' is a sequence, of which a farm carries one picture: "
                    "prepare each frame by itself"
                )
            _hold(node, min(frames))


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


@dataclass(frozen=True, eq=False)
class Values:
    """Values of a data-block's animated properties, by path."""

    owner: Any
    by_path: dict[str, Any]


def animated_values(depsgraph: bpy.types.Depsgraph) -> list[Values]:
    """All animated and driven properties of the data that a dependency graph has evaluated."""
    found = []
    for evaluated in depsgraph.ids:
        original: Any = evaluated.original
        animation = getattr(original, "animation_data", None)
        if animation is None:
            continue
        values = {}
        for path in _paths(animation):
            try:
                value = evaluated.path_resolve(path)
            except ValueError:  # an action tells of what other data-blocks have, too
                continue
            values[path] = value[:] if hasattr(value, "__getitem__") and not isinstance(value, str) else value
        found.append(Values(original, values))
    return found


def hold(values: Iterable[Values]) -> None:
    """Fix properties at these values, and remove all animation from the open file."""
    for block in _blocks():
        block.animation_data_clear()
    for some in values:
        for path, value in some.by_path.items():
            _assign(some.owner, path, value)


def curves_of(animated: Any) -> list[Any]:
    """The curves of a data-block's action."""
    data = animated.animation_data
    return [] if data is None or data.action is None else list(_curves(data.action))


def _assign(owner: Any, path: str, value: Any) -> None:
    if path.endswith('"]'):
        place, _, key = path[:-2].rpartition('["')
        (owner.path_resolve(place) if place else owner)[key] = value
        return
    place, _, name = path.rpartition(".")
    of = owner.path_resolve(place) if place else owner
    if not of.is_property_readonly(name):
        setattr(of, name, value)


def _paths(animation: Any) -> set[str]:
    actions = [animation.action, *(strip.action for strip in _strips(animation.nla_tracks))]
    paths = {curve.data_path for action in actions if action is not None for curve in _curves(action)}
    return paths | {driver.data_path for driver in animation.drivers}


def _strips(tracks: Iterable[Any]) -> Iterator[Any]:
    for track in tracks:
        for strip in track.strips:
            yield strip
            yield from strip.strips  # of a meta strip


def _curves(action: Any) -> Iterator[Any]:
    for layer in action.layers:
        for strip in layer.strips:
            for bag in strip.channelbags:
                yield from bag.fcurves


def _blocks() -> Iterator[Any]:
    for kind in bpy.data.bl_rna.properties:
        if kind.type != "COLLECTION" or kind.identifier in {"all_ids", "libraries"}:
            continue
        for block in getattr(bpy.data, kind.identifier):
            parts = [getattr(block, name, None) for name in _EMBEDDED]
            yield from (each for each in (block, *parts) if hasattr(each, "animation_data_clear"))
