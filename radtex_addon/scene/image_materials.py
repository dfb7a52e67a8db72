# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials that are texture sets: a Principled BSDF whose colour, metal, roughness and normal are images.

They are what glTF files hold, and what importers make of them. Whoever shows a bake can read such images
directly. A material with anything else in its nodes is none: its bake has maps of its own.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, cast

import bpy
import numpy as np

from ..core.arrays import Floats, Ints
from .mesh.copy import material_numbers

_WRAPS = ("REPEAT", "EXTEND", "MIRROR")  # what textures of engines do outside of 0 to 1
_NOT_THERE = (  # inputs that must be 0: they would need more than four maps
    *("Transmission Weight", "Subsurface Weight", "Coat Weight", "Sheen Weight", "Anisotropic"),
    *("Thin Film Thickness", "Thin Wall"),
)
_ALIKE = (
    "IOR",
    "Specular IOR Level",
    "Specular Tint",
    "Diffuse Roughness",
)  # one value each
_CHANNELS = {"Red": 0, "Green": 1, "Blue": 2}
_WHITE = (1.0, 1.0, 1.0)
MOST = 4096  # pixels along a side that are looked at


@dataclass(frozen=True)
class ImageSource:
    """An image of a material; `channel` is the one that is read (0 to 2), None for its colour or its grey.

    `wrap` is what is outside of 0 to 1: REPEAT, EXTEND or MIRROR.
    """

    image: bpy.types.Image
    wrap: str
    channel: int | None = None


@dataclass(frozen=True)
class ImageMaterial:
    """A material of images on the UV layer `uv_map`.

    `base`, `metallic` and `roughness` are what the images are multiplied by, or without an image the values.
    `normal` is a tangent-space normal map and `strength` Blender's. If it is `clear`, its alpha is not 1
    everywhere; with `base_alpha` it is the base image's.
    """

    uv_map: str
    base: tuple[float, float, float]
    base_image: ImageSource | None
    metallic: float
    metallic_image: ImageSource | None
    roughness: float
    roughness_image: ImageSource | None
    normal: ImageSource | None
    strength: float
    clear: bool = False
    base_alpha: bool = False

    @property
    def sources(self) -> tuple[ImageSource | None, ...]:
        """The images of colour, metal, roughness and normal."""
        return (self.base_image, self.metallic_image, self.roughness_image, self.normal)


class _Other(Exception):
    """The material is no texture set."""


def find_image_material(material: bpy.types.Material | None, active: str) -> ImageMaterial | None:
    """The images of a material that is a texture set, on a mesh whose `active` UV layer renders by default.

    None for any other material.
    """
    try:
        return None if material is None else _read(material, active)
    except _Other:
        return None


def _read(material: bpy.types.Material, active: str) -> ImageMaterial:
    tree = material.node_tree if bpy.app.version >= (5, 0) or material.use_nodes else None
    output: Any = tree.get_output_node("CYCLES") if tree else None
    if output is None or any(output.inputs[name].is_linked for name in ("Volume", "Displacement")):
        raise _Other
    shader, _ = _source(output.inputs["Surface"])
    if shader is None or shader.type != "BSDF_PRINCIPLED":
        raise _Other
    inputs = shader.inputs
    _check_plain(inputs)
    uses: set[str] = set()
    base, base_image = _colour(inputs["Base Color"], uses)
    metallic, metallic_image = _number(inputs["Metallic"], uses)
    roughness, roughness_image = _number(inputs["Roughness"], uses)
    normal, strength = _normal(inputs["Normal"], uses)
    clear, base_alpha = _alpha(inputs["Alpha"], base_image)
    layers = {layer or active for layer in uses}
    found = ImageMaterial(
        next(iter(layers), ""), base, base_image, metallic, metallic_image, roughness, roughness_image,
        normal, strength, clear, base_alpha,
    )  # fmt: skip
    if not any(found.sources) or len(layers) != 1:
        raise _Other
    return found


def _check_plain(inputs: Any) -> None:
    """Raise _Other if the shader has inputs other than a texture set's."""
    for name in (*_NOT_THERE, "Emission Strength", *_ALIKE):
        socket = inputs.get(name)
        if socket is not None and _source(socket)[0] is not None:
            raise _Other
    if any(name in inputs and inputs[name].default_value for name in _NOT_THERE):
        raise _Other
    emission = inputs["Emission Color"]
    black = _source(emission)[0] is None and not any(emission.default_value[:3])
    if inputs["Emission Strength"].default_value and not black:
        raise _Other


