# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials of Principled shaders, and patterns of colour."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, cast

import bpy
import numpy as np
import numpy.typing as npt

Pixels = npt.NDArray[np.float64]


def assign(item: bpy.types.Object, material: bpy.types.Material) -> None:
    """Append a material to an object's slots."""
    cast(bpy.types.Mesh, item.data).materials.append(material)


def principled(name: str, colour: tuple[float, float, float], **inputs: object) -> bpy.types.Material:
    """A material of one Principled shader; inputs by name, blanks as underscores."""
    material = bpy.data.materials.new(name)
    if material.node_tree is None:
        material.use_nodes = True
    node = shader(material)
    node.inputs["Base Color"].default_value = (*colour, 1)
    for key, value in inputs.items():
        node.inputs[key.replace("_", " ")].default_value = value
    return material


def shader(material: bpy.types.Material) -> Any:
    """A material's Principled node."""
    return next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")


def connect(material: bpy.types.Material, name: str, socket: Any) -> None:
    """Feed an input of a material's Principled node by a socket."""
    cast(Any, material.node_tree).links.new(socket, shader(material).inputs[name])


def translucent(material: bpy.types.Material, share: float, alpha: Any = None) -> None:
    """Let a share of the light that a surface scatters pass through it, of the colour of its Principled node.

    The alpha of that node, or the socket `alpha`, then counts for all of it.
    """
    tree: Any = material.node_tree
    node = shader(material)
    opacity = node.inputs["Alpha"].default_value
    node.inputs["Alpha"].default_value = 1
    through, mixed = tree.nodes.new("ShaderNodeBsdfTranslucent"), tree.nodes.new("ShaderNodeMixShader")
    colour = node.inputs["Base Color"]
    through.inputs["Color"].default_value = colour.default_value
    if colour.links:
        tree.links.new(colour.links[0].from_socket, through.inputs["Color"])
    mixed.inputs[0].default_value = share
    tree.links.new(node.outputs[0], mixed.inputs[1])
    tree.links.new(through.outputs[0], mixed.inputs[2])
    clear, shown = tree.nodes.new("ShaderNodeBsdfTransparent"), tree.nodes.new("ShaderNodeMixShader")
    shown.inputs[0].default_value = opacity
    if alpha is not None:
        tree.links.new(alpha, shown.inputs[0])
    tree.links.new(clear.outputs[0], shown.inputs[1])
    tree.links.new(mixed.outputs[0], shown.inputs[2])
    output = next(node for node in tree.nodes if node.type == "OUTPUT_MATERIAL")
    tree.links.new(shown.outputs[0], output.inputs["Surface"])


def texture(material: bpy.types.Material, name: str, pixels: Pixels, data: bool = False) -> Any:
    """An image texture node over the UV map, of pixels (H, W, 3 or 4) whose rows run from the bottom.

    Pixels are display values (sRGB), or with `data` plain numbers.
    """
    height, width, channels = pixels.shape
    image = bpy.data.images.new(name, width, height, alpha=channels == 4, is_data=data)
    filled = np.ones((height, width, 4), dtype=np.float32)
    filled[..., :channels] = pixels
    cast(Any, image.pixels).foreach_set(filled.ravel())
    image.update()
    image.pack()
    node = cast(Any, material.node_tree).nodes.new("ShaderNodeTexImage")
    node.image = image
    return node


def checker(tiles: float) -> bpy.types.Material:
    """Squares, light and dark, over the UV map."""
    material = principled("Checker", (0.4, 0.4, 0.4), Roughness=0.6)
    tree: Any = material.node_tree
    squares = tree.nodes.new("ShaderNodeTexChecker")
    squares.inputs["Color1"].default_value = (0.5, 0.49, 0.46, 1)
    squares.inputs["Color2"].default_value = (0.1, 0.1, 0.12, 1)
    squares.inputs["Scale"].default_value = tiles
    coordinates = tree.nodes.new("ShaderNodeTexCoord")
    tree.links.new(coordinates.outputs["UV"], squares.inputs["Vector"])
    tree.links.new(squares.outputs["Color"], shader(material).inputs["Base Color"])
    return material


def waves(tree: Any) -> Any:
    """A socket of wavy bands one above another."""
    wave = tree.nodes.new("ShaderNodeTexWave")
    wave.bands_direction = "Z"
    for key, value in (("Scale", 0.9), ("Distortion", 6.0), ("Detail", 1.0), ("Detail Scale", 1.6)):
        wave.inputs[key].default_value = value
    tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["Object"], wave.inputs["Vector"])
    return wave.outputs["Fac"]


def patches(tree: Any) -> Any:
    """A socket of smooth noise."""
    noise = tree.nodes.new("ShaderNodeTexNoise")
    for key, value in (("Scale", 2.2), ("Detail", 1.5), ("Distortion", 0.8)):
        noise.inputs[key].default_value = value
    tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["Object"], noise.inputs["Vector"])
    return noise.outputs[0]


def colour_by(
    material: bpy.types.Material, value: Any, steps: Sequence[tuple[float, tuple[float, float, float]]]
) -> None:
    """Colour a material by a value, in steps with clear edges: the colour from each position on."""
    tree: Any = material.node_tree
    ramp = tree.nodes.new("ShaderNodeValToRGB")
    ramp.color_ramp.interpolation = "CONSTANT"
    elements = ramp.color_ramp.elements
    while len(elements) < len(steps):
        elements.new(0.5)
    for element, (position, colour) in zip(elements, ((0.0, steps[0][1]), *steps[1:]), strict=True):
        element.position, element.color = position, (*colour, 1)
    tree.links.new(value, ramp.inputs["Fac"])
    tree.links.new(ramp.outputs["Color"], shader(material).inputs["Base Color"])
