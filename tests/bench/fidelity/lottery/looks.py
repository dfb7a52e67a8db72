# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials drawn by chance from broad ranges of the Principled shader's inputs."""

from __future__ import annotations

from typing import Any, cast

import bpy
import numpy as np

from ..scenes.materials import assign, connect, principled, shader
from ..scenes.meshes import Points, places

Colour = tuple[float, float, float]

_GLASS = 1 / 8  # of the objects


def dress(item: bpy.types.Object, rng: np.random.Generator) -> None:
    """Give an object one to three materials, those in bands across it."""
    if rng.random() < _GLASS:
        assign(item, _glass(rng))
        return
    count = int(rng.choice([1, 2, 3], p=[0.6, 0.25, 0.15]))
    for _ in range(count):
        material = draw_material(rng)
        assign(item, material)
    axis = rng.normal(0, 1, 3)
    repeats = int(rng.integers(1, 3))
    if count > 1:
        mesh = cast(bpy.types.Mesh, item.data)
        across = _middles(mesh, places(item)) @ axis
        share = (across - across.min()) / max(float(np.ptp(across)), 1e-9)
        band = np.minimum(share * count * repeats, count * repeats - 1).astype(np.int32) % count
        mesh.polygons.foreach_set("material_index", band)


def _middles(mesh: bpy.types.Mesh, place: Points) -> Points:
    """The mean of each face's vertices, (F, 3)."""
    return np.array([place[np.array(cast(Any, face).vertices)].mean(axis=0) for face in mesh.polygons])


def draw_material(rng: np.random.Generator) -> bpy.types.Material:
    """A material that lets no light through."""
    kinds = (_metal, _metal, _metal, draw_plain, _coated, _coated, _sheen, _waxy)
    material = kinds[rng.integers(len(kinds))](rng)
    chances = rng.random(4)
    if chances[0] < 0.35:
        pattern(material, rng, "Object", scale=float(rng.uniform(1, 4)))
    if chances[1] < 0.2:
        _vary_roughness(material, rng)
    if chances[2] < 0.1:
        _bump(material, rng)
    if chances[3] < 0.1:
        _set(material, Thin_Film_Thickness=float(rng.uniform(200, 800)), Thin_Film_IOR=1.35)
    return material


def draw_plain(rng: np.random.Generator) -> bpy.types.Material:
    """A dielectric of some colour and roughness."""
    return principled("Plain", _colour(rng), Roughness=float(rng.uniform(0.05, 0.9)))


def _metal(rng: np.random.Generator) -> bpy.types.Material:
    tint = _mixed((0.9, 0.9, 0.9), _colour(rng), float(rng.choice([0.0, 0.3, 0.6])))
    roughness = float(np.exp(rng.uniform(np.log(0.03), np.log(0.6))))
    metal = principled("Metal", tint, Metallic=1.0, Roughness=roughness)
    if rng.random() < 0.25:
        _set(metal, Anisotropic=float(rng.uniform(0.3, 0.9)), Roughness=max(roughness, 0.15))
        tree: Any = metal.node_tree
        tangent = tree.nodes.new("ShaderNodeTangent")
        tangent.direction_type, tangent.axis = "RADIAL", str(rng.choice(["X", "Y", "Z"]))
        connect(metal, "Tangent", tangent.outputs["Tangent"])
    return metal


def _coated(rng: np.random.Generator) -> bpy.types.Material:
    coat = float(np.exp(rng.uniform(np.log(0.01), np.log(0.3))))
    base = {"Roughness": float(rng.uniform(0.2, 0.8)), "Metallic": float(rng.random() < 0.3)}
    return principled("Coated", _colour(rng), Coat_Weight=1.0, Coat_Roughness=coat, **base)


def _sheen(rng: np.random.Generator) -> bpy.types.Material:
    weight = float(rng.uniform(0.3, 1))
    return principled("Sheen", _colour(rng), Roughness=0.8, Sheen_Weight=weight, Sheen_Roughness=0.4)