def _source(socket: Any) -> tuple[Any, Any]:
    """The node and socket that feed an input, past reroutes; None for both if it has its own value."""
    while socket.is_linked:
        (link,) = socket.links
        node, found = link.from_node, link.from_socket
        if node.mute or link.is_muted:
            raise _Other
        if node.type != "REROUTE":
            return node, found
        socket = node.inputs[0]
    return None, None


def _colour(socket: Any, uses: set[str]) -> tuple[tuple[float, float, float], ImageSource | None]:
    """A colour and the image that it is multiplied by; the image's UV layer is added to `uses`."""
    node, output = _source(socket)
    if node is None:
        return _rgb(socket.default_value), None
    if node.type == "TEX_IMAGE":
        if output.name != "Color":
            raise _Other
        return _WHITE, _image(node, uses, "sRGB")
    if node.type not in ("MIX", "MIX_RGB") or node.blend_type != "MULTIPLY":
        raise _Other
    if node.type == "MIX" and (node.data_type != "RGBA" or node.clamp_result):
        raise _Other
    factor, *pair = [each for each in node.inputs if each.enabled]
    if _source(factor)[0] is not None or factor.default_value != 1:
        raise _Other
    found = [_colour(each, uses) for each in pair]
    images = [image for _, image in found if image is not None]
    if len(images) > 1:
        raise _Other
    one, other = (colour for colour, _ in found)
    return _rgb([a * b for a, b in zip(one, other, strict=True)]), images[0] if images else None


def _number(socket: Any, uses: set[str]) -> tuple[float, ImageSource | None]:
    """A number and the channel of an image that it is multiplied by, as `_colour`."""
    node, output = _source(socket)
    if node is None:
        return float(socket.default_value), None
    if node.type == "TEX_IMAGE" and output.name == "Color":
        return 1.0, _image(node, uses, None)
    if node.type == "SEPARATE_COLOR" and node.mode == "RGB":
        image, colour = _source(node.inputs[0])
        if image is None or image.type != "TEX_IMAGE" or colour.name != "Color":
            raise _Other
        return 1.0, _image(image, uses, None, _CHANNELS[output.name])
    if node.type != "MATH" or node.operation != "MULTIPLY" or node.use_clamp:
        raise _Other
    found = [_number(each, uses) for each in node.inputs[:2]]
    images = [image for _, image in found if image is not None]
    if len(images) > 1:
        raise _Other
    return found[0][0] * found[1][0], images[0] if images else None


def _normal(socket: Any, uses: set[str]) -> tuple[ImageSource | None, float]:
    """The normal map and its strength; None and 0 without one."""
    node, _ = _source(socket)
    if node is None:
        return None, 0.0
    opengl = getattr(node, "convention", "OPENGL") == "OPENGL"  # the only one before Blender 5
    if node.type != "NORMAL_MAP" or node.space != "TANGENT" or not opengl:
        raise _Other
    strength, colour = node.inputs["Strength"], node.inputs["Color"]
    image, output = _source(colour)
    if _source(strength)[0] is not None or image is None or image.type != "TEX_IMAGE":
        raise _Other
    if output.name != "Color":
        raise _Other
    uses.add(node.uv_map)
    return _image(image, uses, None), max(float(strength.default_value), 0.0)


def _alpha(socket: Any, base: ImageSource | None) -> tuple[bool, bool]:
    """Whether the alpha is not 1, and whether it is that of the base image."""
    node, output = _source(socket)
    if node is None:
        return socket.default_value < 1, False
    same = node.type == "TEX_IMAGE" and output.name == "Alpha" and base is not None
    return True, same and node.image == cast(ImageSource, base).image


def _image(node: Any, uses: set[str], space: str | None, channel: int | None = None) -> ImageSource:
    """The image of a node, of a colour `space`, None for data; its UV layer is added to `uses`."""
    image: bpy.types.Image | None = node.image
    if image is None or image.source not in ("FILE", "GENERATED") or image.is_float:
        raise _Other
    if 0 in cast(Any, image.size):  # its file is missing
        raise _Other
    settings: Any = image.colorspace_settings
    if settings.name != space if space else not settings.is_data:
        raise _Other
    if node.projection != "FLAT" or node.interpolation != "Linear" or node.extension not in _WRAPS:
        raise _Other
    uses.add(_uv_layer(node.inputs["Vector"]))
    return ImageSource(image, node.extension, channel)


