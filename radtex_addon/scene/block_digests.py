# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials, lights, worlds, their node groups, images and files, as text and as digests.

Names of data-blocks, what only editors and the viewport show, and settings of other add-ons are left out.
"""

from __future__ import annotations

import hashlib
import os
import warnings
from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ..core.near_digest import DIGEST, hash_of
from ..formats.disk.regular import open_regular

_WHOLE = 64 << 20  # bytes: of larger files only evenly spaced slices are read
_SLICES = 64
_DEPTH = 4  # levels of settings within settings, such as the points of a curve
_CYCLES = "cycles"  # the one group of settings that an add-on registers and that renders go by
# Properties that do not change renders.
_IDLE = frozenset(
    (
        "animation_data",
        "asset_data",
        "bl_rna",
        "inputs",
        "interface",
        "internal_links",
        "is_runtime_data",
        "library",
        "library_weak_reference",
        "original",
        "outputs",
        "override_library",
        "paint_active_slot",
        "paint_clone_slot",
        "parent",
        "preview",
        "rna_type",
        "select",
        "tag",
        "texture_paint_images",
        "texture_paint_slots",
        "use_extra_user",
        "use_fake_user",
    )
)
_IDLE_OF_BLOCKS = _IDLE | {"name"}
# Properties of materials with nodes that only the viewport shows.
_IDLE_OF_MATERIALS = _IDLE | {
    "diffuse_color",
    "grease_pencil",
    "lineart",
    "metallic",
    "name",
    "roughness",
    "specular_color",
    "specular_intensity",
}
# Properties of nodes that do not change renders, such as their place in the editor.
_IDLE_OF_NODES = _IDLE | {
    "color",
    "height",
    "hide",
    "label",
    "location",
    "location_absolute",
    "show_options",
    "show_preview",
    "show_texture",
    "use_custom_color",
    "width",
    "width_hidden",
}


def digest_of(texts: Iterable[str]) -> str:
    """One digest of texts in this order."""
    return DIGEST + hash_of(texts)


def block_settings(block: bpy.types.ID | None) -> Iterator[str]:
    """Yield the settings of a data-block as text, with its node groups and images; nothing for None."""
    yield from _walk(block, {})


def _walk(struct: Any, seen: dict[str, int], depth: int = _DEPTH) -> Iterator[str]:
    """Yield the settings of a data-block, or of a part of one; of data-blocks `seen` only their number."""
    if struct is None:
        return
    if isinstance(struct, bpy.types.ID):
        name = f"{type(struct).__name__} {struct.name_full}"
        known = name in seen
        yield f"{type(struct).__name__} {seen.setdefault(name, len(seen))}"
        if known:
            return
    if isinstance(struct, bpy.types.Image):
        yield _of_image(struct)
        return
    if isinstance(struct, bpy.types.NodeTree):
        yield from _walk_tree(struct, seen)
        return
    idle = _idle_of(struct)
    ours = isinstance(struct, bpy.types.ID)
    for prop in struct.bl_rna.properties:
        if prop.identifier in idle or prop.identifier.startswith("bl_"):
            continue
        if ours and prop.is_runtime and prop.identifier != _CYCLES:  # of another add-on, if that is on
            continue
        with warnings.catch_warnings(action="ignore"):  # reading properties that Blender 6 will remove
            value = getattr(struct, prop.identifier, None)
        yield from _walk_property(prop, value, seen, depth)


def _idle_of(struct: Any) -> frozenset[str]:
    """Names of a struct's properties that do not change renders."""
    if isinstance(struct, bpy.types.Node):
        return _IDLE_OF_NODES
    if isinstance(struct, bpy.types.Material) and _has_nodes(struct):
        return _IDLE_OF_MATERIALS
    return _IDLE_OF_BLOCKS if isinstance(struct, bpy.types.ID) else _IDLE


def _has_nodes(material: bpy.types.Material) -> bool:
    """Whether a material shows its nodes, as all do from Blender 5.0 on."""
    return material.node_tree is not None and (bpy.app.version >= (5, 0, 0) or material.use_nodes)