def _waxy(rng: np.random.Generator) -> bpy.types.Material:
    radius = rng.uniform(0.05, 1, 3).tolist()
    inputs = {
        "Subsurface_Weight": float(rng.uniform(0.2, 1)),
        "Subsurface_Scale": float(rng.uniform(0.05, 0.3)),
    }
    return principled(
        "Wax", _colour(rng), Roughness=float(rng.uniform(0.2, 0.6)), Subsurface_Radius=radius, **inputs
    )


def _glass(rng: np.random.Generator) -> bpy.types.Material:
    tint = _mixed((1, 1, 1), _colour(rng), float(rng.choice([0.0, 0.0, 0.25])))
    roughness = float(rng.choice([0.0, 0.03, rng.uniform(0.05, 0.3)]))
    index = float(rng.uniform(1.3, 1.7))
    return principled("Glass", tint, Transmission_Weight=1.0, IOR=index, Roughness=roughness)


def _colour(rng: np.random.Generator) -> Colour:
    """A linear colour that is neither black nor white."""
    hue, strength, value = (
        rng.random(),
        rng.uniform(0, 1) ** 0.5,
        np.exp(rng.uniform(np.log(0.12), np.log(0.85))),
    )
    wheel = np.clip(np.abs((hue + np.array([0, 2 / 3, 1 / 3])) % 1 * 6 - 3) - 1, 0, 1)
    red, green, blue = (value * (1 - 0.96 * strength * (1 - wheel))).tolist()
    return red, green, blue


def _mixed(first: Colour, second: Colour, share: float) -> Colour:
    red, green, blue = ((1 - share) * a + share * b for a, b in zip(first, second, strict=True))
    return red, green, blue


def pattern(material: bpy.types.Material, rng: np.random.Generator, space: str, scale: float) -> None:
    """Colour a material in a pattern over an output of the texture coordinates, with clear or soft edges."""
    tree: Any = material.node_tree
    kind = ("Checker", "Wave", "Noise", "Voronoi")[rng.integers(4)]
    node = tree.nodes.new(f"ShaderNodeTex{kind}")
    node.inputs["Scale"].default_value = scale
    tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs[space], node.inputs["Vector"])
    ramp = tree.nodes.new("ShaderNodeValToRGB")
    ramp.color_ramp.interpolation = str(rng.choice(["CONSTANT", "LINEAR"]))
    elements = ramp.color_ramp.elements
    elements[0].position, elements[1].position = 0.35, float(rng.uniform(0.45, 0.6))
    for element in elements:
        element.color = (*_colour(rng), 1)
    value = {"Checker": "Fac", "Wave": "Fac", "Noise": 0, "Voronoi": "Distance"}[kind]
    tree.links.new(node.outputs[value], ramp.inputs["Fac"])
    connect(material, "Base Color", ramp.outputs["Color"])


def _vary_roughness(material: bpy.types.Material, rng: np.random.Generator) -> None:
    low, high = sorted(rng.uniform(0.05, 0.7, 2).tolist())
    tree: Any = material.node_tree
    span = tree.nodes.new("ShaderNodeMapRange")
    for name, value in (("From Min", 0.35), ("From Max", 0.65), ("To Min", low), ("To Max", high)):
        span.inputs[name].default_value = value
    tree.links.new(_noise(tree, float(rng.uniform(1, 6))), span.inputs["Value"])
    connect(material, "Roughness", span.outputs["Result"])


def _bump(material: bpy.types.Material, rng: np.random.Generator) -> None:
    tree: Any = material.node_tree
    bump = tree.nodes.new("ShaderNodeBump")
    bump.inputs["Strength"].default_value = float(rng.uniform(0.1, 0.5))
    bump.inputs["Distance"].default_value = 0.1
    tree.links.new(_noise(tree, float(rng.uniform(3, 12))), bump.inputs["Height"])
    connect(material, "Normal", bump.outputs["Normal"])


def _noise(tree: Any, scale: float) -> Any:
    noise = tree.nodes.new("ShaderNodeTexNoise")
    noise.inputs["Scale"].default_value = scale
    tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["Object"], noise.inputs["Vector"])
    return noise.outputs[0]


def _set(material: bpy.types.Material, **inputs: float) -> None:
    """Set inputs of a material's Principled node; blanks as underscores."""
    node = shader(material)
    for name, value in inputs.items():
        node.inputs[name.replace("_", " ")].default_value = value