def _uv_layer(socket: Any) -> str:
    node, output = _source(socket)
    if node is None or (node.type == "TEX_COORD" and output.name == "UV" and not node.from_instancer):
        return ""
    if node.type != "UVMAP" or node.from_instancer:
        raise _Other
    return str(node.uv_map)


def _rgb(values: Any) -> tuple[float, float, float]:
    red, green, blue = (float(value) for value in values[:3])
    return red, green, blue


def image_materials(
    meshes: Iterable[tuple[bpy.types.Object, bpy.types.Mesh]],
) -> dict[int, ImageMaterial]:
    """The texture sets among the materials of baked copies, by the material's number in the atlas.

    `meshes` are the objects that are baked, and their copies' meshes with the materials that were baked.
    """
    found: dict[int, ImageMaterial | None] = {}
    for original, mesh in meshes:
        slots = [*cast(Any, mesh).materials] or [None]
        for slot, number in numbers_of_slots(mesh).items():
            material = slots[min(slot, len(slots) - 1)]
            images = find_image_material(material, _active_layer(original))
            if images is not None and images.uv_map not in cast(Any, mesh).uv_layers:
                images = None
            same = found.get(number, images)
            found[number] = images if images == same else None
    return {number: images for number, images in found.items() if images is not None}


def numbers_of_slots(mesh: Any) -> dict[int, int]:
    """The number in the atlas of the material in each slot that faces of a baked copy's mesh use."""
    index = np.empty(len(mesh.polygons), dtype=np.int32)
    mesh.polygons.foreach_get("material_index", index)
    pairs = np.unique(np.stack([index, material_numbers(mesh)], axis=1), axis=0).tolist()
    return dict(pairs)


def _active_layer(original: bpy.types.Object) -> str:
    """The UV layer that renders by default."""
    layers = cast(Any, original.data).uv_layers if isinstance(original.data, bpy.types.Mesh) else ()
    return next((layer.name for layer in layers if layer.active_render), "")


def pixels_of(image: bpy.types.Image) -> Floats:
    """An image's pixels as they are stored, (H, W, channels) float32, row 0 below; 0 x 0 if it is lost.

    One that is larger than MOST pixels along a side is scaled to that, so that it fits into memory.
    """
    width, height = cast(Any, image.size)
    if max(width, height) > MOST:
        copy: Any = image.copy()
        try:
            share = MOST / max(width, height)
            copy.scale(max(round(width * share), 1), max(round(height * share), 1))
            return pixels_of(copy)
        finally:
            bpy.data.images.remove(copy)
    pixels = np.empty((height, width, image.channels), dtype=np.float32)
    if pixels.size:
        cast(Any, image.pixels).foreach_get(pixels.ravel())
    return pixels


def looked_up(pixels: Floats, uv: Floats, wrap: str) -> Floats:
    """Bilinear lookup in an image (H, W, C) at uv (K, 2): (K, C), outside of 0 to 1 as `ImageSource.wrap`."""
    height, width = pixels.shape[:2]
    position = uv * np.array([width, height]) - 0.5
    corner = np.floor(position)
    fraction = (position - corner).astype(np.float32)
    total = np.zeros((len(uv), pixels.shape[2]), dtype=np.float32)
    for dy in (0, 1):
        for dx in (0, 1):
            column = _wrapped(corner[:, 0].astype(np.int64) + dx, width, wrap)
            row = _wrapped(corner[:, 1].astype(np.int64) + dy, height, wrap)
            share = np.where([dx, dy], fraction, 1 - fraction).prod(axis=1)
            total += share[:, None] * pixels[row, column]
    return total


def _wrapped(place: Ints, size: int, wrap: str) -> Ints:
    if wrap == "REPEAT":
        return place % size
    if wrap == "MIRROR":
        place = place % (2 * size)
        return np.minimum(place, 2 * size - 1 - place)
    return np.clip(place, 0, size - 1)