def _walk_property(prop: Any, value: Any, seen: dict[str, int], depth: int) -> Iterator[str]:
    if prop.type == "COLLECTION":
        if depth:
            for item in value or ():
                yield from _walk(item, seen, depth - 1)
    elif prop.type == "POINTER":
        yield from _walk_pointer(prop.identifier, value, seen, depth)
    elif not prop.is_readonly or prop.identifier == "type":
        yield f"{prop.identifier} {setting(value)!r}"


def _walk_pointer(name: str, value: Any, seen: dict[str, int], depth: int) -> Iterator[str]:
    if isinstance(value, bpy.types.NodeTree | bpy.types.Image):
        yield from _walk(value, seen)
    elif isinstance(value, bpy.types.Text):
        yield value.as_string()
    elif isinstance(value, bpy.types.Object):  # texture coordinates are relative to its place
        yield f"{name} {setting(value.matrix_world)}"
    elif isinstance(value, bpy.types.ID):
        yield f"{name} {value.name_full}"
    elif depth:
        yield from _walk(value, seen, depth - 1)


def _walk_tree(tree: bpy.types.NodeTree, seen: dict[str, int]) -> Iterator[str]:
    for node in sorted(tree.nodes, key=lambda node: node.name):
        yield node.bl_idname
        yield from _walk(node, seen)
        if path := getattr(node, "filepath", ""):  # of an OSL script or an IES file
            yield file_digest(Path(bpy.path.abspath(path, library=tree.library)))
        for socket in (*node.inputs, *node.outputs):
            default = getattr(socket, "default_value", None)
            value = default.name_full if isinstance(default, bpy.types.ID) else setting(default)
            yield f"{socket.identifier} {value!r}"
    yield from sorted(map(_of_link, tree.links))


def _of_link(link: bpy.types.NodeLink) -> str:
    ends = (link.from_node, link.from_socket), (link.to_node, link.to_socket)
    return " ".join(f"{node and node.name}.{socket and socket.identifier}" for node, socket in ends)


def _of_image(image: bpy.types.Image) -> str:
    """An image's settings and contents; its path and date may differ, as in a copy of the scene.

    The size is left out: asking for it loads the image.
    """
    settings = (image.source, image.colorspace_settings.name, image.alpha_mode)
    generated = f"{image.generated_type} {setting(image.generated_color)}"
    generated += f" {image.generated_width} {image.generated_height}" if image.source == "GENERATED" else ""
    return f"{settings} {image_contents(image)} {generated}"


def setting(value: Any) -> Any:
    """A property's value in Python's own types; vectors and the like become lists of numbers."""
    if value is None or isinstance(value, str | bytes | int | float):
        return value
    if isinstance(value, set):
        return sorted(value)
    try:
        return np.array(value).tolist()
    except (TypeError, ValueError):
        return str(type(value))


def file_digest(path: Path) -> str:
    """Digest of a file's size and contents (of large files only slices); "" if it cannot be read."""
    with suppress(OSError), open_regular(path) as file:
        size = os.fstat(file.fileno()).st_size
        state = hashlib.sha256(str(size).encode())
        for start, length in _slices(size):
            file.seek(start)
            state.update(file.read(length))
        return DIGEST + state.hexdigest()
    return ""


def image_contents(image: Any) -> str:
    """Digests of the pixels of a `bpy.types.Image`: painted and not saved, packed, or in its files."""
    if image.is_dirty and image.source in {"FILE", "GENERATED"} and image.size[0]:
        pixels = np.empty(image.size[0] * image.size[1] * image.channels, dtype=np.float32)
        image.pixels.foreach_get(pixels)
        return DIGEST + hashlib.sha256(pixels.tobytes()).hexdigest()
    packed = [file.packed_file.data for file in image.packed_files if file.packed_file]
    if packed:
        return " ".join(hashlib.sha256(data).hexdigest() for data in packed)
    path = bpy.path.abspath(image.filepath, library=image.library)
    numbers = [str(tile.number) for tile in image.tiles] if image.source == "TILED" else [""]
    return " ".join(file_digest(Path(path.replace("<UDIM>", number))) for number in numbers)


def _slices(size: int) -> Iterator[tuple[int, int]]:
    if size <= _WHOLE:
        yield 0, size
        return
    length = _WHOLE // _SLICES
    for number in range(_SLICES):
        yield (size - length) * number // (_SLICES - 1), length
